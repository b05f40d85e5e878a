"""The bias extension as a user runs it, on a coarse mesh: files, summary, and numbers that are known."""

import numpy as np
import pytest

from tests.support.tables import columns
from weavesim.errors import InputError
from weavesim.scenes import bias_extension
from weavesim.scenes.bias_extension import BiasExtensionParameters


@pytest.fixture(scope="module")
def bias_test(tmp_path_factory):
    out = tmp_path_factory.mktemp("bias_extension")
    parameters = BiasExtensionParameters(out=out, mesh_size=0.0125, speed=0.5, frame_count=30, threads=1)
    return out, bias_extension.SCENE.run(parameters)


@pytest.mark.slow
def test_bias_extension_has_its_three_zones(bias_test):
    out, summary = bias_test
    assert summary["kinematic_angle_deg"] == pytest.approx(40.0, abs=1e-3)
    # eight elements across: the zones' edges take one of them, the study of the verification manual refines
    assert 33.0 < summary["zone_c_angle_deg"] < 40.5
    assert summary["zone_b_angle_deg"] == pytest.approx(0.5 * summary["zone_c_angle_deg"], rel=0.05)
    assert abs(summary["zone_a_angle_deg"]) < 1.0
    assert 0.7 < summary["force_ratio"] < 1.1
    assert summary["energy_balance_error"] < 0.01
    table = columns(out / "bias_extension.csv")
    early = np.argmin(np.abs(table["kinematic_angle_deg"] - 10.0))
    assert table["zone_c_angle_deg"][early] == pytest.approx(table["kinematic_angle_deg"][early], rel=0.05)
    assert {path.name for path in (out / "pictures").iterdir()} >= {"force.png", "zones.png"}


def test_zones_of_the_bias_extension_fill_the_strip():
    parameters = BiasExtensionParameters(length=0.25, width=0.1)
    x, y = np.meshgrid(np.linspace(-0.125, 0.125, 1001), np.linspace(-0.05, 0.05, 401), indexing="ij")
    zone = bias_extension.zones(parameters, np.stack([x, y], axis=-1))
    areas = [np.mean(zone == k) * 0.25 * 0.1 for k in range(3)]
    np.testing.assert_allclose(areas, bias_extension.zone_areas(parameters), rtol=0.02)
    assert sum(bias_extension.zone_areas(parameters)) == pytest.approx(0.025)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: BiasExtensionParameters(length=0.15, width=0.1), "at least twice the width"),
        (lambda: BiasExtensionParameters(mesh_size=0.02), "at least 8 elements across .* at most 0.0125 m"),
    ],
)
def test_nonsense_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
