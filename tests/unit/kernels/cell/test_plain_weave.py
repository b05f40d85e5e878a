"""The plain-weave cell against an independent minimisation of its energy, and its limits with closed forms."""

import numpy as np
import pytest
import scipy.optimize

from tests.support.plain_weaves import INCREMENT_COUNT, Reference, half_cell, random_cell, swapped
from weavesim.errors import InputError
from weavesim.fabric import response as response_module
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.response import respond


@pytest.fixture(scope="module", autouse=True)
def described_once():
    """Ten thousand cells are written for the device, and looked at for unusual values, once and not at every step."""
    known = {}

    def once(function):
        def kept(cell, *arguments):
            key = function, id(cell), *arguments
            if key not in known:
                known[key] = cell, function(cell, *arguments)  # the cell too, so that its id stays its own
            return known[key][1]

        return kept

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(PlainWeave, "device_parameters", once(PlainWeave.device_parameters))
        patch.setattr(response_module, "unusual_values", once(response_module.unusual_values))
        yield


@pytest.fixture(scope="module")
def many():
    """10,000 cells, stretches from 0.5 to 1.3, the kernel's answer and the reference with its own minimum."""
    rng = np.random.default_rng(7)
    cells = [random_cell(rng) for _ in range(10_000)]
    stretch = rng.uniform(0.5, 1.3, (len(cells), 2))
    reference = Reference.of(cells)
    return (
        cells,
        stretch,
        half_cell(cells, stretch, increment_count=INCREMENT_COUNT),
        reference,
        reference.follow(stretch),
    )


