"""What the unit cells answer, against closed solutions and independent minimisation."""

import math

import numpy as np
import pytest
import scipy.optimize
from matplotlib.figure import Figure

from tests.support.registered_cells import CELLS
from weavesim.fabric.cell.membrane import LinearMembrane
from weavesim.fabric.cell.weaves import FloatWeave, PlainWeave
from weavesim.fabric.presets import UNIT_CELLS
from weavesim.fabric.response import respond

# Directions in the plane of stretches, and the largest strain along each.
PATHS = {
    "uniaxial": ((1.0, 0.0), 0.03),
    "biaxial 1:1": ((1.0, 1.0), 0.03),
    "biaxial 2:1": ((1.0, 0.5), 0.03),
    "biaxial 1:2": ((0.5, 1.0), 0.03),
    "pulled and pushed 1:-1": ((1.0, -1.0), 0.03),
    "compressive": ((-1.0, -1.0), 0.1),
    "sheared under tension": ((1.0, 1.0), 0.02),
}


def minimum(registered, cell, path: np.ndarray) -> np.ndarray:
    """SciPy's minimum of the NumPy energy at the end of a path of (warp stretch, weft stretch, angle): unknowns, (k,).

    Each point begins where the one before ended; only the last has to be sharp.
    """
    unit = 1e-4 * max(cell.yarn_stiffness_per_width)
    scale, q = registered.unknown_scale, np.array(cell.initial_unknowns)
    if not len(q):
        return q
    for k, (warp, weft, angle) in enumerate(path):

        def energy(x, stretch=(warp, weft), angle=angle):
            return registered.reference(cell, stretch, angle, x * scale) / unit

        if k + 1 < len(path):
            options = {"xatol": 1e-5, "fatol": 1e-9, "maxiter": 8000}
            q = scipy.optimize.minimize(energy, q / scale, method="Nelder-Mead", options=options).x * scale
            continue
        options = {"xatol": 1e-10, "fatol": 1e-15, "maxiter": 8000}
        q = scipy.optimize.minimize(energy, q / scale, method="Nelder-Mead", options=options).x * scale
        q = scipy.optimize.minimize(energy, q / scale, method="Powell", options={"xtol": 1e-12, "ftol": 1e-16}).x
        q = np.atleast_1d(q) * scale
    return q


def reference_forces(registered, cell, point: np.ndarray, q: np.ndarray, change: float = 1e-5) -> np.ndarray:
    """n_1, n_2, m [N/m]: differences of the NumPy energy at given unknowns, which the minimum makes exact."""
    result = []
    for k in range(3):
        ends = []
        for sign in (change, -change):
            moved = np.array(point)
            moved[k] += sign
            ends.append(registered.reference(cell, moved[:2], moved[2], q))
        result.append((ends[0] - ends[1]) / (2.0 * change))
    return np.array(result)


