"""A commented job for a tool of one's own: what was found of its surface becomes a press and a blank."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from textwrap import wrap

import numpy as np

from ...fabric.fabric import Fabric
from ..advice.damping import release_damping, suggested_damping
from ..advice.speed import rounded_down, suggested_speed
from .survey import Survey

# Margin of a blank on the rim, over its longer side, and between which lengths [m].
MARGIN_SHARE = 0.15
LEAST_MARGIN, MOST_MARGIN = 0.015, 0.05
# The blank ends this far inside the rim's border [m].
WITHIN_RIM = 0.002
# Elements along the longer side of a blank: at least and at most.
FEWEST_ELEMENTS, MOST_ELEMENTS = 40, 60
ELEMENTS_ON_RADIUS = 5.0
# Of the ring on the sheet under it [Pa].
RING_PRESSURE = 20.0e3
# Mean pressure of the press on the opening, at which its stroke waits [Pa].
PRESS_PRESSURE = 1.0e6


@dataclass(frozen=True)
class Choices:
    """What a user chose for a new job.

    Attributes:
        name: of the job.
        die: name of the die's file, beside the job.
        fabric: its name.
        gap: between punch and die when they are closed [m]; None for the thickness of the fabric.
        punch, ring: names of their files; None makes them from the die.
        mesh_size: edge length of an element [m]; None for one that suits the radii.
        speed: of the punch [m/s]; None for the suggested one.
        with_ring: whether there is a holder.
        schema: name of the schema's file, beside the job; None for none.
    """

    name: str
    die: str
    fabric: str
    gap: float | None = None
    punch: str | None = None
    ring: str | None = None
    mesh_size: float | None = None
    speed: float | None = None
    with_ring: bool = True
    schema: str | None = None


def blank_sides(found: Survey) -> np.ndarray:
    """Sides of a rectangle that covers the surface and its rim, to whole 5 mm, (2,) [m]."""
    if found.rim_height is None:
        return _steps(found.arc + 0.01, 0.005)
    margin = float(np.clip(MARGIN_SHARE * found.arc.max(), LEAST_MARGIN, MOST_MARGIN))
    wanted = found.arc + 2.0 * margin
    room = 2.0 * np.minimum(found.upper[:2] - found.centre, found.centre - found.lower[:2]) - 2.0 * WITHIN_RIM
    opening = found.opening[1] - found.opening[0]
    if not found.is_female:  # it lies on the top, and its edges come in to the rim as it is drawn down
        return _steps(np.maximum(np.minimum(wanted, room + found.arc - opening), found.arc), 0.005)
    return _steps(np.minimum(wanted, np.maximum(room, opening)), 0.005)


def mesh_size_for(sides: np.ndarray, radius: float) -> float:
    """Elements that follow the smallest radius, if that is affordable; a round number [m]."""
    longest = float(sides.max())
    wanted = 0.5 * math.pi * radius / ELEMENTS_ON_RADIUS if math.isfinite(radius) else math.inf
    size = float(np.clip(wanted, longest / MOST_ELEMENTS, longest / FEWEST_ELEMENTS))
    return rounded_down(size)


def new_job(found: Survey, choices: Choices, fabric: Fabric) -> str:
    """The text of a job file."""
    sides = blank_sides(found)
    gap = fabric.thickness if choices.gap is None else choices.gap
    size = mesh_size_for(sides, found.radius) if choices.mesh_size is None else choices.mesh_size
    speed = suggested_speed([fabric]) if choices.speed is None else choices.speed
    has_ring = choices.with_ring and found.is_female
    covered = max(float(np.prod(sides)) - float(np.prod(found.opening[1] - found.opening[0])), 0.0)
    parts = [
        _head(found, choices),
        _ply(found, choices, sides, size, fabric),
        _die(found, choices),
        _punch(found, choices, gap, speed),
        _ring(found, choices, min(covered, found.rim_area or covered)) if has_ring else _no_ring(found, choices),
        _process(found, speed),
        _stages(has_ring, release_damping(fabric, float(sides.max())) if fabric.bending_stiffness_scale else 100.0),
        "[output]\nframe_count = 40\n",
    ]
    return "\n".join(parts)


def _head(found: Survey, choices: Choices) -> str:
    x, y, z = (_mm(side) for side in found.size)
    lines = [f"#:schema ./{choices.schema}\n"] if choices.schema else []
    lines += [
        _comment(
            f"{choices.name}: a forming run. Check it with `weavesim check`, run it with `weavesim form`, look at it "
            "with `weavesim view`; docs/job.md explains every key. Lengths without a unit are metres."
        ),
        _comment(
            f"The die's surface is {x} x {y} x {z} mm. Unit: {found.unit}, {found.unit_reason}. Up: {found.up}, "
            f"{found.up_reason}. " + _shape(found)
        ),
        f"name = {_text(choices.name)}\n",
    ]
    return "\n".join(lines)


def _shape(found: Survey) -> str:
    a, b = (_mm(side) for side in found.opening[1] - found.opening[0])
    radius = f" Its smallest convex radius is about {_mm(found.radius)} mm." if math.isfinite(found.radius) else ""
    if found.rim_height is None:
        return f"It has no flat rim.{radius}"
    if found.is_female:
        return f"It has an opening of {a} x {b} mm with a flat rim around it.{radius}"
    return f"It is raised over {a} x {b} mm, above a flat rim.{radius}"


def _ply(found: Survey, choices: Choices, sides: np.ndarray, size: float, fabric: Fabric) -> str:
    count = 0.5 * math.pi * found.radius / size
    fine = f", {count:.1f} on a quarter turn of the smallest radius (five follow it well)" if count < 99.0 else ""
    along = " and ".join(f"{_mm(arc)}" for arc in found.arc)
    x, y = found.centre
    centre = f'centre = ["{_mm(x)} mm", "{_mm(y)} mm"]\n' if max(abs(x), abs(y)) > 5e-5 else ""
    return (
        _comment(
            f"The blank: over the surface, whose sections are {along} mm long"
            + (", and onto the rim. Without a height it lies on the die." if found.is_female else ".")
        )
        + f'[[ply]]\nname = "ply"\nfabric = {_text(choices.fabric)}  # {1e3 * fabric.thickness:.3g} mm; see weavesim '
        f'fabric list\nrectangle = ["{_mm(sides[0])} mm", "{_mm(sides[1])} mm"]\n{centre}'
        f'angle = "0 deg"  # from x to the warp\nmesh_size = "{_mm(size)} mm"  # about '
        f"{np.prod(sides) / size**2:,.0f} elements{fine}\n"
    )


def _die(found: Survey, choices: Choices) -> str:
    return (
        f'[[tool]]\nname = "die"\nfile = {_text(choices.die)}\nunit = "{found.unit}"\nup = "{found.up}"\n'
        'faces = "up"  # towards the sheet\n'
    )


def _punch(found: Survey, choices: Choices, gap: float, speed: float) -> str:
    if choices.punch is None:
        head = _comment("The punch: the die's surface, at this gap when both are closed.")
        surface = f'offset_of = "die"\ngap = "{_mm(gap)} mm"\n'
    else:
        head = _comment("The punch, drawn closed: it starts above the sheet and goes to where it is drawn.")
        surface = f'file = {_text(choices.punch)}\nunit = "{found.unit}"\nup = "{found.up}"\nfaces = "down"\n'
    where = "the opening" if found.is_female else "what is raised"
    force = rounded_down(max(PRESS_PRESSURE * float(np.prod(found.opening[1] - found.opening[0])), 1.0))
    return (
        f'{head}[[tool]]\nname = "punch"\n{surface}start = "touching"\nclearance = "1 mm"\nstroke = "close"\n'
        f'speed = "{speed:g} m/s"  # suggested for this fabric\n'
        f'largest_force = "{force:g} N"  # of the press, 1 MPa on {where}: a stroke too far waits there\n'
    )


def _ring(found: Survey, choices: Choices, area: float) -> str:
    force = rounded_down(max(RING_PRESSURE * area, 1.0))
    mass = rounded_down(max(force / 1000.0, 0.01))
    if choices.ring is None:
        head = _comment("The holder: a ring over the rim, in touch with the sheet from the start; 20 kPa on the sheet.")
        surface = 'ring_of = "die"\n'
    else:
        head = _comment("The holder, moved until it touches the sheet; 20 kPa on the sheet.")
        surface = (
            f'file = {_text(choices.ring)}\nunit = "{found.unit}"\nup = "{found.up}"\nfaces = "down"\n'
            'start = "touching"\n'
        )
    return f'{head}[[tool]]\nname = "ring"\n{surface}force = "{force:g} N"\nmass = "{mass:g} kg"\n'


def _no_ring(found: Survey, choices: Choices) -> str:
    if choices.with_ring and not found.is_female:
        return _comment("No holder: the die has no flat rim around an opening for a ring.").rstrip("\n") + "\n"
    return ""


def _process(found: Survey, speed: float) -> str:
    time = float(found.size[2]) / speed
    return (
        _comment(
            f"Suggested: vibrations of the sheet fall by e six times in the {1e3 * time:.2g} ms of the stroke, and "
            "what moves slowly hardly feels it."
        )
        + f'[process]\ndamping = "{suggested_damping(time):g} 1/s"\n'
    )


def _stages(has_ring: bool, damping: float) -> str:
    """Stages as an example in comments."""
    head = _comment(
        "More than closing? Stages follow each other (docs/stages.md); take the signs off to close, hold for 10 ms, "
        "and release the part onto the die until it is at rest."
    )
    free = "the punch" + (" and the ring" if has_ring else "")
    example = f"""
[[stage]]
name = "close"
# a stage ends with its strokes, or earlier: end = {{ tool = "punch", force = "2 kN" }}

[[stage]]
name = "hold"
duration = "10 ms"
[[stage.move]]
name = "punch"
fixed = true

[[stage]]
name = "release"
duration = "0.3 s"  # the most that it takes
tools = ["die"]  # {free} no longer act
damping = "{damping:g} 1/s"  # suggested: critical for the slowest bending of the flat sheet
end = {{ rest = 1e-3, speed = "10 mm/s" }}
"""
    return head + "".join(f"#{line}\n" if line else "#\n" for line in example.strip().split("\n"))


def _comment(text: str) -> str:
    return "".join(f"# {line}\n" for line in wrap(text, 100, break_on_hyphens=False))


def _text(value: str) -> str:
    """As TOML writes a text, whatever is in it."""
    return json.dumps(value, ensure_ascii=False)


def _steps(lengths: np.ndarray, step: float) -> np.ndarray:
    return np.maximum(np.floor(lengths / step + 1e-6), 1.0) * step


def _mm(length: float) -> str:
    return f"{1e3 * float(length):.4g}"
