"""The plain weave in single precision against double precision, over the legal range of its parameters."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.response import UnitCellResponse, respond
from weavesim.ranges import QUANTITIES
from weavesim.run.fields import UNIT_CELL_FAILURE

# Of E A, of the yarn stiffness per width, and of that times a strain of 1e-6 squared: answers below are rounding.
FORCE_SHARE, TANGENT_SHARE, ENERGY_SHARE = 1e-9, 1e-4, 1e-12


def random_cell(rng: np.random.Generator, kind: str) -> PlainWeave:
    """Parameters at random in the ``legal`` or the ``plausible`` range of each, yarns that differ by any factor."""

    def within(quantity: str) -> float:
        low, high = getattr(QUANTITIES[quantity], kind)
        low = low or 1e-9
        return 10.0 ** rng.uniform(np.log10(low), np.log10(high))

    values = {
        "warp_modulus": within("yarn modulus"), "weft_modulus": within("yarn modulus"),
        "contact_modulus": within("contact modulus"), "contact_cross_section": within("cross-section"),
        "warp_cross_section": within("cross-section"), "weft_cross_section": within("cross-section"),
        "warp_half_spacing": within("yarn spacing"), "weft_half_spacing": within("yarn spacing"),
        "crossover_height": within("crossover height"), "warp_crimp_share": rng.choice([0.0, 1.0, rng.uniform()]),
        "contact": str(rng.choice(["bilateral", "unilateral"])),
        "contact_stiffness_value": within("contact stiffness") if rng.uniform() < 0.5 else None,
    }  # fmt: skip
    for yarn in ("warp", "weft"):
        # a yarn is at most as stiff in bending as a solid round one
        solid = values[f"{yarn}_cross_section"] ** 2 / (4.0 * np.pi)
        bending = rng.choice([0.0, solid * 10.0 ** rng.uniform(-6.0, 0.0)])
        values[f"{yarn}_second_moment"] = float(bending) if bending > 1e-40 else 0.0
    return PlainWeave(**values)


def random_cells(count: int, kind: str, seed: int) -> list[PlainWeave]:
    rng = np.random.default_rng(seed)
    cells = []
    while len(cells) < count:
        try:
            cells.append(random_cell(rng, kind))
        except InputError:  # values that do not go together
            continue
    return cells


def largest_errors(
    single: UnitCellResponse, double: UnitCellResponse, cells: list[PlainWeave]
) -> dict[str, np.ndarray]:
    """Errors over the larger of the value and a share of the stiffness."""
    axial = np.array([cell.axial_stiffness for cell in cells]).max(axis=1)
    per_width = np.array([cell.yarn_stiffness_per_width for cell in cells]).max(axis=1)
    across = 2.0 * np.array([cell.half_spacing for cell in cells])[:, ::-1]
    force, exact = single.force_per_width * across, double.force_per_width * across
    crossover = np.abs(double.crossover_force)
    size = np.maximum(np.abs(exact).max(axis=1), crossover) + FORCE_SHARE * axial
    energy = double.energy.max(axis=1) + ENERGY_SHARE * per_width
    return {
        "force": np.abs(force - exact).max(axis=1) / size,
        "crossover force": np.abs(single.crossover_force - double.crossover_force) / size,
        "energy": np.abs(single.energy - double.energy).max(axis=1) / energy,
    }


def tangent_error(single: UnitCellResponse, double: UnitCellResponse, cells: list[PlainWeave]) -> np.ndarray:
    """The same for the tangent; 0 where a yarn is neither slack nor taut to rounding, for there it jumps."""
    axial = np.array([cell.axial_stiffness for cell in cells])
    per_width = np.array([cell.yarn_stiffness_per_width for cell in cells]).max(axis=1)
    across = 2.0 * np.array([cell.half_spacing for cell in cells])[:, ::-1]
    known = (np.abs(double.force_per_width * across) > 1e-6 * axial).all(axis=1)
    size = np.abs(double.tangent).max(axis=(1, 2)) + TANGENT_SHARE * per_width
    return np.where(known, np.abs(single.tangent - double.tangent).max(axis=(1, 2)) / size, 0.0)


def strains(name: str, count: int, seed: int) -> np.ndarray:
    """From 0.5 to 1.3, and close to rest; the same numbers in both precisions."""
    rng = np.random.default_rng(seed)
    far = rng.uniform(-0.5, 0.3, (count, 2))
    near = 10.0 ** rng.uniform(-7.0, -1.0, (count, 2)) * rng.choice([-1.0, 1.0], (count, 2))
    return (far if name == "far" else near).astype(np.float32).astype(float)


@pytest.mark.parametrize("name", ["far", "near"])
@pytest.mark.parametrize("kind", ["plausible", "legal"])
def test_the_cell_in_single_precision(kind, name, manual):
    count = 2000
    cells, stretch = random_cells(count, kind, 3), 1.0 + strains(name, count, 4)
    single, double = (respond(cells, stretch, precision=precision) for precision in ("float32", "float64"))
    failed = ~(single.residual < UNIT_CELL_FAILURE) | ~(double.residual < UNIT_CELL_FAILURE)
    errors = largest_errors(single, double, cells)
    errors["tangent"] = tangent_error(single, double, cells)
    case = manual(
        "Unit cell", f"The plain weave in single precision, {kind} parameters, {name} strains",
        known=f"The same cells in double precision: {count} with parameters at random in the {kind} range of each, "
        "stretches from 0.5 to 1.3 or within 1e-7 to 0.1 of one. Errors are over the larger of the value and a share "
        f"of the stiffness: {FORCE_SHARE:g} E A, {TANGENT_SHARE:g} of the yarn stiffness per width. The requirement "
        "is 0.1 %, or the flag of a failed cell.",
    )  # fmt: skip
    rows = [
        [quantity, float(np.median(error)), float(np.nanmax(np.where(failed, 0.0, error)))]
        for quantity, error in errors.items()
    ]
    case.table(["quantity", "median error", "largest error without a flag"], rows)
    assert failed.mean() < {"plausible": 5e-3, "legal": 3e-2}[kind]
    for quantity, error in errors.items():
        silent = ~(error < 1e-3) & ~failed
        assert not silent.any(), (quantity, np.flatnonzero(silent)[:5], error[silent][:5])


@pytest.mark.parametrize("contact", ["bilateral", "unilateral"])
@pytest.mark.parametrize("contact_stiffness", [1e3, 1e6, 1e9, 1e12, 1e15])
def test_a_stiff_contact_carries_what_the_yarns_do(contact_stiffness, contact):
    """A soft fabric in a stiff contact: its crossover force was 3 kN instead of a millinewton."""
    cell = PlainWeave.glass_polypropylene(
        contact=contact, contact_stiffness_value=contact_stiffness, warp_second_moment=1e-20, weft_second_moment=1e-20,
        warp_compressive_stiffness=0.0, weft_compressive_stiffness=0.0,
    )  # fmt: skip
    stretch = [[1.0 + 1e-5, 1.0], [1.002, 0.998], [0.99, 1.005], [1.0, 1.0 - 3e-4], [1.02, 1.02]]
    single, double = (respond(cell, stretch, precision=precision) for precision in ("float32", "float64"))
    for error in largest_errors(single, double, [cell] * len(stretch)).values():
        assert error.max() < 1e-3
    assert double.crossover_force.max() > 0.0