@pytest.mark.slow
@pytest.mark.parametrize("name", CELLS)
def test_response_is_that_of_an_independent_minimisation(name, manual):
    """Uniaxial, biaxial and compressive, for every registered cell."""
    registered = CELLS[name]
    cell = registered.make()
    case = manual(
        "Unit cell", f"Uniaxial, biaxial and compressive response: {name}",
        known="the cell's energy, written independently in NumPy (`tests/support/registered_cells.py`), minimised by "
        "SciPy along the path; forces by differences of that energy. A cell alone has no mesh.",
    )  # fmt: skip
    figure = Figure(figsize=(5.0, 3.2))
    axes = figure.add_subplot()
    rows = []
    for label, (direction, largest) in PATHS.items():
        share = np.linspace(0.1, 1.0, 10)
        angle = 0.5 * share if label.startswith("sheared") else 0.0 * share
        path = np.column_stack([1.0 + largest * share[:, None] * np.array(direction), angle])
        q = minimum(registered, cell, path)
        ours = respond(cell, path[-1:, :2], path[-1:, 2], increment_count=50)
        force = np.append(ours.force_per_width[0], ours.moment[0])
        least = registered.reference(cell, path[-1, :2], path[-1, 2], q)
        assert ours.energy[0].sum() <= least * (1.0 + 1e-9) + 1e-12
        # at our unknowns: SciPy's are exact to the root of its rounding only, and then the forces are not
        expected = reference_forces(registered, cell, path[-1], ours.unknowns[0])
        scale = max(np.abs(expected).max(), 1e-6 * max(cell.yarn_stiffness_per_width))
        deviation = np.abs(force - expected).max() / scale
        assert deviation < 1e-6
        gap = ours.energy[0].sum() / least - 1.0 if least > 0.0 else 0.0
        assert abs(gap) < 1e-9
        rows.append([label, path[-1, 0], path[-1, 1], *force, deviation, gap])
        strain = np.linspace(0.0, 1.0, 60)[1:]
        curve = respond(cell, 1.0 + largest * strain[:, None] * np.array(direction), angle[-1] * strain)
        axes.plot(100 * largest * strain, curve.force_per_width[:, 0] / 1e3, label=label)
    columns = ["path", "warp stretch", "weft stretch", "n_1 [N/m]", "n_2 [N/m]", "m [N/m]"]
    case.table([*columns, "largest deviation of the forces", "energy over SciPy's minimum - 1"], rows)
    axes.set(xlabel="strain along the path [%]", ylabel="n_1 [kN/m]")
    axes.set_yscale("symlog", linthresh=1.0)
    axes.legend(fontsize=6)
    axes.grid(True, lw=0.3)
    case.figure(figure)


def sawtooth(share: float, **given) -> PlainWeave:
    """Hard yarns and contact; ``share`` scales their bending stiffness."""
    values = {
        "warp_modulus": 1e12, "weft_modulus": 1e12, "contact_modulus": 1e6, "warp_cross_section": 1e-6,
        "weft_cross_section": 1e-6, "contact_cross_section": 1e-6, "warp_second_moment": 1e-14 * share,
        "weft_second_moment": 1e-14 * share, "warp_half_spacing": 2.5e-3, "weft_half_spacing": 2.0e-3,
        "crossover_height": 6e-4, "warp_crimp_share": 0.6, "contact_stiffness_value": 1e9,
    }  # fmt: skip
    return PlainWeave(**(values | given))


def crimp_interchange(cell, warp_stretch: float) -> float:
    """Weft stretch at which the weft carries nothing while the warp is held at ``warp_stretch``."""

    def weft_force(weft_stretch: float) -> float:
        return respond(cell, [warp_stretch, weft_stretch]).force_per_width[0, 1]

    return scipy.optimize.brentq(weft_force, 0.9, 1.02, xtol=1e-13)


def test_crimp_interchange(manual):
    """Yarns that neither stretch nor bend: one straightens, the other crimps, both at their full length."""
    case = manual(
        "Unit cell", "Crimp interchange against the sawtooth",
        known="pin-jointed inextensible yarns on a hard contact (Kawabata's sawtooth): with chords "
        r"$\ell_k=\sqrt{L_k^2+h_k^2}$ and constant $h_1+h_2$, a warp in tension drops to "
        r"$h_1'=\sqrt{\ell_1^2-\lambda_1^2L_1^2}$ and the free weft rises to $h_1+h_2-h_1'$, so that "
        r"$\lambda_2=\sqrt{\ell_2^2-(h_1+h_2-h_1')^2}/L_2$. The cell tends to it as the bending stiffness of the "
        "yarns tends to zero.",
    )  # fmt: skip
    cell = sawtooth(1.0)
    (l1, l2), (big1, big2), (h1, h2) = cell.chord_length, cell.half_spacing, cell.crimp_height
    stretches = 1.0 + (l1 / big1 - 1.0) * np.array([0.25, 0.5, 0.75, 0.95])
    exact = np.array([math.sqrt(l2**2 - (h1 + h2 - math.sqrt(l1**2 - (s * big1) ** 2)) ** 2) / big2 for s in stretches])
    rows, errors = [], []
    for share in (1e-3, 1e-4, 1e-5, 1e-6):
        found = np.array([crimp_interchange(sawtooth(share), stretch) for stretch in stretches])
        errors.append(np.abs(found - exact).max() / (1.0 - exact).max())
        rows.append([f"{share:g}", *(f"{value:.7f}" for value in found), errors[-1]])
    # without any bending stiffness a weft that is shorter than this would be slack, and its stretch not defined
    assert np.allclose(-np.diff(np.log10(errors)), 1.0, atol=0.05)
    assert errors[-1] < 1e-4
    assert errors[0] < 0.1
    header = [f"weft stretch at warp stretch {stretch:.5f}" for stretch in stretches]
    case.table(
        ["bending stiffness, share", *header, "deviation over the largest contraction"],
        [["sawtooth", *(f"{value:.7f}" for value in exact), ""], *rows],
    )
    case.text("The error falls with the bending stiffness to the first power.")


