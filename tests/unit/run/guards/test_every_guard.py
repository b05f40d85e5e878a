"""Every guard has a run that trips it, and a near miss that does not; here are those that stand nowhere else."""

import ast
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.support.judged import judged
from tests.support.paths import ROOT
from tests.support.runs import small_run
from tests.support.stacked_plies import FABRIC, THICKNESS, ply, run_stack, square
from weavesim import Drive, Pressure, Setup, Sheet, Stroke, Support, Tool
from weavesim.engine.model import Model
from weavesim.process import Coulomb
from weavesim.process.self_contact import SelfContact
from weavesim.run.diagnosis import LARGEST_PLY_PENETRATION
from weavesim.run.guards import Level, known_guards
from weavesim.sheet.blank import Blank
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import Sphere

UNIT, GUARDS, HERE = "tests/unit", "tests/unit/run/guards", "tests/unit/run/guards/test_every_guard.py"
NEAR = f"{GUARDS}/test_near_misses.py"
# By guard: a test in which it speaks, and one of a near miss in which it does not; one may do both.
PAIRS: dict[str, tuple[str, str]] = {
    "added_mass": (f"{NEAR}::test_added_mass",) * 2,
    "bending_length": (f"{UNIT}/scenes/test_coarse.py::test_a_cloth_needs_elements_along_its_bending_length",) * 2,
    "between_nodes": (
        f"{GUARDS}/test_between.py::test_a_tool_that_passes_between_nodes_is_told_before_and_seen_after",
        f"{HERE}::test_a_needle_between_nodes",
    ),
    "beyond_symmetry": (
        f"{GUARDS}/test_sheet.py::test_an_edge_that_crosses_its_symmetry_plane_is_seen",
        f"{GUARDS}/test_sheet.py::test_a_small_move_is_not_doubted",
    ),
    "bouncing_holder": (
        f"{GUARDS}/test_holder.py::test_one_without_a_damper_falls_and_bounces_and_is_doubted_with_its_numbers",
        f"{GUARDS}/test_holder.py::test_one_that_starts_in_touch_need_not_land",
    ),
    "closing_gap": (f"{GUARDS}/test_closing.py::test_the_gap_at_the_end_of_the_stroke_is_told_before",) * 2,
    "cut_short": (
        f"{GUARDS}/staging/test_cut_short.py::test_what_is_not_over_at_the_end_is_noted",
        f"{GUARDS}/staging/test_cut_short.py::test_what_is_over_is_silent",
    ),
    "damping_loss": (f"{NEAR}::test_damping",) * 2,
    "energy_balance": (f"{NEAR}::test_energy_balance",) * 2,
    "folded_elements": (f"{HERE}::test_a_strip_that_is_turned_back_over_itself",) * 2,
    "hourglass_energy": (f"{NEAR}::test_hourglass_energy",) * 2,
    "interfaces": (f"{HERE}::test_plies_that_are_pressed_into_each_other",) * 2,
    "inverted_elements": (f"{HERE}::test_a_strip_that_is_turned_back_over_itself",) * 2,
    "kinetic_energy": (f"{NEAR}::test_kinetic_energy",) * 2,
    "law_range": (f"{GUARDS}/test_law_range.py::test_a_sheet_sheared_beyond_the_data_says_so",) * 2,
    "narrow_tool": (
        f"{GUARDS}/test_between.py::test_a_tool_that_passes_between_nodes_is_told_before_and_seen_after",
        f"{GUARDS}/test_between.py::test_a_wide_tool_with_a_tip_that_comes_through_makes_a_result_useless",
    ),
    "never_touched": (
        f"{GUARDS}/test_touch.py::test_a_punch_that_misses_the_sheet_narrowly_is_seen_at_the_end",
        f"{GUARDS}/test_between.py::test_a_wide_round_tool_is_silent",
    ),
    "not_finite": (
        f"{NEAR}::test_a_state_that_is_not_finite_is_never_trusted",
        f"{NEAR}::test_a_state_that_is_merely_wild_is_finite",
    ),
    "penetration_at_nodes": (f"{NEAR}::test_penetration",) * 2,
    "penetration_of_surface": (f"{HERE}::test_a_needle_between_nodes",) * 2,
    "self_contact_mesh": (f"{HERE}::test_elements_that_are_large_for_self_contact",) * 2,
    "self_intersection": (f"{HERE}::test_a_strip_that_is_turned_back_over_itself",) * 2,
    "sharp_edges": (
        f"{GUARDS}/test_tool_mesh.py::test_sharp_edges_that_face_the_sheet_are_warned_of_with_their_number_and_place",
        f"{GUARDS}/test_tool_mesh.py::test_sharp_edges_beyond_the_sheet_are_not",
    ),
    "sheet_intersection": (
        f"{GUARDS}/test_sheet.py::test_sheets_of_one_world_that_pass_through_each_other_are_seen_and_those_of_two_are_not",
    ) * 2,
    "stage_ends": (
        f"{UNIT}/run/test_staging.py::test_rest_that_never_comes_is_said_with_time_and_advice",
        f"{UNIT}/run/test_staging.py::test_a_sheet_at_rest_ends_a_stage_after_three_looks",
    ),
    "start_of_stack": (
        f"{GUARDS}/test_sheet.py::test_a_small_overlap_is_doubted_and_a_large_one_refused",
        f"{GUARDS}/test_sheet.py::test_plies_that_rest_on_each_other_start_without_a_doubt",
    ),
    "start_overlap": (
        f"{UNIT}/run/test_simulation.py::test_a_tool_may_touch_the_blank_and_reach_a_little_into_it",
    ) * 2,
    "swinging_directors": (f"{HERE}::test_a_strip_that_twists_more_than_its_directors_bear",) * 2,
    "tool_friction": (
        "tests/verification/contact/test_tool_friction.py::test_use_beyond_a_table_is_told_with_place_and_time",
        "tests/verification/contact/test_tool_friction.py::test_a_sled_gives_the_law_of_its_table_back",
    ),
    "tool_meshes": (f"{HERE}::test_a_mesh_whose_distance_errs",) * 2,
    "tool_radius": (
        f"{GUARDS}/test_tool_mesh.py::test_a_radius_that_the_mesh_cannot_follow_is_warned_of",
        f"{GUARDS}/test_tool_mesh.py::test_nothing_is_said_of_a_large_radius",
    ),
    "tool_reach": (f"{GUARDS}/test_touch.py::test_a_punch_above_a_held_sheet_is_told_by_its_stroke",) * 2,
    "tool_symmetry": (
        f"{GUARDS}/symmetry/test_tools.py::test_a_tool_off_the_plane_is_refused_with_its_place_and_can_be_accepted",
        f"{GUARDS}/symmetry/test_tools.py::test_a_small_shift_is_within_the_tolerance",
    ),
    "tools_cross": (f"{GUARDS}/staging/test_crossing.py::test_a_ball_that_is_pressed_through_the_sheet",) * 2,
    "trims": (
        f"{UNIT}/output/test_trimmed_run.py::test_frames_have_no_values_of_waste",
        f"{HERE}::test_a_trim_along_edges_of_elements",
    ),
    "unit_cell": (f"{HERE}::test_a_cell_that_may_have_several_equilibria",) * 2,
    "unit_cell_failures": (f"{NEAR}::test_unit_cells_that_fail",) * 2,
    "unloading": (f"{GUARDS}/test_law_range.py::test_shear_that_goes_back_on_an_assumption_is_noted",) * 2,
    "waiting_stroke": (
        f"{GUARDS}/test_holder.py::test_a_stroke_stops_at_its_largest_force_and_says_so",
        f"{GUARDS}/test_holder.py::test_a_stroke_that_needs_less_than_its_largest_force_is_silent",
    ),
    "yarn_stretch": (
        f"{GUARDS}/test_stretch.py::test_a_pull_and_back_is_seen_with_any_number_of_frames",
        f"{GUARDS}/test_stretch.py::test_a_small_pull_is_not_doubted",
    ),
}  # fmt: skip


