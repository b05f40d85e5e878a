"""The friction sled as a user runs it: the force of the pull against coefficient times weight."""

import pytest

from weavesim.errors import InputError
from weavesim.fabric.presets import glass_polypropylene
from weavesim.scenes.laboratory import sled
from weavesim.scenes.laboratory.sled import SledParameters


def test_the_sled_needs_its_coefficient_times_its_weight(tmp_path):
    (tmp_path / "pull.csv").write_text("displacement [mm],force [N]\n" + "".join(f"{x},0.54\n" for x in range(5, 16)))
    parameters = SledParameters(
        out=tmp_path / "out", mesh_size=0.03, frame_count=40, threads=1, measured=tmp_path / "pull.csv",
        write="summary,pictures",
    )  # fmt: skip
    summary = sled.SCENE.run(parameters)
    assert summary["energy_balance_error"] < 0.01
    weight = 9.81 * (0.2 + 0.743 * 0.0635**2)
    assert sled.normal_force(parameters, glass_polypropylene()) == pytest.approx(weight)
    assert summary["normal_force_n"] == pytest.approx(weight, rel=2e-3)
    assert summary["kinetic_friction_coefficient"] == pytest.approx(0.3, rel=2e-3)
    assert summary["force_ratio"] == pytest.approx(1.0, abs=2e-3)
    assert summary["largest_force_n"] < 1.05 * 0.3 * weight
    (share,) = summary["measured_rms_difference_ratio"].values()
    assert share == pytest.approx((0.3 * weight - 0.54) / 0.54, abs=0.005)
    assert {"force.png", "coefficient.png"} <= {path.name for path in (tmp_path / "out" / "pictures").iterdir()}


def test_shares_of_the_nodes_are_those_of_their_area():
    blank = sled.sled(SledParameters(mesh_size=0.02)).sheet.blank
    share = sled.node_shares(blank)
    assert share.sum() == pytest.approx(1.0)
    corners = [0.25 / blank.element_count, 1.0 / blank.element_count]
    assert sorted({round(value, 12) for value in share})[::2] == pytest.approx(corners)


def test_a_sled_without_friction_is_refused():
    with pytest.raises(InputError, match="friction = 0: .* give a coefficient above 0"):
        SledParameters(friction=0.0)