def test_straight_bars(manual):
    """Without crimp every cell of crossed yarns is two bars: the membrane of EA over the spacing."""
    case = manual(
        "Unit cell", "Yarns without crimp are straight bars",
        known=r"$n_k=EA_k(\lambda_k-1)$ over the spacing, $EA^c_k$ in compression; warp and weft are not coupled",
    )  # fmt: skip
    given = UNIT_CELLS["plain-weave"]().model_dump() | {"crossover_height": 0.0, "contact_stiffness_value": 1e5}
    rows = []
    for name, cell in (("plain weave", PlainWeave(**given)), ("2/2 twill", FloatWeave(**given, repeat=4))):
        stretch = np.array([[1.05, 0.9], [1.2, 1.3], [0.95, 1.1], [0.9, 0.97]])
        spacing = 2.0 * np.array(cell.half_spacing[::-1])
        stiffness = np.where(stretch > 1.0, cell.axial_stiffness, cell.compressive_stiffness) / spacing
        response = respond(cell, stretch)
        expected = stiffness * (stretch - 1.0)
        deviation = np.abs(response.force_per_width / expected - 1.0).max()
        assert deviation < 1e-8
        assert np.abs(response.tangent[:, 0, 1]).max() < 1e-9 * stiffness.max()
        rows.append([name, deviation])
    case.table(["cell", "largest deviation of n_1, n_2 over four pairs of stretches"], rows)


def test_floats_take_the_crimp_out(manual):
    """The longer the floats, the nearer the fabric is to straight yarns, in proportion to the crimp that is left."""
    case = manual(
        "Unit cell", "Floats: from the plain weave to straight yarns",
        known="a repeat of N = 2 is the plain weave, whose hand-written code shares nothing with the weaves with "
        "floats. With longer floats the compliance tends to that of straight yarns, $1/EA$ per length: beams and "
        "floats are in series, so the difference falls as 1/N.",
    )  # fmt: skip
    given = UNIT_CELLS["plain-weave"]().model_dump()
    stretch = np.array([[1.01, 1.0], [1.03, 1.03], [0.95, 1.02], [0.9, 0.92]])
    plain, two = respond(PlainWeave(**given), stretch), respond(FloatWeave(**given, repeat=2), stretch)
    deviation = np.abs(two.force_per_width - plain.force_per_width).max() / np.abs(plain.force_per_width).max()
    assert deviation < 1e-9
    assert np.allclose(two.crossover_force, plain.crossover_force, rtol=1e-7)
    straight = PlainWeave(**given).yarn_stiffness_per_width[0]
    repeats, excess = [2, 4, 8, 16], []
    for repeat in repeats:
        # a tension that straightens the crimp: equal in both yarns, so that nothing moves but along them
        cell = FloatWeave(**given, repeat=repeat)
        wanted = 0.001 * straight
        strain = scipy.optimize.brentq(
            lambda e, cell=cell, n=wanted: respond(cell, [1.0 + e, 1.0 + e]).force_per_width[0, 0] - n,
            1e-5,
            0.1,
            xtol=1e-14,
        )
        excess.append(strain / (wanted / straight) - 1.0)
    orders = np.diff(np.log(excess)) / np.diff(np.log(repeats))
    assert np.allclose(orders, -1.0, atol=0.02)
    case.table(["plain weave against N = 2", "largest deviation over the largest force"], [["n_1, n_2", deviation]])
    case.table(
        ["repeat N", "strain at 0.1 % of EA over that of straight yarns, minus 1", "observed order in 1/N"],
        [
            [n, e, "" if k == 0 else f"{-orders[k - 1]:.3f}"]
            for k, (n, e) in enumerate(zip(repeats, excess, strict=True))
        ],
    )