def test_no_guard_is_without_a_pair():
    assert set(PAIRS) == set(known_guards()), "every guard needs a run that trips it, and a near miss"


@pytest.mark.parametrize("reference", sorted({each for pair in PAIRS.values() for each in pair}))
def test_the_tests_of_the_pairs_are_there(reference):
    path, name = reference.split("::")
    functions = [node.name for node in ast.parse((ROOT / path).read_text()).body if isinstance(node, ast.FunctionDef)]
    assert name in functions


def found(run) -> dict:
    return {doubt.guard: doubt for doubt in run.doubts()}


def of(name: str, **start) -> list:
    """What a guard says before a run."""
    return list(known_guards()[name]().before(SimpleNamespace(**start)))


@pytest.mark.parametrize(("share", "level"), [(0.4, None), (0.6, Level.WARNING), (1.9, Level.WARNING), (2.1, 2)])
def test_a_needle_between_nodes(share, level):
    """It meets no node, and goes so many thicknesses into the sheet: half of one is as deep as its middle."""
    blank = Blank.rectangle((0.0, 0.0), (0.06, 0.06), 0.02)
    edge = Support("edge", np.arange(blank.node_count))
    radius = 0.003
    needle = Sphere(radius, origin=(0.03, 0.03, 0.5 * THICKNESS + radius))
    tool = Tool("needle", needle, Stroke((0.0, 1e-3), (0.0, share * THICKNESS)), axis=(0.0, 0.0, -1.0))
    run = small_run(blank=blank, supports=(edge,), tools=[tool], duration=1e-3, frame_count=1, accept_unusual=True)
    run.run()
    said = found(run)
    assert ("between_nodes" in said) == (share > 0.55)
    if level is None:
        assert "penetration_of_surface" not in said
        return
    doubt = said["penetration_of_surface"]
    assert doubt.level == level and doubt.value == pytest.approx(1e3 * share * THICKNESS, rel=0.02)
    assert doubt.sheet == "sheet" and doubt.place == pytest.approx((0.03, 0.03)) and 0.9e-3 < doubt.time < 1.1e-3


