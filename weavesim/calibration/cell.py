"""Parameters of a unit cell from biaxial tests, by the batched response of a material point."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import InputError, did_you_mean, logged_from
from ..fabric.cell import LinearMembrane, UnitCell
from ..fabric.cell.weaves import CrossedYarns
from ..fabric.curve import noise
from .fitting.fit import Problem, Unknown
from .options import CalibrationOptions
from .readings import Biaxial
from .scatter import UNSTATED, Scatter

BIAXIAL = "biaxial"
# Least standard deviation of a force, as a share of the largest, and a residual of the cell that counts as failure.
LEAST_NOISE, LARGEST_CELL_RESIDUAL = 1.0e-3, 1.0e-6
_BOTH = ("warp", "weft")


@dataclass(frozen=True)
class CellModel:
    """How values become cells, and cells forces.

    Attributes:
        base: the cell that supplies everything else.
        make: a cell from values by name.
        names: of the unknowns, in order.
        strain: of all tests, (n, 2).
    """

    base: UnitCell
    make: Callable[[Mapping[str, float]], UnitCell]
    names: tuple[str, ...]
    strain: np.ndarray

    def cell(self, values: np.ndarray) -> UnitCell:
        """Of values (p,)."""
        return self.make(dict(zip(self.names, values.tolist(), strict=True)))

    def forces(self, sets: np.ndarray, strain: np.ndarray) -> np.ndarray:
        """Forces per width of sets of values (s, p) at strains (n, 2), (s, n, 2) [N/m]; NaN where a cell failed."""
        from ..fabric.response import respond

        count = len(strain)
        # no warnings about cells that a fit tries on its way
        with logged_from(logging.ERROR, "weavesim.fabric.response"):
            cells: list[UnitCell | None] = []
            for values in sets:
                try:
                    cells.append(self.cell(values))
                except InputError:
                    cells.append(None)
            made = [cell for cell in cells if cell is not None]
            result = np.full((len(sets), count, 2), np.nan)
            if not made:
                return result
            # repeats share their strains
            distinct, place = np.unique(strain, axis=0, return_inverse=True)
            answer = respond(
                [cell for cell in made for _ in range(len(distinct))], np.tile(1.0 + distinct, (len(made), 1))
            )
        force = np.where(answer.residual[:, None] <= LARGEST_CELL_RESIDUAL, answer.force_per_width, np.nan)
        result[[cell is not None for cell in cells]] = force.reshape(len(made), len(distinct), 2)[:, place.ravel()]
        return result

    def predict(self, sets: np.ndarray) -> np.ndarray:
        """Both forces of every row, (s, 2 n)."""
        return self.forces(sets, self.strain).reshape(len(sets), -1)


def cell_problem(
    tests: Sequence[Biaxial], base: UnitCell, options: CalibrationOptions
) -> tuple[Problem, CellModel, dict[str, Scatter]]:
    """The fit of a unit cell.

    Raises:
        InputError: a kind of cell whose parameters are not known, or names that it does not have.
    """
    unknowns, make = _unknowns_of(base, options)
    model = CellModel(base, make, tuple(u.name for u in unknowns), np.concatenate([test.strain for test in tests]))
    observed = np.concatenate([test.force for test in tests])
    sigma, scatter = _sigma(tests, observed, options.noise)
    size = [2 * len(test.lines) for test in tests]
    members = ratios(tests)
    problem = Problem(
        unknowns, model.predict, observed.ravel(), sigma.ravel(), np.repeat(members, size),
        np.repeat(np.arange(len(tests)), size), tuple(f"{BIAXIAL} {k + 1}" for k in range(max(members) + 1)),
    )  # fmt: skip
    return problem, model, {BIAXIAL: scatter}


def ratios(tests: Sequence[Biaxial]) -> list[int]:
    """Number of the ratio of strains of each test: tests along one path, within 5 degrees of it, are repeats."""
    found: dict[int, int] = {}
    result = []
    for test in tests:
        end = test.strain[int(np.argmax(np.abs(test.strain).max(axis=1)))]
        angle = round(float(np.degrees(np.arctan2(end[1], end[0]))) / 5.0)
        result.append(found.setdefault(angle, len(found)))
    return result


def _sigma(tests: Sequence[Biaxial], observed: np.ndarray, stated: float | None) -> tuple[np.ndarray, Scatter]:
    """Standard deviation of every force (n, 2): of repeats at the same strains, as stated, or from the points."""
    largest = float(np.abs(observed).max())
    spread = _of_repeats(tests, largest)
    if spread is not None:
        sigma, count = spread
        source, yardstick = f"scatter of {count} repeats", float(np.sqrt(np.mean(sigma**2)))
    elif stated is not None:
        sigma = np.full(observed.shape, stated * largest)
        source, yardstick = f"stated noise, {stated:.3g} of the largest force", stated * largest
    else:
        values = []
        for test in tests:
            along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(test.strain, axis=0), axis=1))])
            along = along + 1.0e-12 * np.arange(len(along))
            value = max(noise(along, test.force[:, 0]), noise(along, test.force[:, 1]), UNSTATED * largest)
            values.append(np.full(test.force.shape, value))
        sigma = np.concatenate(values)
        source, yardstick = "noise of the points, or 1 % of the largest force", float(sigma.max())
    reach = np.array([0.0, 1.0])
    return sigma, Scatter(reach, np.full(2, yardstick), source, yardstick)


def _of_repeats(tests: Sequence[Biaxial], largest: float) -> tuple[np.ndarray, int] | None:
    """Scatter of tests along the same path of strains; None if no two share one."""
    paths: dict[int, list[int]] = {}
    for k, member in enumerate(ratios(tests)):
        paths.setdefault(member, []).append(k)
    if not any(len(members) > 1 for members in paths.values()):
        return None
    sigma: list[np.ndarray] = [np.empty((0, 2))] * len(tests)
    alone = LEAST_NOISE * largest
    for members in paths.values():
        curves = []
        size = [np.linalg.norm(tests[k].strain, axis=1) for k in members]
        grid = np.linspace(max(s.min() for s in size), min(s.max() for s in size), 30)
        for k, s in zip(members, size, strict=True):
            order = np.argsort(s, kind="stable")
            curves.append([np.interp(grid, s[order], tests[k].force[order, f]) for f in (0, 1)])
        if len(members) > 1:
            variance = np.array(curves).var(axis=0, ddof=1)
            # forces grow along the path, and so does their scatter; a moving mean of a third of it
            weight = np.exp(-0.5 * ((grid[:, None] - grid) / (0.15 * np.ptp(grid))) ** 2)
            smooth = np.sqrt(variance @ weight.T / weight.sum(axis=1))
            smooth = np.maximum(smooth, max(0.2 * float(np.sqrt(variance.mean())), alone))
        else:
            smooth = np.full((2, len(grid)), np.nan)
        for k, s in zip(members, size, strict=True):
            sigma[k] = np.column_stack([np.interp(s, grid, smooth[f]) for f in (0, 1)])
    joined = np.concatenate(sigma)
    return np.where(np.isnan(joined), np.nanmean(joined), joined), max(map(len, paths.values()))


# ------------------------------------------------------------------------------------------------ parameters of cells


def _unknowns_of(
    base: UnitCell, options: CalibrationOptions
) -> tuple[tuple[Unknown, ...], Callable[[Mapping[str, float]], UnitCell]]:
    if isinstance(base, CrossedYarns):
        return _of_crossed_yarns(base, options.families)
    if isinstance(base, LinearMembrane):
        return _of_membrane(base, options.families)
    fields = {
        name: float(value)
        for name in type(base).model_fields
        if isinstance(value := getattr(base, name), float) and value > 0.0
    }
    wrong = [name for name in options.fit if name not in fields]
    if not options.fit or wrong:
        what = f"fit = {wrong[0]!r}{did_you_mean(wrong[0], fields)}" if wrong else "fit is not given"
        raise InputError(
            f"{type(base).__name__}: {what}; for this kind of cell name what is to be fitted, of {', '.join(fields)}"
        )
    unknowns = tuple(
        Unknown(name, "", f"field of {type(base).__name__}", value, 1.0e-3 * value, 1.0e3 * value)
        for name, value in fields.items()
    )
    return unknowns, lambda values: base.model_copy(update=dict(values))


def _of_membrane(
    base: LinearMembrane, families: str
) -> tuple[tuple[Unknown, ...], Callable[[Mapping[str, float]], UnitCell]]:
    warp, weft = base.warp_stiffness, base.weft_stiffness
    is_shared = families == "shared" or (families == "auto" and warp == weft)
    largest = max(warp, weft)
    entries = [("stiffness", warp)] if is_shared else [("warp_stiffness", warp), ("weft_stiffness", weft)]
    unknowns = [
        Unknown(name, "N/m", "membrane stiffness" + ("" if is_shared else f" of the {name[:4]}"), value,
                1.0e-3 * value, 1.0e3 * value)
        for name, value in entries
    ]  # fmt: skip
    unknowns.append(
        Unknown("coupling_stiffness", "N/m", "force of one family over the strain of the other",
                base.coupling_stiffness, -0.95 * largest, 0.95 * largest, is_log=False, size=0.1 * largest)
    )  # fmt: skip

    def make(values: Mapping[str, float]) -> UnitCell:
        both = [values.get(f"{yarn}_stiffness", values.get("stiffness", 0.0)) for yarn in _BOTH]
        return LinearMembrane(
            warp_stiffness=both[0], weft_stiffness=both[1], coupling_stiffness=values["coupling_stiffness"]
        )

    return tuple(unknowns), make


def _of_crossed_yarns(
    base: CrossedYarns, families: str
) -> tuple[tuple[Unknown, ...], Callable[[Mapping[str, float]], UnitCell]]:
    axial, bending = base.axial_stiffness, base.bending_stiffness
    is_shared = families == "shared" or (families == "auto" and axial[0] == axial[1] and bending[0] == bending[1])
    unknowns = []
    for name, unit, meaning, both in (
        ("yarn_stiffness", "N", "E A", axial),
        ("yarn_bending", "N m^2", "E I", bending),
    ):
        # a test of the yarn gives E A, the thickness hints at L_3; nobody measures E_3, and hardly anybody E I
        rank = 3 if name == "yarn_stiffness" else 0
        for prefix, value in (("", both[0]),) if is_shared else zip(("warp_", "weft_"), both, strict=True):
            if value > 0.0:
                of = f" of the {prefix[:4]}" if prefix else " of a yarn"
                unknowns.append(
                    Unknown(prefix + name, unit, meaning + of, value, 1.0e-3 * value, 1.0e3 * value, rank=rank)
                )
    spacing = 2.0 * min(base.half_spacing)
    if base.crossover_height > 0.0:
        unknowns.append(
            Unknown("crossover_height", "m", "L_3, distance of the yarn axes at a crossover", base.crossover_height,
                    min(1.0e-3 * spacing, 0.1 * base.crossover_height), max(spacing, base.crossover_height), rank=2)
        )  # fmt: skip
    contact = base.contact_stiffness
    unknowns.append(
        Unknown("contact_stiffness", "N/m", "E_3 A_3 / L_3, force over approach of a crossover", contact,
                1.0e-3 * contact, 1.0e3 * contact, rank=1)
    )  # fmt: skip

    def make(values: Mapping[str, float]) -> UnitCell:
        changes: dict[str, float] = {}
        for k, yarn in enumerate(_BOTH):
            stiffness = values.get(f"{yarn}_yarn_stiffness", values.get("yarn_stiffness", axial[k]))
            modulus = stiffness / getattr(base, f"{yarn}_cross_section")
            bend = values.get(f"{yarn}_yarn_bending", values.get("yarn_bending", bending[k]))
            changes |= {f"{yarn}_modulus": modulus, f"{yarn}_second_moment": bend / modulus}
        height = values.get("crossover_height", base.crossover_height)
        changes["crossover_height"] = height
        if base.contact_stiffness_value is None:
            changes["contact_modulus"] = values["contact_stiffness"] * height / base.contact_cross_section
        else:
            changes["contact_stiffness_value"] = values["contact_stiffness"]
        return base.model_copy(update={name: float(f"{value:.9g}") for name, value in changes.items()})

    return tuple(unknowns), make
