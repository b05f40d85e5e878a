"""Cost of tools that are triangle meshes compared with built-in shapes of the same form, or of a like one."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np
import typer

from ...shared.machine import machine
from ...shared.report import line_about, table
from ..cases import element_count
from ..measures import seconds_per_step

TRAY = Path(__file__).resolve().parents[3] / "docs" / "notebooks" / "tray.stl"


def _with_shapes(setup: Any, shape_of: Callable[[Any], Any], precision: str) -> Any:
    """The set-up with other tools, on one thread."""
    (world,) = setup.worlds
    tools = tuple(tool.model_copy(update={"shape": shape_of(tool)}) for tool in world.tools)
    solver = setup.solver.model_copy(update={"threads": 1, "precision": type(setup.solver.precision)(precision)})
    changed = {"worlds": (world.model_copy(update={"tools": tools}),), "solver": solver, "accept_unusual": True}
    return setup.model_copy(update=changed)


def _cut(surface: Any, height: float) -> tuple[np.ndarray, np.ndarray]:
    """The solid behind an open surface, down to a flat back at a height [m]: vertices (n, 3) [m], faces (m, 3)."""
    import manifold3d

    solid = manifold3d.Mesh64(surface.solid_vertices, surface.solid_faces.astype(np.uint64))
    cut = manifold3d.Manifold(solid).trim_by_plane((0.0, 0.0, 1.0), height).to_mesh64()
    return np.asarray(cut.vert_properties)[:, :3], np.asarray(cut.tri_verts).astype(np.int64)


def _double_dome(precision: str, kind: str, mesh_size: float) -> Any:
    """``kind``: "built-in", "open" (die and holder as open surfaces), or "closed" (these as thick plates)."""
    from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome
    from weavesim.tools.mesh_tool import MeshShape

    def mesh(tool: Any) -> Any:
        shape = tool.shape
        vertices, faces = shape.local_triangles()
        side = None if tool.name == "punch" else (0.0, 0.0, 1.0)
        made = MeshShape.from_triangles(vertices, faces, name=tool.name, side=side)
        if kind == "closed" and not made.surface.closed:
            made = MeshShape.from_triangles(*_cut(made.surface, vertices[:, 2].min() - 0.02), name=tool.name)
        return made.placed(shape.origin, shape.rotation)

    setup = double_dome(DoubleDomeParameters(mesh_size=mesh_size, contact_samples="nodes"))
    return _with_shapes(setup, (lambda tool: tool.shape) if kind == "built-in" else mesh, precision)


def _tray(precision: str, kind: str, mesh_size: float) -> Any:
    """``kind``: "open", or "built-in": domes of like size with the same strokes and forces."""
    from weavesim.fabric.presets import glass_polypropylene
    from weavesim.job.build import setup_of
    from weavesim.job.draft.survey import survey
    from weavesim.job.draft.template import Choices, new_job
    from weavesim.job.read import read_job
    from weavesim.tools.shapes import DomeOpening, DomePunch, rotation_matrix

    with TemporaryDirectory() as folder:
        job = Path(folder) / "job.toml"
        chosen = Choices("tray", str(TRAY), "glass-polypropylene", mesh_size=mesh_size)
        job.write_text(new_job(survey(TRAY), chosen, glass_polypropylene()))
        setup = setup_of(read_job(job, (), [TRAY.parent]))
    opening = DomeOpening(radius=0.0605, half_length=0.015, edge_radius=0.02)
    built_in = {
        "die": opening,
        "ring": opening.placed((0.0, 0.0, 0.0012), rotation_matrix((1.0, 0.0, 0.0), math.pi)),
        "punch": DomePunch(radius=0.0592, half_length=0.015).placed((0.0, 0.0, 0.0614)),
    }
    return _with_shapes(setup, lambda tool: built_in[tool.name] if kind == "built-in" else tool.shape, precision)


# The kinds of tools of each case, and its mesh size [m].
CASES: dict[str, tuple[Callable[..., Any], tuple[str, ...], float]] = {
    "double dome": (_double_dome, ("built-in", "closed", "open"), 0.005),
    "tray": (_tray, ("built-in", "open"), 0.008),
}


def meshes(
    turns: Annotated[int, typer.Option(help="turns per contestant and place in the run")] = 9,
    seconds: Annotated[float, typer.Option(help="length of a turn")] = 0.3,
    precision: Annotated[str, typer.Option(help="float32 or float64")] = "float32",
    shares: Annotated[str, typer.Option(help="places in the run, as shares of its duration")] = "0.1,0.5,0.9",
) -> None:
    """Processor time of a step with tools that are meshes, over that with built-in shapes, on one thread."""
    from weavesim.run.simulation import Simulation

    rows = []
    for name, (make, kinds, mesh_size) in CASES.items():
        simulations = [Simulation(make(precision, kind, mesh_size)) for kind in kinds]
        for share in (float(text) for text in shares.split(",")):
            for simulation in simulations:
                simulation.stepper.advance_to(share * simulation.setup.duration)
            times = np.array(
                [[seconds_per_step(s, seconds, clock=time.process_time) for s in simulations] for _ in range(turns)]
            )
            ratio = np.quantile(times / times[:, :1], [0.25, 0.5, 0.75], axis=0)
            rows += [
                [
                    name, element_count(simulations[k]), f"{share:g}", kind, f"{1e6 * np.median(times[:, k]):.0f}",
                    f"{ratio[1, k]:.2f}", f"{ratio[0, k]:.2f} to {ratio[2, k]:.2f}",
                ]
                for k, kind in enumerate(kinds)
            ]  # fmt: skip
    typer.echo(line_about(machine()))
    typer.echo(f"{precision}, one thread\n")
    typer.echo(table(["case", "elements", "share of the run", "tools", "step [us]", "ratio", "quartiles"], rows))