@pytest.mark.parametrize(("share", "trips"), [(1.4, False), (1.6, True)])
def test_elements_that_are_large_for_self_contact(share, trips):
    blank = Blank.rectangle((0.0, 0.0), (10 * share * THICKNESS,) * 2, share * THICKNESS)
    model = Model(Setup("fold", sheets=(Sheet(blank, FABRIC, self_contact=SelfContact()),), duration=1e-3))
    assert [doubt.level for doubt in of("self_contact_mesh", model=model)] == [Level.NOTE] * trips


@pytest.mark.parametrize(("share", "trips"), [(0.99, False), (1.01, True)])
def test_a_cell_that_may_have_several_equilibria(share, trips):
    cell = FABRIC.unit_cell.model_copy(
        update={"weft_compressive_stiffness": share * FABRIC.unit_cell.euler_stiffness[1]}
    )
    setup = small_run(fabric=FABRIC.model_copy(update={"unit_cell": cell})).setup
    doubts = of("unit_cell", model=SimpleNamespace(setup=setup))
    assert [(doubt.level, "weft" in doubt.text) for doubt in doubts] == [(Level.WARNING, True)] * trips


@pytest.mark.parametrize(("share", "trips"), [(0.095, False), (0.105, True)])
def test_a_mesh_whose_distance_errs(share, trips):
    import trimesh

    mesh = trimesh.creation.icosphere(radius=0.02)
    ball = MeshShape.from_triangles(mesh.vertices, mesh.faces, origin=(0.01, 0.01, -0.0206))
    run = small_run(tools=[Tool("ball", ball)])
    ((surface, sampled),) = run.model.samples.items()
    other = replace(sampled, usual_error=share * THICKNESS)
    start = SimpleNamespace(setup=run.setup, samples={surface: other})
    doubts = of("tool_meshes", model=start)
    assert [doubt.level for doubt in doubts] == [Level.WARNING] * trips
    if trips:
        assert doubts[0].value == pytest.approx(share) and "10.5 % of the sheet's thickness" in doubts[0].text


