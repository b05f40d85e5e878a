"""Cases to time: scenes on meshes of several sizes, and free patches of any size.

Both versions of ``benchmark.py against`` create their cases here: versions whose simulations take a ``Setup``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np


def _double_dome(mesh_size: float, contact_samples: str = "nodes") -> Callable[..., Any]:
    """A quarter of the double dome; tools meet the nodes, or the ``"surface"`` between them, as the scene has it."""

    def build(**options: Any):
        from weavesim import Simulation
        from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome

        chosen = options | {"mesh_size": mesh_size, "contact_samples": contact_samples}
        return Simulation(double_dome(DoubleDomeParameters(**chosen)))

    return build


def _hemisphere(**options: Any):
    from weavesim import Simulation
    from weavesim.scenes.hemisphere import HemisphereParameters, hemisphere

    return Simulation(hemisphere(HemisphereParameters(**options), "low-bending"))


def _patch(side: int, at_random: bool = False, **numbering: Any) -> Callable[..., Any]:
    """A free square of ``side`` x ``side`` elements, stretched, sheared and thrown, without tools.

    Elements are 5 mm large, smaller where the sheet would be larger than is usual. Nodes and elements are numbered row
    by row, or ``at_random``; ``numbering`` is that of ``Blank.from_mesh``.
    """

    def blank():
        from weavesim import Blank

        size = min(0.005, 7.9 / side)
        rows = Blank.rectangle((0.0, 0.0), (side * size, side * size), size)
        if not at_random:
            return rows
        random = np.random.default_rng(0)
        order = random.permutation(rows.node_count)
        number = np.empty_like(order)
        number[order] = np.arange(len(order))
        return Blank.from_mesh(rows.node_position[order], number[random.permutation(rows.quads)], **numbering)

    return _thrown(blank)


def _disc(radius: float) -> Callable[..., Any]:
    """A free disc with elements of 5 mm, thrown likewise: a fitted mesh, with those along its border at its end."""

    def blank():
        from weavesim import Blank

        return Blank.disc(radius, 0.005)

    return _thrown(blank)


def _thrown(make_blank: Callable[[], Any]) -> Callable[..., Any]:
    def build(**options: Any):
        from weavesim import Setup, Sheet, Simulation, Solver
        from weavesim.fabric import glass_polypropylene

        blank = make_blank()
        x, y, _ = blank.node_position.T
        wave = 20.0 * np.pi
        velocity = np.column_stack([np.sin(wave * y), np.sin(wave * x), np.sin(wave * x) * np.sin(wave * y)])
        sheet = Sheet(blank, glass_polypropylene(), initial_velocity=velocity)
        return Simulation(Setup("patch", sheets=(sheet,), duration=1.0, solver=Solver(**options)))

    return build


CASES: dict[str, Callable[..., Any]] = {
    "double_dome_10mm": _double_dome(0.01),
    "double_dome_5mm": _double_dome(0.005),
    "double_dome_2.5mm": _double_dome(0.0025),
    "double_dome_1.25mm": _double_dome(0.00125),
    "double_dome_5mm_surface": _double_dome(0.005, "surface"),
    "hemisphere": _hemisphere,
    "patch_1k": _patch(32),
    "patch_5k": _patch(71),
    "patch_10k": _patch(100),
    "patch_100k": _patch(316),
    "patch_1m": _patch(1000),
    "patch_10m": _patch(3162),
    "patch_10k_at_random": _patch(100, at_random=True),
    "patch_100k_at_random": _patch(316, at_random=True),
    "patch_10k_put_in_order": _patch(100, at_random=True, numbering="neighbouring"),
    "patch_100k_put_in_order": _patch(316, at_random=True, numbering="neighbouring"),
    "disc_11k": _disc(0.3),
    "disc_45k": _disc(0.6),
}
# These run only by name: contact between nodes is compared with that at nodes, 5,000 elements are for a GPU, the
# largest need 3 and 30 GB and several minutes, and the last six are about the order of a mesh.
BY_NAME = (
    "double_dome_5mm_surface",
    "patch_5k",
    "patch_1m",
    "patch_10m",
    "patch_10k_at_random",
    "patch_100k_at_random",
    "patch_10k_put_in_order",
    "patch_100k_put_in_order",
    "disc_11k",
    "disc_45k",
)
DEFAULT_CASES = tuple(name for name in CASES if name not in BY_NAME)


def element_count(simulation: Any) -> int:
    """Number of elements of all its sheets."""
    return sum(sheet.blank.element_count for sheet in simulation.setup.sheets)


def warm_up(simulation: Any) -> None:
    """Up to 4,000 steps before timing: the sheet is then in motion, in a double dome also in contact with its tools."""
    simulation.stepper.advance(int(np.clip(2_000_000 // element_count(simulation), 5, 200)))