def relative_difference(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Largest difference of each row over the largest entry of b's row."""
    return np.abs(a - b).max(axis=1) / np.abs(b).max(axis=1)


@pytest.mark.slow
def test_energy_and_forces_agree_with_an_independent_minimisation(many):
    _, stretch, response, reference, w = many
    u = (stretch - 1.0) * reference.spacing
    energy = reference.energy(u, w)
    assert np.abs(response.energy.sum(axis=1) / energy - 1.0).max() < 1e-6
    assert relative_difference(response.force, reference.gradient(u, w)[0]).max() < 1e-6
    crossover = -2.0 * reference._contact_stiffness(w) * w.sum(axis=1)
    scale = np.maximum(np.abs(response.force).max(axis=1), np.abs(crossover))
    assert (np.abs(response.crossover_force - crossover) / scale).max() < 1e-6
    per_width = reference.gradient(u, w)[0] / (2.0 * reference.spacing[:, ::-1])
    assert relative_difference(response.force_per_width, per_width).max() < 1e-6


@pytest.mark.slow
def test_reference_itself_agrees_with_scipy(many):
    """The minimum of SciPy's trust-region method along the same path, for the first hundred cells."""
    cells, stretch, response, _, _ = many
    worst = 0.0
    for cell, ends, force in zip(cells[:100], stretch[:100], response.force[:100], strict=True):
        one = Reference.of([cell])
        # dimensionless unknowns and energy: SciPy's tolerances are absolute
        size, unit = one.spacing[0], one.tensile.max() * one.spacing.max() ** 2
        w = np.zeros(2)
        for share in np.linspace(0.1, 1.0, 10):
            u = (share * (ends - 1.0) * one.spacing[0])[None]
            result = scipy.optimize.minimize(
                lambda q, u=u, one=one, size=size, unit=unit: one.energy(u, (q * size)[None])[0] / unit,
                w / size,
                jac=lambda q, u=u, one=one, size=size, unit=unit: one.gradient(u, (q * size)[None])[1][0] * size / unit,
                hess=lambda q, u=u, one=one, size=size, unit=unit: one.hessian(u, (q * size)[None])[0]
                * np.outer(size, size) / unit,
                method="trust-exact",
                options={"gtol": 1e-12, "initial_trust_radius": 0.05, "max_trust_radius": 0.2},
            )  # fmt: skip
            w = result.x * size
        found = one.gradient(u, w[None])[0][0]
        worst = max(worst, np.abs(found - force).max() / np.abs(force).max())
    assert worst < 1e-6


@pytest.mark.slow
def test_solution_is_a_strict_minimum(many):
    _, stretch, response, reference, _ = many
    u = (stretch - 1.0) * reference.spacing
    assert np.linalg.eigvalsh(reference.hessian(u, response.height_change)).min() > 0.0
    assert response.residual.max() < 1e-9


@pytest.mark.slow
def test_second_start_finds_the_same_point(many):
    """From anywhere within a third of the chord, in one increment: the energy has one minimum."""
    cells, stretch, response, reference, _ = many
    size = np.hypot(reference.spacing, reference.height)
    start = np.random.default_rng(3).uniform(-0.3, 0.3, (len(cells), 2)) * size
    again = half_cell(cells, stretch, increment_count=1, start=start)
    assert relative_difference(again.height_change / size + 1.0, response.height_change / size + 1.0).max() < 1e-6
    assert relative_difference(again.force, response.force).max() < 1e-6


@pytest.mark.parametrize("contact", ["bilateral", "unilateral"])
@pytest.mark.parametrize("compressive", [None, 0.0])
@pytest.mark.parametrize("from_rest", [True, False])
def test_last_step_needs_no_evaluation_after_it(contact, compressive, from_rest):
    """Small steps, like time steps: dPi/dw at the end of the iteration is within the tolerance of 1e-11 it reports."""
    rng = np.random.default_rng(5)
    count = 500
    limits = {"warp_compressive_stiffness": compressive, "weft_compressive_stiffness": compressive}
    cells = [random_cell(rng, contact=contact, **limits) for _ in range(count)]
    reference = Reference.of(cells)
    stretch = np.ones((count, 2)) if from_rest else rng.uniform(0.99, 1.02, (count, 2))
    before = respond(cells, stretch)
    size_before, _ = reference.size((stretch - 1.0) * reference.spacing, before.unknowns)
    share_of_one = []
    for change in (1e-8, 1e-6, 1e-5, 1e-4, 1e-3):
        moved = stretch + change * rng.normal(size=(count, 2))
        step = respond(cells, moved, increment_count=1, start=before.unknowns)
        u = (moved - 1.0) * reference.spacing
        size, rounding = reference.size(u, step.unknowns)
        left = np.abs(reference.gradient(u, step.unknowns)[1]).max(axis=1)
        floor = 1e-9 * np.array([max(cell.axial_stiffness) for cell in cells])
        share = np.maximum(left - rounding, 0.0) / (np.maximum(size, size_before) + floor)
        assert step.residual.max() <= 1e-11
        assert np.quantile(share, 0.99) < 1e-11
        # at rest kinks of the law meet: a few stiff contacts that open keep more, of forces near zero
        assert share.max() < (1e-4 if from_rest and contact == "unilateral" else 2e-10)
        share_of_one.append(np.mean(step.iterations == 0.0))
    # most small steps from an equilibrium take one evaluation, and few large ones
    if not from_rest:
        assert share_of_one[1] > 0.8 and share_of_one[-1] < 0.2


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_yarns_touch_in_the_first_step_from_rest(precision):
    """At rest unilateral contact is neither open nor closed: what presses it closed meets it at once."""
    cells = [
        glass_polypropylene().unit_cell.model_copy(update={"contact": kind}) for kind in ("bilateral", "unilateral")
    ]
    for pull in (1e-8, 1e-6, 1e-5, 1e-4):
        forces = [
            respond(cell, [1.0 + pull, 1.0], increment_count=1, precision=precision).force_per_width[0, 0]
            for cell in cells
        ]
        assert forces[1] == pytest.approx(forces[0], rel=1e-3)


def test_condensed_tangent_is_the_derivative_of_the_forces():
    rng = np.random.default_rng(11)
    cells = [random_cell(rng) for _ in range(300)]
    stretch = rng.uniform(0.7, 1.2, (300, 2))
    centre = half_cell(cells, stretch)
    small = 1e-6
    numerical = np.empty((300, 2, 2))
    for column in range(2):
        change = np.zeros(2)
        change[column] = small
        ends = [
            half_cell(cells, stretch + sign * change, increment_count=1, start=centre.height_change).force
            for sign in (1.0, -1.0)
        ]
        spacing = Reference.of(cells).spacing[:, column]
        numerical[:, :, column] = (ends[0] - ends[1]) / (2.0 * small * spacing)[:, None]
    tangent = centre.tangent[:, [0, 1, 1, 2]].reshape(-1, 2, 2)
    error = np.abs(tangent - numerical).max(axis=(1, 2)) / np.abs(tangent).max(axis=(1, 2))
    # a cell may sit within the difference of a yarn's change from tension to compression
    assert np.quantile(error, 0.98) < 1e-5


def test_swapping_warp_and_weft_swaps_the_answer():
    rng = np.random.default_rng(5)
    cells = [random_cell(rng) for _ in range(200)]
    stretch = rng.uniform(0.5, 1.3, (200, 2))
    response = half_cell(cells, stretch)
    mirrored = half_cell([swapped(cell) for cell in cells], stretch[:, ::-1])
    assert relative_difference(mirrored.force[:, ::-1], response.force).max() < 1e-8
    assert relative_difference(mirrored.energy[:, [1, 0, 2, 3]], response.energy).max() < 1e-8
    assert np.allclose(
        mirrored.tangent[:, ::-1], response.tangent, rtol=1e-6, atol=1e-6 * np.abs(response.tangent).max()
    )


def sawtooth_cell(**given) -> PlainWeave:
    """Pin-jointed yarns: no bending stiffness at all."""
    rng = np.random.default_rng(2)
    return random_cell(rng, **({"warp_second_moment": 0.0, "weft_second_moment": 0.0, "contact": "bilateral"} | given))


def test_sawtooth_with_equal_yarns_and_equal_stretch():
    """By symmetry the crossover of a hard contact stays, and each yarn is a rod along its chord."""
    cell = sawtooth_cell(
        warp_modulus=1e9, weft_modulus=1e9, warp_cross_section=1e-6, weft_cross_section=1e-6,
        warp_half_spacing=2e-3, weft_half_spacing=2e-3, crossover_height=1e-3, warp_crimp_share=0.5,
        contact_stiffness_value=1e12,
    )  # fmt: skip
    stretch = np.array([1.001, 1.01, 1.05, 1.2])
    response = half_cell(cell, np.column_stack([stretch, stretch]))
    l0, length = np.hypot(2e-3, 0.5e-3), np.hypot(stretch * 2e-3, 0.5e-3)
    tension = 1e9 * 1e-6 * (length / l0 - 1.0)
    force = tension * stretch * 2e-3 / length
    assert np.allclose(response.force, force[:, None], rtol=1e-6)
    assert np.allclose(response.crossover_force, 2.0 * tension * 0.5e-3 / length, rtol=1e-6)


def test_sawtooth_with_unequal_yarns():
    """One unknown is left: with N = T_k sin(theta_k), h_k + w_k follows, and -(w_1 + w_2) k_c = N."""
    rng = np.random.default_rng(9)
    for _ in range(20):
        cell = sawtooth_cell(
            warp_half_spacing=10 ** rng.uniform(-3, -2.5), weft_half_spacing=10 ** rng.uniform(-3, -2.5),
            warp_crimp_share=rng.uniform(0.3, 0.7), crossover_height=3e-4, warp_modulus=10 ** rng.uniform(9, 10),
        )  # fmt: skip
        stretch = rng.uniform(1.01, 1.05, 2)

        def height(k, press, cell=cell, stretch=stretch):
            """Crimp height at which yarn k presses with ``press``."""

            def missing(high):
                length = np.hypot(cell.half_spacing[k] * stretch[k], high)
                tension = cell.axial_stiffness[k] * (length / cell.chord_length[k] - 1.0)
                return tension * high / length - press

            return scipy.optimize.brentq(missing, 0.0, 1.0, xtol=1e-18, rtol=1e-14)

        def closing(press, cell=cell, height=height):
            shift = sum(height(k, press) - cell.crimp_height[k] for k in range(2))
            return press + cell.contact_stiffness * shift

        press = scipy.optimize.brentq(closing, 0.0, cell.contact_stiffness * cell.crossover_height, rtol=1e-14)
        expected = []
        for k in range(2):
            h, x = height(k, press), cell.half_spacing[k] * stretch[k]
            expected.append(press * x / h)
        response = half_cell(cell, stretch)
        assert np.allclose(response.force[0], expected, rtol=1e-6)
        assert response.crossover_force[0] == pytest.approx(2.0 * press, rel=1e-6)


def test_vanishing_bending_stiffness_approaches_the_sawtooth():
    stretch = np.array([[1.02, 1.03], [1.1, 1.01]])
    limit = half_cell(sawtooth_cell(), stretch).force
    errors = []
    for share in (1e-4, 1e-5, 1e-6):
        second_moment = share * sawtooth_cell().warp_cross_section ** 2 / 12.0
        cell = sawtooth_cell(warp_second_moment=second_moment, weft_second_moment=second_moment)
        errors.append(relative_difference(half_cell(cell, stretch).force, limit).max())
    assert errors[0] > 5.0 * errors[1] > 25.0 * errors[2] > 0.0
    assert errors[2] < 1e-4


def test_yarns_without_crimp_are_two_straight_bars():
    cell = sawtooth_cell(warp_second_moment=1e-16, crossover_height=0.0, contact_stiffness_value=1e5)
    stretch = np.array([[1.05, 0.9], [1.2, 1.3], [0.5, 1.1], [0.6, 0.7]])
    response = half_cell(cell, stretch)
    stiffness = np.where(stretch > 1.0, cell.axial_stiffness, cell.compressive_stiffness)
    assert np.allclose(response.force, stiffness * (stretch - 1.0), rtol=1e-9, atol=1e-12)
    assert np.abs(response.height_change).max() < 1e-15
    assert np.abs(response.tangent[:, 1]).max() == 0.0
    assert np.allclose(response.tangent[:, [0, 2]], stiffness / np.array(cell.half_spacing), rtol=1e-9)


def test_linear_membrane_of_straight_yarns():
    cell = PlainWeave.straight(stiffness_per_width=2.0e4, spacing=0.004)
    stretch = np.array([[1.02, 0.97], [0.8, 1.1]])
    assert np.allclose(half_cell(cell, stretch).force_per_width, 2.0e4 * (stretch - 1.0), rtol=1e-9)


def test_slack_weft_leaves_a_yarn_that_only_bends():
    """A weft without axial stiffness resists the warp's straightening by bending alone."""
    common = {"contact_stiffness_value": 1e13, "warp_second_moment": 0.0, "weft_compressive_stiffness": 0.0}
    cell = sawtooth_cell(**common, weft_second_moment=1e-16, crossover_height=4e-4, warp_half_spacing=2e-3,
                         weft_half_spacing=2e-3, weft_modulus=1e9, weft_cross_section=1e-16)  # fmt: skip
    response = half_cell(cell, [1.01, 1.0])
    w = response.height_change[0, 1]
    assert w > 0.0
    h = cell.crimp_height[1] + w
    length = np.hypot(cell.half_spacing[1], h)
    rotation = np.arctan2(h, cell.half_spacing[1]) - np.arctan2(cell.crimp_height[1], cell.half_spacing[1])
    press = 3.0 * cell.bending_stiffness[1] / cell.chord_length[1] * rotation * cell.half_spacing[1] / length**2
    assert response.crossover_force[0] == pytest.approx(2.0 * press, rel=1e-5)


def test_unilateral_contact_lets_yarns_separate():
    """Axial stiffness above the Euler-like one makes a yarn bow away from the crossover when it is pushed."""
    rng = np.random.default_rng(4)
    both = {"crossover_height": 3e-4, "warp_half_spacing": 2e-3, "weft_half_spacing": 2.5e-3}
    cell = random_cell(rng, contact="unilateral", **both)
    euler = cell.euler_stiffness
    compressive = {"warp_compressive_stiffness": 2.0 * euler[0], "weft_compressive_stiffness": 2.0 * euler[1]}
    unilateral = PlainWeave(**(cell.model_dump() | compressive))
    bilateral = PlainWeave(**(unilateral.model_dump() | {"contact": "bilateral"}))
    pulled = [[1.05, 1.03]]
    assert np.allclose(half_cell(unilateral, pulled).force, half_cell(bilateral, pulled).force, rtol=1e-12)
    pushed = [[0.9, 0.85]]
    apart, tied = half_cell(unilateral, pushed), half_cell(bilateral, pushed)
    assert apart.crossover_force[0] == 0.0
    assert apart.energy[0, 3] == 0.0
    assert apart.height_change[0].sum() > 0.0
    assert tied.crossover_force[0] < 0.0
    # separated yarns do not know of each other
    alone = half_cell(unilateral, [[0.9, 0.8]])
    assert alone.force[0, 0] == pytest.approx(apart.force[0, 0], rel=1e-9)
    assert apart.tangent[0, 1] == 0.0
    assert abs(tied.tangent[0, 1]) > 0.0


@pytest.mark.parametrize("contact", ["bilateral", "unilateral"])
def test_single_precision_converges_for_the_preset(contact):
    cell = PlainWeave(**(glass_polypropylene().unit_cell.model_dump() | {"contact": contact}))
    warp, weft = np.meshgrid(np.linspace(0.5, 1.3, 33), np.linspace(0.5, 1.3, 33))
    stretch = np.column_stack([warp.ravel(), weft.ravel()])
    single, double = half_cell(cell, stretch, precision="float32"), half_cell(cell, stretch)
    for name in ("force", "energy", "tangent", "height_change"):
        assert np.all(np.isfinite(getattr(single, name))), name
    assert single.residual.max() < 1e-4
    scale = 1e-4 * np.array(cell.axial_stiffness)
    assert (np.abs(single.force - double.force) / (np.abs(double.force) + scale)).max() < 1e-2


def test_stiff_compression_is_warned_of():
    cell = glass_polypropylene().unit_cell
    assert cell.warnings() == []
    stiff = PlainWeave(**(cell.model_dump() | {"weft_compressive_stiffness": 2.0 * cell.euler_stiffness[1]}))
    assert len(stiff.warnings()) == 1
    assert "weft" in stiff.warnings()[0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"stretch": [[1.0, np.nan]]}, "finite"),
        ({"stretch": [[1.0, -0.1]]}, "positive"),
        ({"stretch": [[1.0, 1.0, 1.0]]}, r"\(n, 2\)"),
        ({"stretch": [[1.0, 1.0]], "increment_count": 0}, "at least 1"),
        ({"stretch": [[1.0, 1.0]], "precision": "float16"}, "float32 or float64"),
    ],
)
def test_bad_stretches_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        respond(glass_polypropylene().unit_cell, **arguments)


def test_number_of_cells_must_fit():
    with pytest.raises(InputError, match="2 cells for 3 pairs"):
        respond([glass_polypropylene().unit_cell] * 2, np.ones((3, 2)))