def test_slack_weft_only_bends(manual):
    """Against a weft without axial stiffness the warp's crimp meets a cantilever."""
    case = manual(
        "Unit cell", "A slack yarn bends only",
        known=r"a warp without bending stiffness presses on a weft without axial stiffness: $-k_c(w_1+w_2)=M_\varphi "
        r"X/\ell^2$ with $M_\varphi=3EI\varphi/\ell^0$ of the weft, and the same force is $N_1\sin\theta_1$ of the "
        "warp; one unknown remains, found by SciPy.",
    )  # fmt: skip
    rows = []
    for warp_stretch in (1.002, 1.01, 1.03):
        cell = sawtooth(
            0.0, warp_modulus=1e9, weft_modulus=1e9, weft_cross_section=1e-17, weft_second_moment=1e-16,
            weft_compressive_stiffness=0.0, contact_stiffness_value=1e6,
        )  # fmt: skip
        (big1, big2), (h1, h2), (l1, l2) = cell.half_spacing, cell.crimp_height, cell.chord_length

        def press_of_weft(w2, h2=h2, big2=big2, l2=l2, cell=cell):
            height = h2 + w2
            rotation = math.atan2(height, big2) - math.atan2(h2, big2)
            return 3.0 * cell.bending_stiffness[1] / l2 * rotation * big2 / (height**2 + big2**2)

        def missing(w2, h1=h1, big1=big1, l1=l1, cell=cell, stretch=warp_stretch, press_of_weft=press_of_weft):
            press = press_of_weft(w2)
            height = h1 - w2 - press / cell.contact_stiffness
            length = math.hypot(stretch * big1, height)
            return cell.axial_stiffness[0] * (length / l1 - 1.0) * height / length - press

        press = press_of_weft(scipy.optimize.brentq(missing, 0.0, h1, xtol=1e-18, rtol=1e-14))
        response = respond(cell, [warp_stretch, 1.0])
        deviation = response.crossover_force[0] / (2.0 * press) - 1.0
        assert abs(deviation) < 1e-6
        rows.append([warp_stretch, 2.0 * press, response.crossover_force[0], deviation])
    case.table(["warp stretch", "crossover force, expected [N]", "got [N]", "deviation"], rows)


def test_linear_membrane_is_exact(manual):
    case = manual("Unit cell", "Linear membrane", known="$n_1=C_{11}e_1+C_{12}e_2$, $n_2=C_{12}e_1+C_{22}e_2$")
    cell = LinearMembrane(warp_stiffness=2e5, weft_stiffness=1e5, coupling_stiffness=3e4)
    stretch = np.array([[1.02, 1.0], [0.9, 1.1], [1.3, 1.3]])
    expected = (stretch - 1.0) @ np.array([[2e5, 3e4], [3e4, 1e5]])
    response = respond(cell, stretch)
    deviation = np.abs(response.force_per_width - expected).max() / expected.max()
    assert deviation < 1e-14
    assert np.all(response.iterations == 0)
    case.table(["largest deviation over the largest force"], [[deviation]])
