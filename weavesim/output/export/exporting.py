"""From the folder of a run to the files of other programs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...ranges import QUANTITIES, illegal
from ..files import check_writable, write_text
from ..stored.file import StoredRun
from .abaqus import abaqus_deck, calculix_deck
from .data_files import write_csv, write_hdf5, write_vtkhdf
from .drape_table import openradioss_deck, optistruct_table
from .formed import mapped_part, own_parts
from .lamina import ASSUMED, Lamina
from .lsdyna import lsdyna_deck
from .nastran import nastran_deck
from .part import Part
from .units import UNITS, UnitSystem

_SECOND_ORDER = ("triangle6", "quad8")


@dataclass(frozen=True)
class Export:
    """What to write, and how.

    Attributes:
        formats: names among ``FORMATS``.
        folder: of the files.
        unit: of lengths, "m" or "mm", also those of the mesh to map onto; stresses of decks follow.
        map_onto: mesh file that gets the plies; None for the sheets' own meshes.
        within: largest distance between that mesh and the formed sheets [m].
        whole: with mirrored copies.
        layers_per_ply: 2 or 1, see ``Part``.
        lamina: elastic constants; None for assumed ones.
        reference: vector from whose projection OpenRadioss counts angles.
    """

    formats: Sequence[str]
    folder: Path
    unit: str = "m"
    map_onto: Path | None = None
    within: float | None = None
    whole: bool = False
    layers_per_ply: int = 2
    lamina: Lamina | None = None
    reference: tuple[float, float, float] = (1.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if unknown := [name for name in self.formats if name not in FORMATS]:
            raise InputError(f"format {', '.join(map(repr, unknown))}: choose from {', '.join(FORMATS)}")
        if not self.formats:
            raise InputError(f"format: at least one is needed; choose from {', '.join(FORMATS)}")
        if self.unit not in UNITS:
            raise InputError(f"unit {self.unit!r}: choose from {', '.join(UNITS)}")
        if self.layers_per_ply not in (1, 2):
            raise InputError(f"layers per ply {self.layers_per_ply}: 2 (warp and weft apart) or 1 (along the warp)")
        if self.within is not None and not (np.isfinite(self.within) and self.within > 0.0):
            raise InputError(f"distance {self.within}: a positive length in metres is needed")
        if self.within is not None and (problem := illegal(self.within, QUANTITIES["gap"])):
            raise InputError(f"distance {self.within:g}: {problem}; farther away lie the fibres of something else")
        if not np.isfinite(self.reference).all() or not np.any(self.reference):
            raise InputError(f"reference {self.reference}: a direction is needed, such as 1 0 0")
        if self.map_onto is None and self.within is not None:
            raise InputError("distance: it has an effect only with a mesh to map onto; leave one out, or give both")
        if self.layers_per_ply == 1 and self.lamina is None and set(self.formats) & set(_WITH_CONSTANTS):
            raise InputError(
                "one layer per ply is a layer of woven material, for which no constants are assumed: give yours "
                "(--lamina), or let warp and weft be a layer each"
            )

    @property
    def units(self) -> UnitSystem:
        """System of the deck."""
        return UNITS[self.unit]


@dataclass
class Exported:
    """What was written.

    Attributes:
        files: in order.
        notes: what a user must know of them.
    """

    files: list[Path] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def export_run(run: StoredRun, wish: Export) -> Exported:
    """Write the files; all input is checked before the first one.

    Raises:
        InputError: a mesh that cannot be mapped onto, or a part that a format cannot take.
    """
    done = Exported()
    if run.outcome != "finished":
        done.notes.append(f"the run is {run.outcome}: this is its state at {run.time:.4g} s")
    if wish.map_onto is None:
        parts = own_parts(run, whole=wish.whole, layers_per_ply=wish.layers_per_ply)
    else:
        mapping = mapped_part(
            run, wish.map_onto, unit=wish.units.metres, within=wish.within, layers_per_ply=wish.layers_per_ply
        )
        parts = (mapping.part,)
        done.notes.append(
            f"mapped onto {mapping.part.mesh.element_count} elements; from their centres to the nearest formed sheet "
            f"{1e3 * mapping.mean_distance:.3g} mm on average, at most {1e3 * mapping.largest_distance:.3g} mm; "
            f"normals differ by up to {mapping.largest_tilt:.3g} degrees"
        )
    if wish.whole and not any(sheet.symmetry.planes for sheet in run.sheets):
        done.notes.append("no sheet is cut at a plane of symmetry: there are no mirrored copies to add")
    done.notes += [note for part in parts for note in part.notes]
    files = [pair for name in dict.fromkeys(wish.formats) for pair in FORMATS[name](parts, run, wish)]
    if set(wish.formats) & set(_WITH_CONSTANTS):
        done.notes.append(f"elastic constants of the layers: {(wish.lamina or ASSUMED).source or 'as given'}")
    if set(wish.formats) & {"lsdyna", "nastran", "openradioss"} and any(
        cells.kind in _SECOND_ORDER for part in parts for cells in part.mesh.cells
    ):
        done.notes.append("LS-DYNA, Nastran and OpenRadioss get the corner nodes of elements of second order only")
    check_writable(wish.folder)
    for path, write in files:
        write(path)
        done.files.append(path)
    return done


Files = Iterator[tuple[Path, Callable[[Path], object]]]


def _text(text: str) -> Callable[[Path], object]:
    return lambda path: write_text(path, text)


def _name(parts: Sequence[Part], run: StoredRun, wish: Export) -> str:
    return parts[0].name if wish.map_onto else run.name


def _abaqus(parts: Sequence[Part], run: StoredRun, wish: Export) -> Files:
    text = abaqus_deck(parts, wish.lamina or ASSUMED, wish.units)
    yield wish.folder / f"{_name(parts, run, wish)}_abaqus.inp", _text(text)


def _calculix(parts: Sequence[Part], run: StoredRun, wish: Export) -> Files:
    text = calculix_deck(parts, wish.lamina or ASSUMED, wish.units)
    yield wish.folder / f"{_name(parts, run, wish)}_calculix.inp", _text(text)


def _lsdyna(parts: Sequence[Part], run: StoredRun, wish: Export) -> Files:
    yield wish.folder / f"{_name(parts, run, wish)}.k", _text(lsdyna_deck(parts, wish.lamina or ASSUMED, wish.units))


def _nastran(parts: Sequence[Part], run: StoredRun, wish: Export) -> Files:
    yield wish.folder / f"{_name(parts, run, wish)}.bdf", _text(nastran_deck(parts, wish.lamina or ASSUMED, wish.units))


def _openradioss(parts: Sequence[Part], run: StoredRun, wish: Export) -> Files:
    name = _name(parts, run, wish)
    yield wish.folder / f"{name}_0000.rad", _text(openradioss_deck(parts, wish.units, wish.reference))
    yield wish.folder / f"{name}_drape.fem", _text(optistruct_table(parts))


def _each(parts: Sequence[Part], run: StoredRun, wish: Export, ending: str) -> Iterator[tuple[Part, Path]]:
    """Every part with the name of its file: that of the run, and of the sheet if there are several."""
    name = _name(parts, run, wish)
    for part in parts:
        yield part, wish.folder / (f"{name}{ending}" if len(parts) == 1 else f"{name}_{part.name}{ending}")


def _hdf5(parts: Sequence[Part], run: StoredRun, wish: Export) -> Files:
    for part, path in _each(parts, run, wish, ".h5"):
        yield path, partial(write_hdf5, part=part, run=run)


def _vtkhdf(parts: Sequence[Part], run: StoredRun, wish: Export) -> Files:
    for part, path in _each(parts, run, wish, ".vtkhdf"):
        yield path, partial(write_vtkhdf, part=part)


def _csv(parts: Sequence[Part], run: StoredRun, wish: Export) -> Files:
    for part, path in _each(parts, run, wish, ".csv"):
        for number in range(len(part.plies)):
            own = path if len(part.plies) == 1 else path.with_name(f"{path.stem}_ply{number + 1}.csv")
            yield own, partial(write_csv, part=part, number=number, units=wish.units)


_WITH_CONSTANTS = ("calculix", "abaqus", "lsdyna", "nastran")
FORMATS: dict[str, Callable[[Sequence[Part], StoredRun, Export], Files]] = {
    "calculix": _calculix,
    "abaqus": _abaqus,
    "lsdyna": _lsdyna,
    "nastran": _nastran,
    "openradioss": _openradioss,
    "vtkhdf": _vtkhdf,
    "hdf5": _hdf5,
    "csv": _csv,
}
