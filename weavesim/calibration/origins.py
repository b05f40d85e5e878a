"""What the provenance of a calibrated fabric says of the numbers that tests gave."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ..fabric.cell.weaves import CrossedYarns
from ..fabric.fabric import Fabric
from ..fabric.provenance import Origin, given_numbers, numbers_of, without
from ..input_files import shown
from ..version import __version__
from .options import CalibrationOptions
from .readings import DataFile
from .result import FITTED, HELD, Estimate
from .shear import FRICTION

# Intervals are given to this many digits, rounded outwards by as much.
_MARGIN = 1.0e-6


def with_origins(
    fabric: Fabric,
    estimates: dict[str, tuple[Estimate, ...]],
    options: CalibrationOptions,
    files: tuple[DataFile, ...],
    date: str,
    assumed: tuple[str, ...],
) -> Fabric:
    """The fabric with the source of every number that was fitted; the rest keeps what the given fabric says of it."""

    def source(*tests: str) -> str:
        names = [f"{shown(Path(f.path).name)} (SHA-256 {f.sha256[:12]})" for f in files if f.test in tests]
        if "cantilever" in tests and options.bending_length:
            lengths = ", ".join(f"{1e3 * value:g}" for value in (*options.bending_length, *options.bending_length_weft))
            names.append(f"bending lengths {lengths} mm")
        what = " and ".join(dict.fromkeys(f.test.replace("_", " ") for f in files if f.test in tests)) or "bending"
        return f"{what}, calibrated by weavesim {__version__} on {date[:10]} from {', '.join(names)}"

    found: list[Origin] = []
    if "unit cell" in estimates:
        found += _of_cell(fabric, estimates["unit cell"], source("biaxial"))
    if "shear" in estimates:
        found += _of_shear(fabric, estimates["shear"], source("picture_frame", "bias_extension"), assumed)
    if "bending" in estimates:
        found += _of_bending(fabric, estimates["bending"], source("cantilever"))
    numbers = numbers_of(fabric)
    found = [origin for origin in found if all(name in numbers for name in origin.of)]
    named = [name for origin in found for name in origin.of]
    kept = without(fabric.provenance, named)
    return fabric.model_copy(update={"provenance": (*kept, *found)})


def _of_cell(fabric: Fabric, entries: tuple[Estimate, ...], source: str) -> Iterator[Origin]:
    cell = fabric.unit_cell
    for e in entries:
        names, scale = [e.name], 1.0
        if isinstance(cell, CrossedYarns):
            yarns = [yarn for yarn in ("warp", "weft") if e.name.startswith(yarn)] or ["warp", "weft"]
            if e.name.endswith("yarn_stiffness"):
                names, scale = [f"{yarn}_modulus" for yarn in yarns], 1.0 / cell.warp_cross_section
            elif e.name.endswith("yarn_bending"):
                names, scale = [f"{yarn}_second_moment" for yarn in yarns], 1.0 / cell.warp_modulus
            elif e.name == "contact_stiffness" and cell.contact_stiffness_value is None:
                names, scale = ["contact_modulus"], cell.crossover_height / cell.contact_cross_section
            elif e.name == "contact_stiffness":
                names = ["contact_stiffness_value"]
        elif e.name == "stiffness":
            names = ["warp_stiffness", "weft_stiffness"]
        of = tuple(f"unit_cell.{name}" for name in names)
        if e.state == HELD:
            changed = not all(name in {n for o in fabric.provenance for n in o.of} for name in of)
            if changed:
                yield Origin(of=of, source=f"held at {e.value:.4g} {e.unit}: {source} does not tell it", assumed=True)
            continue
        yield _origin(of, source, e, scale)


def _origin(of: tuple[str, ...], source: str, e: Estimate, scale: float) -> Origin:
    note = f"{e.name} = {e.value:.4g} {e.unit}, {e.state}"
    if e.state != FITTED or not e.has_interval:
        return Origin(of=of, source=source, note=f"{note}: no interval")
    low, high = sorted((scale * e.low, scale * e.high))
    size = max(abs(low), abs(high))
    return Origin(
        of=of, source=source, range=(low - _MARGIN * size, high + _MARGIN * size), note=f"{note}; range: 95 % interval"
    )


def _of_shear(fabric: Fabric, entries: tuple[Estimate, ...], source: str, assumed: tuple[str, ...]) -> Iterator[Origin]:
    curve = [e for e in entries if e.name.startswith("moment_at")]
    half = [0.5 * (e.high - e.low) / e.value for e in curve if e.value > 0.0 and e.has_interval]
    note = ""
    if half:
        intervals = ", ".join(f"{e.low:.3g} to {e.high:.3g}" for e in curve)
        note = f"95 % intervals of the elastic moments [N/m]: {intervals}"[:2000]
    yield Origin(of=("shear.angle", "shear.moment_values"), source=source, note=note)
    if fabric.shear_friction is None:
        is_elastic = any("no friction" in name for name in assumed)
        note = "all of the measured moment is taken as elastic" if is_elastic else "the tests show none"
        yield Origin(of=("shear_friction",), source=source, assumed=is_elastic, note=note)
        return
    is_assumed = any("split" in name for name in assumed)
    limits = ", ".join(
        f"{e.low:.3g} to {e.high:.3g}" for e in entries if e.name.startswith(FRICTION) and e.has_interval
    )
    text = f"95 % intervals of the limit [N/m]: {limits}" if limits else ""
    if is_assumed:
        text = f"the initial jump of the loading is taken for friction: no unloading was measured. {text}"
    yield Origin(
        of=("shear_friction.stiffness", "shear_friction.limit", "shear_friction.angle"), source=source,
        assumed=is_assumed, note=text,
    )  # fmt: skip


def _of_bending(fabric: Fabric, entries: tuple[Estimate, ...], source: str) -> Iterator[Origin]:
    names = given_numbers(fabric)
    if "bending.modulus" in names:
        yield _origin(("bending.modulus",), source, entries[0], 12.0 / fabric.thickness**3)
        return
    for e in entries:
        yarns = [yarn for yarn in ("warp", "weft") if e.name.startswith(yarn)] or ["warp", "weft"]
        yield _origin(tuple(f"bending.{yarn}" for yarn in yarns), source, e, 1.0)
    yield Origin(
        of=("bending.twist",), source="scaled with warp and weft from the given fabric: strips do not show it",
        assumed=True,
    )  # fmt: skip
