"""Fields at material points that all runs of a study have in common, whatever their meshes: data for surrogates."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..measures.angles import located, smoothed_shear_angle
from ..output.files import replacing
from ..run.fields import FIELDS
from ..run.staging.part import part_of
from ..version import __version__

if TYPE_CHECKING:
    from ..engine.setup import Setup
    from ..run.frame import SheetFrame, SheetInfo
    from ..run.simulation import Simulation

FILE_NAME = "fields.h5"
FORMAT, FORMAT_VERSION = "weavesim study fields", 1
# Fields of elements that are written, by their names in frames.
WRITTEN = ("shear_angle", "warp_stretch", "weft_stretch", "thickness", "fibre_volume_fraction")


@dataclass(frozen=True, eq=False)
class SheetPoints:
    """Material points of one sheet.

    Attributes:
        name: of the sheet.
        flat: their places on the flat blank, (k, 2) [m].
    """

    name: str
    flat: np.ndarray


def points_of(setup: Setup, count: int) -> tuple[SheetPoints, ...]:
    """About ``count`` points on each sheet of a set-up, on a square grid on the flat blank."""
    found = []
    for sheet in setup.sheets:
        flat = sheet.blank.material_coordinates
        corner = flat[sheet.blank.quads]
        across, other = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
        area = 0.5 * float(np.abs(across[:, 0] * other[:, 1] - across[:, 1] * other[:, 0]).sum())
        spacing = math.sqrt(area / count)
        lower, upper = flat.min(axis=0), flat.max(axis=0)
        axes = [np.arange(a + 0.5 * spacing, b, spacing) for a, b in zip(lower, upper, strict=True)]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        found.append(SheetPoints(sheet.name, grid[located(sheet.blank, grid)[0] >= 0]))
    return tuple(found)


def fields_at(simulation: Simulation, sheets: Sequence[SheetPoints]) -> dict[str, np.ndarray]:
    """Positions and fields of a run at its material points, as "SHEET/position" and so on, in single precision.

    A point that is not on the blank of this run, whose outline may vary, has values that are not numbers.
    """
    found: dict[str, np.ndarray] = {}
    for each in zip(simulation.info.sheets, simulation.frame.sheets, strict=True):
        info, frame = part_of(*each)
        points = next((each for each in sheets if each.name == info.name), None)
        if points is not None:
            for name, values in _of_sheet(info, frame, points.flat).items():
                found[f"{info.name}/{name}"] = values.astype(np.float32)
    return found


def _of_sheet(info: SheetInfo, frame: SheetFrame, flat: np.ndarray) -> dict[str, np.ndarray]:
    blank = info.blank
    element, weight = located(blank, flat)
    inside = element >= 0
    corners, weight = blank.quads[element[inside]], weight[inside]

    def spread(values: np.ndarray) -> np.ndarray:
        whole = np.full((len(flat), *values.shape[1:]), np.nan)
        whole[inside] = values
        return whole

    out = {"position": spread(np.einsum("kc,kci->ki", weight, frame.position[corners]))}
    area = np.bincount(blank.quads.ravel(), minlength=blank.node_count)
    for name in WRITTEN:
        if (values := frame.fields.get(name)) is None:
            continue
        if name == "shear_angle":
            nodal = smoothed_shear_angle(blank, values, info.symmetry)
        else:
            nodal = np.bincount(blank.quads.ravel(), np.repeat(values, 4), blank.node_count) / np.maximum(area, 1)
        out[name] = spread(np.einsum("kc,kc->k", weight, nodal[corners]))
    return out


def write_fields(
    path: Path,
    sheets: Sequence[SheetPoints],
    inputs: Mapping[str, Sequence[Any]],
    units: Mapping[str, str],
    measures: Mapping[str, Sequence[float | None]],
    runs: Sequence[Mapping[str, np.ndarray]],
    keys: Sequence[str],
) -> None:
    """Write inputs, measures and fields of all runs, in the same order along the first axis (docs/studies.md).

    Args:
        path: of the file.
        sheets: the material points.
        inputs: values of each factor, (run_count,), numbers or texts.
        units: of the factors, by their names.
        measures: numbers of the runs, by their names.
        runs: what ``fields_at`` found in each.
        keys: of the runs.
    """
    import h5py

    described = {field.name: (field.unit, field.description) for field in FIELDS}
    described["position"] = ("m", "place of the material point on the formed sheet: x, y, z")
    with replacing(path) as temporary, h5py.File(temporary, "w") as file:
        file.attrs.update({"format": FORMAT, "format_version": FORMAT_VERSION, "weavesim_version": __version__})
        file["runs"] = np.array(list(keys), dtype=h5py.string_dtype())
        for name, given in inputs.items():
            is_numeric = all(isinstance(value, int | float) for value in given)
            values = np.array(given, dtype=float) if is_numeric else np.array(
                [str(value) for value in given], dtype=h5py.string_dtype()
            )  # fmt: skip
            file.create_dataset(f"inputs/{name.replace('/', '_')}", data=values).attrs["unit"] = units.get(name, "")
        for name, numbers in measures.items():
            file[f"measures/{name.replace('/', '_')}"] = np.array(
                [math.nan if number is None else number for number in numbers], dtype=float
            )
        for index, points in enumerate(sheets):
            group = file.create_group(f"sheets/{index}")
            group.attrs["name"] = points.name
            group["points"] = points.flat
            for name in ("position", *WRITTEN):
                found = [of_run for run in runs if (of_run := run.get(f"{points.name}/{name}")) is not None]
                if not found or len(found) < len(runs):
                    continue
                dataset = group.create_dataset(name, data=np.stack(found), compression="gzip", shuffle=True)
                unit, text = described[name]
                dataset.attrs.update({"unit": unit, "description": text})
