"""Files of numbers for other programs: HDF5, VTKHDF, CSV."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ...measures.units import with_unit
from ...version import __version__
from ..files import replacing
from ..stored.file import StoredRun, write_values
from ..stored.values import ElementValue
from ..tables import write_table
from .part import Part, angle_in
from .units import UnitSystem

_VTK_KINDS = {"triangle": 5, "quad": 9, "triangle6": 22, "quad8": 23}
FORMAT, FORMAT_VERSION = "weavesim part", 1


def part_values(part: Part, number: int) -> dict[str, ElementValue]:
    """Values of one ply by name: yarn directions, their angles in the frame of each element, and the others."""
    ply, frames = part.plies[number], part.mesh.frames
    return {
        "warp_direction": ElementValue("1", "unit direction of the warp: x, y, z", ply.warp),
        "weft_direction": ElementValue("1", "unit direction of the weft: x, y, z", ply.weft),
        "warp_angle_deg": ElementValue("degrees", "of the warp in the element's frame", angle_in(frames, ply.warp)),
        "weft_angle_deg": ElementValue("degrees", "of the weft in the element's frame", angle_in(frames, ply.weft)),
        "thickness": ElementValue("m", "current thickness", ply.thickness),
        **{name: value for name, value in ply.values.items() if name != "thickness"},
    }


def write_hdf5(path: Path, part: Part, run: StoredRun) -> None:
    """One part: its mesh, and a group for each ply (docs/outputs.md)."""
    import h5py

    with replacing(path) as temporary, h5py.File(temporary, "w") as file:
        file.attrs.update({"format": FORMAT, "format_version": FORMAT_VERSION, "weavesim_version": __version__,
                           "run_id": run.run_id, "name": part.name})  # fmt: skip
        file["mesh/nodes"], file["mesh/node_numbers"] = part.mesh.nodes, part.mesh.node_labels
        for cells in part.mesh.cells:
            block = file.create_group(f"mesh/{cells.kind}")
            block["nodes"], block["numbers"] = cells.nodes, cells.labels
        file["mesh/element_numbers"] = part.mesh.labels
        for number, ply in enumerate(part.plies):
            group = file.create_group(f"plies/{number}")
            group.attrs.update({"name": ply.name, "fabric": ply.fabric, "initial_thickness": ply.initial_thickness})
            write_values(group, part_values(part, number))


def write_vtkhdf(path: Path, part: Part) -> None:
    """One part as an unstructured grid of VTKHDF; with several plies, names of values begin with that of the ply."""
    import h5py

    mesh = part.mesh
    corners = [row for cells in mesh.cells for row in cells.nodes]
    offsets = np.concatenate([[0], np.cumsum([len(row) for row in corners])])
    kinds = np.concatenate([np.full(len(cells.labels), _VTK_KINDS[cells.kind], np.uint8) for cells in mesh.cells])
    with replacing(path) as temporary, h5py.File(temporary, "w", track_order=True) as file:
        root = file.create_group("VTKHDF", track_order=True)
        root.attrs["Version"] = (2, 0)
        root.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", len("UnstructuredGrid")))
        counts = (len(mesh.nodes), len(corners), int(offsets[-1]))
        for name, count in zip(("Points", "Cells", "ConnectivityIds"), counts, strict=True):
            root[f"NumberOf{name}"] = np.array([count], dtype=np.int64)
        root["Points"] = mesh.nodes
        root["Connectivity"] = np.concatenate(corners).astype(np.int64)
        root["Offsets"], root["Types"] = offsets.astype(np.int64), kinds
        _fill(root.create_group("PointData"), {"node_number": mesh.node_labels})
        values: dict[str, np.ndarray] = {"element_number": mesh.labels}
        for number in range(len(part.plies)):
            start = f"ply{number + 1}_" if len(part.plies) > 1 else ""
            named = part_values(part, number).items()
            values |= {f"{start}{with_unit(name, value.unit)}": value.values for name, value in named}
        _fill(root.create_group("CellData"), values)


def _fill(group: Any, values: dict[str, np.ndarray]) -> None:
    for name, value in values.items():
        group[name] = value


def write_csv(path: Path, part: Part, number: int, units: UnitSystem) -> None:
    """One ply: a row for each element, with its number, centre and values; every name ends in its unit.

    Centres are in ``units``, all else in SI units and degrees.
    """
    columns: dict[str, np.ndarray] = {"element": part.mesh.labels}
    for axis, values in zip("xyz", (units.length * part.mesh.centres).T, strict=True):
        columns[f"centre_{axis}_{units.name}"] = values
    for name, value in part_values(part, number).items():
        columns |= {with_unit(column, value.unit): values for column, values in _columns(name, value.values)}
    write_table(path, list(columns), zip(*(values.tolist() for values in columns.values()), strict=True))


def _columns(name: str, values: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """A column for a scalar, and one for each component of a vector or a tensor."""
    if values.ndim == 1:
        yield name, values
        return
    of_space = name.endswith("_direction") or name.startswith("line_force")
    endings = ("x", "y", "z") if of_space else {2: ("1", "2"), 3: ("11", "22", "12")}[values.shape[1]]
    for k, ending in enumerate(endings):
        yield f"{name}_{ending}", values[:, k]
