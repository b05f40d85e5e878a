"""The unit tests mirror the tree, so that a module's test is found where its name says."""

from pathlib import Path

import pytest

from tests.support.imports import INSIDE, Sources
from tests.support.paths import ROOT
from weavesim.scenes.scene import known_scenes

# Shorter modules outside the kernels may be tested with what uses them.
LEAST_LENGTH = 60
BETWEEN_NODES = "verification/contact/test_between_nodes.py"
SHELL = "verification/element/test_energies.py"
PLIES = "verification/contact/test_plies.py"
WORLDS = "unit/engine/worlds/test_world_stepper.py"
CARRIED = "verification/process/test_carried_tools.py"
SELF_CONTACT = "verification/contact/test_self_contact.py"
MIRROR_IMAGE = "verification/contact/test_mirror_image.py"
# Modules whose test has another name, with the file that tests them.
TESTED_ELSEWHERE = {
    # A part of a kernel has no result of its own: forces against energies, patches and modes find its mistakes.
    "kernels/shell/bending.py": SHELL,
    "kernels/shell/energy.py": SHELL,
    "kernels/shell/force.py": SHELL,
    "kernels/shell/hourglass.py": SHELL,
    "kernels/shell/kinematics.py": "verification/element/test_patch.py",
    "kernels/laws/bending_curves.py": SHELL,
    "kernels/laws/contract.py": "unit/fabric/test_recipes.py",
    "kernels/laws/isotropic_bending.py": SHELL,
    "kernels/laws/linear_shear.py": SHELL,
    "kernels/laws/moment_curve.py": SHELL,
    "kernels/laws/shear_friction.py": "verification/shear/test_shear_friction.py",
    "kernels/laws/yarn_bending.py": SHELL,
    "kernels/shell/laws.py": SHELL,
    "kernels/shell/membrane.py": SHELL,
    "kernels/stepping/carried_contact.py": CARRIED,
    "kernels/carried/motion.py": CARRIED,
    "kernels/contact/carried_pose.py": CARRIED,
    "weavesim/tools/carried/device.py": CARRIED,
    "kernels/contact/opening_sector.py": "unit/tools/segments/test_opening.py",
    "weavesim/tools/segments/holder.py": "unit/scenes/test_dome_holder.py",
    "weavesim/job/segments/tables.py": "unit/job/segments/test_cutting.py",
    "weavesim/meshes/cad_process.py": "unit/meshes/test_cad.py",
    "kernels/contact/mesh_nearest.py": "unit/tools/surfaces/test_exact.py",
    "weavesim/tools/surfaces/distance.py": "unit/run/test_carried_tools.py",
    "kernels/loads/grippers.py": "verification/process/test_grippers.py",
    "weavesim/engine/loading/grips.py": "verification/process/test_grippers.py",
    "weavesim/engine/loading/load_launches.py": "verification/process/test_pressure.py",
    "kernels/loads/pressure.py": "verification/process/test_pressure.py",
    "kernels/shell/shear.py": SHELL,
    "kernels/shell/thickness.py": "verification/shell/test_thickness.py",
    "kernels/shell/extremes.py": "unit/run/watch/test_extremes.py",
    "kernels/shell/frequency.py": "verification/time/test_stable_step.py",
    "kernels/shell/coupling.py": "verification/time/test_stable_step.py",
    "kernels/shell/eigenvalue.py": "verification/time/test_stable_step.py",
    "kernels/operators.py": "unit/kernels/test_lanes.py",
    "kernels/cell/energies.py": "verification/cell/test_unit_cells.py",
    "kernels/cell/energy_cell.py": "verification/cell/test_unit_cells.py",
    "kernels/cell/iteration.py": "unit/kernels/cell/test_cell_formulas.py",
    "kernels/cell/lane_newton.py": "unit/kernels/cell/test_energy_lanes.py",
    "kernels/formula/builtins.py": "unit/kernels/formula/test_reader.py",
    "kernels/formula/values.py": "unit/kernels/formula/test_reader.py",
    "kernels/formula/functions.py": "unit/kernels/formula/test_writer.py",
    "kernels/cell/law.py": "verification/cell/test_unit_cells.py",
    "kernels/cell/yarn.py": "unit/kernels/cell/test_plain_weave.py",
    "kernels/cell/response.py": "verification/cell/test_unit_cells.py",
    "kernels/pass_entries.py": "unit/kernels/plies/test_collect.py",
    "kernels/plies/mirror.py": MIRROR_IMAGE,
    "kernels/creases/data.py": "unit/kernels/creases/test_pair.py",
    "kernels/creases/meet.py": "unit/kernels/creases/test_pair.py",
    "kernels/creases/pair_rows.py": "unit/kernels/creases/test_pair.py",
    "kernels/creases/search.py": "unit/engine/test_creases.py",
    "kernels/contact/friction.py": PLIES,
    "kernels/plies/argument.py": PLIES,
    "kernels/plies/data.py": PLIES,
    "kernels/plies/forces.py": PLIES,
    "kernels/plies/node_pass.py": PLIES,
    "kernels/plies/stand.py": PLIES,
    "kernels/plies/normals.py": PLIES,
    "kernels/plies/own_search.py": SELF_CONTACT,
    "kernels/plies/within.py": SELF_CONTACT,
    "kernels/worlds/arguments.py": WORLDS,
    "kernels/worlds/clocks.py": WORLDS,
    "kernels/worlds/sheets.py": WORLDS,
    "weavesim/engine/worlds/world_launches.py": WORLDS,
    "weavesim/run/interface_ledger.py": PLIES,
    "weavesim/run/guards/plies/interfaces.py": "unit/process/test_friction.py",
    "kernels/contact/fill_samples.py": "unit/tools/test_sampling.py",
    "kernels/contact/list_nearest.py": "unit/tools/samples/test_candidates.py",
    "kernels/contact/mesh_samples.py": "unit/tools/test_mesh_shape.py",
    "kernels/contact/nearest_triangle.py": "unit/tools/samples/test_candidates.py",
    "kernels/contact/penalty.py": "verification/contact/test_contact.py",
    "kernels/contact/tool_shapes.py": "unit/tools/test_shapes.py",
    "kernels/machine.py": "unit/engine/test_stepper.py",
    "kernels/stepping/node_advance.py": "unit/kernels/stepping/test_node.py",
    "kernels/stepping/node_data.py": "unit/kernels/stepping/test_node.py",
    "kernels/stepping/node_forces.py": "unit/kernels/stepping/test_node.py",
    "kernels/stepping/sample_data.py": BETWEEN_NODES,
    "kernels/stepping/surface_contact.py": BETWEEN_NODES,
    "kernels/stepping/surface_point.py": BETWEEN_NODES,
    "kernels/stepping/tool_contact.py": "unit/kernels/stepping/test_node.py",
    "kernels/stepping/step.py": "unit/engine/test_stepper.py",
    "kernels/stepping/supports.py": "verification/time/test_supports.py",
    "kernels/stepping/tools.py": "unit/tools/test_motion.py",
    "weavesim/meshes/formats/deck_lines.py": "unit/meshes/formats/test_abaqus.py",
    "weavesim/meshes/formats/grid.py": "unit/meshes/formats/test_abaqus.py",
    "weavesim/engine/surface/contact.py": BETWEEN_NODES,
    "weavesim/engine/surface/samples.py": BETWEEN_NODES,
    "weavesim/run/watch/tool_gaps.py": BETWEEN_NODES,
    "weavesim/engine/launches.py": "unit/engine/test_stepper.py",
    "weavesim/engine/replay.py": "unit/engine/test_stepper.py",
    "weavesim/engine/sheet_model.py": "unit/engine/test_model.py",
    "weavesim/sheet/sheet.py": "unit/run/test_simulation.py",
    "weavesim/fabric/cell/tape.py": "verification/cell/test_unit_cells.py",
    "weavesim/fabric/cell/weaves.py": "unit/fabric/test_weaves.py",
    "weavesim/fabric/device.py": "unit/kernels/test_curve.py",
    "weavesim/fabric/response.py": "verification/cell/test_cell_responses.py",
    "weavesim/output/curves.py": "unit/output/test_tables.py",
    "weavesim/output/paraview/sheets.py": "unit/output/paraview/test_series.py",
    "weavesim/output/files.py": "unit/output/test_folder.py",
    "weavesim/output/report/page.py": "unit/output/test_folder.py",
    "weavesim/job/overrides.py": "unit/job/test_read.py",
    "weavesim/job/placing.py": "unit/job/test_build.py",
    "weavesim/job/schema.py": "unit/job/test_read.py",
    "weavesim/job/stages/tables.py": "unit/job/stages/test_build.py",
    "weavesim/job/stages/told.py": "unit/job/test_check.py",
    "weavesim/job/surfaces.py": "unit/job/test_build.py",
    "weavesim/process/device.py": "unit/tools/test_motion.py",
    "kernels/stepping/tool_friction.py": "verification/contact/test_tool_friction.py",
    "weavesim/engine/surface/friction.py": "verification/contact/test_tool_friction.py",
    "weavesim/run/guards/friction/tables.py": "verification/contact/test_tool_friction.py",
    "weavesim/run/guards/friction/tools.py": "verification/contact/test_tool_friction.py",
    "weavesim/run/ledger.py": "verification/time/test_ledger_entries.py",
    "weavesim/run/guards/penetration.py": "unit/run/guards/test_limit.py",
    "weavesim/run/start.py": "unit/run/test_simulation.py",
    "weavesim/engine/staging/acting.py": "unit/engine/staging/test_derive.py",
    "weavesim/run/guards/staging/ends.py": "unit/run/test_staging.py",
    "weavesim/run/watch/crossing_record.py": "verification/contact/test_folds.py",
    "weavesim/run/touching.py": "verification/process/test_driven_tools.py",
    "weavesim/study/execution/executor.py": "unit/study/execution/test_processes.py",
    "weavesim/study/schema.py": "unit/study/test_read.py",
    "weavesim/tools/mesh_repair.py": "unit/tools/test_mesh_shape.py",
    "weavesim/tools/mesh_tool.py": "unit/tools/test_mesh_shape.py",
    "weavesim/tools/tool.py": "unit/tools/test_shapes.py",
}
TESTS = ROOT / "tests"


