"""Cost of every law relative to the default one and of every unit cell; what stiffnesses take of the stable step."""

from __future__ import annotations

import time
from typing import Annotated, Any

import numpy as np
import typer

from ..shared.machine import machine
from ..shared.report import line_about, table
from .cases import element_count, warm_up
from .measures import seconds_per_step
from .ratios import ratio_table


def law_variants() -> dict[str, Any]:
    """Fabrics that differ from the default one in one law."""
    from weavesim.fabric.bending import BendingCurve, YarnBending
    from weavesim.fabric.presets import glass_polypropylene
    from weavesim.fabric.shear import ShearFriction
    from weavesim.process.dynamics import Dynamics

    base = glass_polypropylene()

    def changed(dynamics: Dynamics | None = None, **update: Any) -> tuple[Any, Any]:
        return base.model_copy(update=update), dynamics

    stiff = base.bending.stiffness(base.thickness)
    curve = BendingCurve(curvature=(0.0, 10.0, 50.0), moment_values=(0.0, 8.0 * stiff, 25.0 * stiff))
    rubbing = BendingCurve.from_kawabata(rigidity=stiff, hysteresis=2e-2)
    variants = {
        "default: plain weave, shear curve, isotropic bending": changed(),
        "linear shear": changed(shear=base.with_linear_shear(0.25e6).shear),
        "shear friction, tension-shear coupling": changed(
            shear_friction=ShearFriction(stiffness=60.0, limit=(0.5,), crossover_friction_length=1e-4)
        ),
        "bending per yarn family": changed(bending=YarnBending(warp=stiff, weft=stiff, twist=0.5 * stiff)),
        "bending curves": changed(bending=YarnBending(warp=curve, weft=curve, twist=0.5 * stiff)),
        "bending friction": changed(bending=YarnBending(warp=rubbing, weft=rubbing, twist=0.5 * stiff)),
        "no in-plane bending of yarns": changed(in_plane_bending_stiffness=0.0),
        "tools meet the current thickness": changed(Dynamics(contact_thickness="current")),
    }
    return variants


def cell_variants() -> dict[str, Any]:
    """Fabrics that differ from the default one in the unit cell only, the plain weave first."""
    from weavesim.fabric.presets import UNIT_CELLS, glass_polypropylene

    base = glass_polypropylene()
    # some cells let the angle grow beyond that of locking
    soft = base.shear.model_copy(update={"locking_stiffness": 0.0})
    cells = {"plain-weave": UNIT_CELLS["plain-weave"]} | UNIT_CELLS
    return {name: (base.model_copy(update={"unit_cell": cell(), "shear": soft}), None) for name, cell in cells.items()}


def laws(
    turns: Annotated[int, typer.Option(help="turns per law")] = 7,
    seconds: Annotated[float, typer.Option(help="length of a turn")] = 0.3,
    mesh_size: Annotated[float, typer.Option(help="mesh size of the double dome [m]")] = 0.01,
    precision: Annotated[str, typer.Option(help="float32 or float64")] = "float32",
) -> None:
    """Time per element and step of every law in the double dome, on one thread."""
    typer.echo(line_about(machine()))
    typer.echo(measured(law_variants(), precision, mesh_size, turns, seconds))


def cells(
    turns: Annotated[int, typer.Option(help="turns per cell")] = 7,
    seconds: Annotated[float, typer.Option(help="length of a turn")] = 0.3,
    mesh_size: Annotated[float, typer.Option(help="mesh size of the double dome [m]")] = 0.005,
    precision: Annotated[list[str] | None, typer.Option(help="float32, float64 [default: both]")] = None,
) -> None:
    """Time per element and step of every unit cell relative to the plain weave, in the double dome, on one thread."""
    typer.echo(line_about(machine()))
    for one in precision or ["float32", "float64"]:
        typer.echo(measured(cell_variants(), one, mesh_size, turns, seconds))


def measured(variants: dict[str, Any], precision: str, mesh_size: float, turns: int, seconds: float) -> str:
    """Table of the variants' times in the double dome, in alternating turns: processor time, without other programs."""
    from weavesim.run.simulation import Simulation
    from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome

    parameters = DoubleDomeParameters(mesh_size=mesh_size, precision=precision, threads=1, contact_samples="nodes")
    simulations = []
    for fabric, dynamics in variants.values():
        setup = double_dome(parameters, fabric)
        if dynamics is not None:
            (world,) = setup.worlds
            setup = setup.model_copy(update={"worlds": (world.model_copy(update={"dynamics": dynamics}),)})
        simulation = Simulation(setup)
        warm_up(simulation)
        simulations.append(simulation)
    clock = time.process_time
    times = np.array([[seconds_per_step(one, seconds, clock=clock) for one in simulations] for _ in range(turns)])
    count = element_count(simulations[0])
    head = f"\n{count} elements, {precision}, one thread, {turns} turns of {seconds} s\n\n"
    return head + ratio_table(list(variants), 1e9 * times / count)


def softened() -> dict[str, Any]:
    """The default fabric, then with one stiffness a thousandth of what it is."""
    from weavesim.fabric.presets import glass_polypropylene

    base = glass_polypropylene()
    bending = base.bending.model_copy(update={"modulus": 1e-3 * base.bending.modulus})
    yarns = {name: 1e-3 * getattr(base.unit_cell, name) for name in ("warp_modulus", "weft_modulus")}
    # locking is at most a tenth of the yarns' stiffness
    soft_locking = base.shear.model_copy(update={"locking_stiffness": 1e-3 * base.shear.locking_stiffness})
    changes = {
        "none": {},
        "transverse shear": {"transverse_shear_modulus": 1e-3 * base.transverse_shear_modulus},
        "bending": {"bending": bending},
        "in-plane bending": {"in_plane_bending_stiffness": 1e-3 * base.in_plane_bending_stiffness},
        "compression": {"compressive_stiffness": 1e-3 * base.compressive_stiffness},
        "yarns and locking": {"unit_cell": base.unit_cell.model_copy(update=yarns), "shear": soft_locking},
    }
    return {name: base.model_copy(update=change) for name, change in changes.items()}


def stiffnesses(
    mesh_size: Annotated[list[float] | None, typer.Option(help="[m]; may be repeated [default: 5 and 2.5 mm]")] = None,
) -> None:
    """Stable step of the flat double dome where one stiffness is a thousandth: what an implicit term could gain."""
    from weavesim.engine.model import Model
    from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome

    sizes, rows = mesh_size or [0.005, 0.0025], []
    parameters = [DoubleDomeParameters(mesh_size=size) for size in sizes]
    first: list[float] = []
    for name, fabric in softened().items():
        steps = [Model(double_dome(each, fabric)).reference_step for each in parameters]
        first = first or steps
        cells = (f"{1e6 * step:.4g} ({step / whole:.3f})" for step, whole in zip(steps, first, strict=True))
        rows.append([name, *cells])
    head = ["a thousandth of", *(f"{1e3 * size:g} mm: stable step [us] (ratio)" for size in sizes)]
    typer.echo(table(head, rows))