@pytest.mark.parametrize(("share", "trips"), [(0.85, False), (1.15, True)])
def test_plies_that_are_pressed_into_each_other(share, trips):
    """By a pressure that is gone at the end: the worst of all looks counts, and says when it was."""

    def run(pressure: float, duration: float):
        pressed = {"pressures": (0.0, pressure, 0.0), "times": (0.0, 0.5 * duration, 0.8 * duration)}
        sheets = [
            ply("lower", square(0.01, 0.005), pressures=(Pressure("bottom", **pressed),)),
            ply("upper", square(0.01, 0.005, THICKNESS), pressures=(Pressure("top", **pressed),)),
        ]
        return run_stack(sheets, Coulomb(0.0), duration=duration, dynamics={"contact_damping_ratio": 0.3})

    model = run(1.0, 1e-7).model.passes[0]
    largest = LARGEST_PLY_PENETRATION * model.thickness * model.area_stiffness
    duration = 150.0 * math.sqrt(0.5 * FABRIC.areal_density / model.area_stiffness)
    squeezed = run(share * largest, duration)
    doubt = found(squeezed).get("interfaces")
    assert (doubt is not None) == trips
    if trips:
        assert doubt.level == Level.DO_NOT_USE and "pressed" in doubt.text
        assert doubt.time == pytest.approx(0.5 * duration, rel=0.05) and doubt.sheet in ("lower", "upper")
        assert doubt.value == pytest.approx(share * LARGEST_PLY_PENETRATION * model.thickness, rel=0.05)


def strip(travel: tuple[float, float, float]):
    """A strip held at one end, whose other end is moved."""
    blank = Blank.rectangle((0.0, 0.0), (0.04, 0.02), 0.005)
    x = blank.node_position[:, 0]
    moved = Support("moved", np.flatnonzero(x > 0.035), (Drive(Stroke((0.0, 4e-3), (0.0, 1.0)), travel),))
    run = small_run(
        blank=blank, supports=(moved, Support("held", np.flatnonzero(x < 1e-9))), duration=4e-3, frame_count=1
    )
    run.run()
    return found(run)


def test_a_strip_that_is_turned_back_over_itself():
    """Its end is pushed under it and through it; a tenth as far, and up, it only bends."""
    guards = {"folded_elements", "inverted_elements", "self_intersection"}
    assert guards <= set(strip((-0.05, 0.004, -0.002)))
    assert not guards & set(strip((-0.004, 0.0, 0.008)))


@pytest.mark.parametrize(("director", "trips"), [(0.1, True), (1.0, False)])
def test_a_strip_that_twists_more_than_its_directors_bear(director, trips):
    """All nodes are driven into a helicoid that turns by 0.4 rad over an element; a tenth bears 0.26 rad, all 0.82."""
    size = 1.5 * THICKNESS
    blank = Blank.rectangle((-3.0 * size, -size), (3.0 * size, size), size)
    x, y, _ = blank.node_position.T
    angle = 0.4 * x / size
    every, none, held = np.arange(blank.node_count), np.zeros_like(x), Stroke((0.0, 3e-3, 1.0), (0.0, 1.0, 1.0))
    moved = Drive(held, np.column_stack([none, y * (np.cos(angle) - 1.0), y * np.sin(angle)]))
    laws = FABRIC.model_copy(update={"stabilisation": FABRIC.stabilisation.model_copy(update={"director": director})})
    supports = (Support("all", every, (moved,), rotations=""),)
    run = small_run(blank=blank, fabric=laws, supports=supports, duration=6e-3, frame_count=1)
    run.run()
    assert ("swinging_directors" in found(run)) == trips
    if trips:
        doubt = found(run)["swinging_directors"]
        assert doubt.level == Level.DO_NOT_USE and doubt.value >= 4 and doubt.time > 1.5e-3
        assert "0.1 an element may turn by 15 degrees in a twist, 21 in a bend" in doubt.advice


def test_a_trim_along_edges_of_elements():
    told = {"stage": "trim", "sheet": "sheet", "time_s": 0.1, "element_count": 4, "off_curve_mm": 0.0}
    run = judged()
    guard = known_guards()["trims"]()
    for off, count in ((0.0, 0), (1e-9, 0), (0.02, 1)):
        run.run.stages.trimmed = [told | {"off_curve_mm": off}]
        assert len(list(guard.after(run))) == count