def own_test(module: str) -> Path | None:
    """The test of a module that is named as from the root of the checkout: its own, or that of its folder."""
    path = Path(module)
    parts = path.parts if path.parts[0] in INSIDE else path.parts[1:]
    folder = TESTS.joinpath("unit", *parts[:-1])
    places = [folder / f"test_{path.name}"]
    if len(parts) > 2 and parts[0] not in INSIDE:
        places.append(folder.with_name(f"test_{folder.name}.py"))
    return next((place for place in places if place.is_file()), None)


def modules() -> list[str]:
    """All modules that need their own test."""
    sources = Sources(ROOT)
    result = []
    for module, file in sources.file_of.items():
        path = file.relative_to(ROOT)
        if path.parts[0] in ("scenes", "scripts") or sources.is_package(module):
            continue
        if path.parts[0] == "kernels" or len(file.read_text().splitlines()) > LEAST_LENGTH:
            result.append(str(path))
    return result


MODULES = modules()


@pytest.mark.parametrize("module", MODULES)
def test_every_module_has_its_test(module):
    if module in TESTED_ELSEWHERE:
        assert (TESTS / TESTED_ELSEWHERE[module]).is_file()
        assert own_test(module) is None, f"{module} has its own test now: take it out of TESTED_ELSEWHERE"
    else:
        assert own_test(module)


def test_only_what_exists_is_tested_elsewhere():
    assert set(TESTED_ELSEWHERE) <= set(MODULES)


@pytest.mark.parametrize("scene", known_scenes().values(), ids=lambda scene: scene.module)
def test_every_scene_is_validated(scene):
    assert (TESTS / "validation" / f"test_{scene.module.rpartition('.')[2]}.py").is_file()
