"""Pure bending as a user runs it: moment and curvature against the law, rigidity and hysteresis as KES gives them."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.fabric.bending import BendingCurve, IsotropicBending, YarnBending
from weavesim.fabric.presets import glass_polypropylene
from weavesim.run.simulation import Simulation
from weavesim.scenes.laboratory import pure_bending
from weavesim.scenes.laboratory.pure_bending import PureBendingParameters


def bent(fabric, **given):
    parameters = PureBendingParameters(mesh_size=0.0005, width=0.001, threads=1, **given)
    setup = pure_bending.pure_bending(parameters, fabric)
    # kernels that others have too
    setup = setup.model_copy(update={"solver": setup.solver.model_copy(update={"lane_count": 1})})
    curves = pure_bending.record(parameters, fabric, setup)
    Simulation(setup).run([curves])
    return pure_bending.findings(curves), curves.columns


def test_a_linear_strip_has_its_stiffness_and_no_loop(tmp_path):
    rigidity = 20.0e6 * 1.2e-3**3 / 12.0
    (tmp_path / "kes.csv").write_text("curvature [1/cm],moment [N]\n0,0\n1,0.288\n2,0.576\n")
    summary = pure_bending.SCENE.run(
        PureBendingParameters(
            out=tmp_path / "out", width=0.001, threads=1, measured=tmp_path / "kes.csv", write="summary,pictures"
        )
    )
    assert summary["bending_rigidity_n_m"] == pytest.approx(rigidity, rel=5e-3)
    assert summary["largest_curvature_per_m"] == pytest.approx(250.0, rel=0.01)
    assert summary["largest_moment_error_ratio"] < 0.01
    assert abs(summary["bending_hysteresis_n"]) < 0.005 * summary["largest_moment_n"]
    assert summary["verdict"] == "trusted"
    assert summary["energy_balance_error"] < 0.01
    (share,) = summary["measured_largest_difference_ratio"].values()
    assert share < 0.01
    assert (tmp_path / "out" / "pictures" / "moment.png").exists()


def test_kawabata_numbers_come_back():
    """B and 2HB of the law along the warp; 1 cm bent to 2.5 1/cm both ways."""
    law = BendingCurve.from_kawabata(1.0e-3, 0.05)
    fabric = glass_polypropylene().model_copy(update={"bending": YarnBending(warp=law, weft=5.0e-4, twist=5.0e-4)})
    found, c = bent(fabric)
    assert found["bending_rigidity_n_m"] == pytest.approx(1.0e-3, rel=0.01)
    assert found["bending_hysteresis_n"] == pytest.approx(0.05, rel=0.03)
    assert found["largest_moment_error_ratio"] < 0.01
    assert c["moment_n"].max() == pytest.approx(1.0e-3 * 250.0 + 0.025, rel=1e-3)
    assert c["moment_n"].min() == pytest.approx(-0.275, rel=1e-3)


def test_a_plate_that_stays_straight_across_has_the_stiffness_of_a_plate():
    fabric = glass_polypropylene().model_copy(update={"bending": IsotropicBending(modulus=20.0e6, poisson_ratio=0.3)})
    found, _ = bent(fabric, largest_curvature=150.0)
    assert found["bending_rigidity_n_m"] == pytest.approx(20.0e6 * 1.2e-3**3 / (12.0 * 0.91), rel=5e-3)


def test_a_path_with_friction_follows_the_slider():
    law = BendingCurve.from_kawabata(1.0e-3, 0.05, slip_curvature=10.0)
    moment = pure_bending.law_path(law, np.array([0.0, 5.0, 20.0, 10.0, -20.0]))
    np.testing.assert_allclose(moment, [0.0, 0.0175, 0.045, 0.01, -0.045], atol=1e-9)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: PureBendingParameters(largest_curvature=600.0), "its ends would meet: at most 502.7 1/m"),
        (lambda: PureBendingParameters(mesh_size=0.002), "at least 4 elements along half the length"),
        (lambda: PureBendingParameters(yarn="bias"), "yarn"),
    ],
)
def test_nonsense_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
