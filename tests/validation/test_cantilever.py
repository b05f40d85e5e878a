"""The cantilever as a user runs it, on a coarse mesh: files, summary, and numbers that are known."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from tests.support.tables import columns
from weavesim.errors import InputError
from weavesim.fabric.bending import BendingCurve, YarnBending
from weavesim.fabric.closed_forms import elastica_profile, elastica_stiffness, heavy_elastica
from weavesim.fabric.presets import glass_polypropylene
from weavesim.scenes import cantilever
from weavesim.scenes.cantilever import CantileverParameters


@pytest.mark.slow
@pytest.mark.parametrize("yarn", ["warp", "weft"])
def test_cantilever_gives_the_bending_stiffness_back(tmp_path, yarn):
    summary = cantilever.SCENE.run(CantileverParameters(out=tmp_path, mesh_size=0.01, width=0.02, yarn=yarn, threads=1))
    assert summary["energy_balance_error"] < 0.01
    assert summary["elastica_over_input"] == pytest.approx(1.0, abs=0.01)
    # the formula itself is about 5 % off the elastica at this angle
    assert summary["peirce_over_input"] == pytest.approx(1.057, abs=0.012)
    assert summary["chord_angle_deg"] == pytest.approx(41.5, abs=0.2)
    # at rest the clamp carries the weight, in the double precision that is this scene's default
    weight = 0.743 * 9.81 * 1e-3 * summary["overhang_mm"] * 0.02
    assert summary["support_force_n"]["clamp"][2] == pytest.approx(weight, rel=1e-3)
    assert summary["outcome"] == "finished" and (tmp_path / "pictures" / "chord_angle.png").exists()
    shape = columns(tmp_path / "profile.csv")
    drop, known = shape["drop_mm"], shape["elastica_drop_mm"]
    assert np.nanmax(np.abs(drop - known)) < 0.01 * drop.max() and np.isfinite(known).sum() > 10


def test_cantilever_compares_no_stiffness_where_the_moment_is_a_curve_or_has_friction():
    """Along the weft, whose stiffness is one number, it still does."""
    rubbing = BendingCurve.from_kawabata(1.0e-3, 2.0e-2)
    softening = BendingCurve(curvature=(0.0, 5.0, 20.0), moment_values=(0.0, 5.0e-3, 1.0e-2))
    for along, across, yarn, comparable in (
        (rubbing, 1.0e-3, "warp", False), (softening, 1.0e-3, "warp", False), (softening, 1.0e-3, "weft", True),
        (BendingCurve.straight(1.0e-3), softening, "warp", True), (1.0e-3, rubbing, "weft", False),
    ):  # fmt: skip
        fabric = glass_polypropylene().model_copy(
            update={"bending": YarnBending(warp=along, weft=across, twist=1.0e-3)}
        )
        parameters = CantileverParameters(mesh_size=0.012, width=0.02, yarn=yarn, threads=1, length=0.06)
        setup = cantilever.cantilever(parameters, fabric)
        x = setup.sheet.blank.node_position
        hanging = SimpleNamespace(setup=setup, frame=SimpleNamespace(position=x - np.outer(x[:, 0], [0, 0, 0.5])))
        found = cantilever.findings(parameters, fabric, hanging)
        for name in ("peirce_over_input", "elastica_over_input"):
            assert (found[name] is not None) == comparable
        assert found["elastica_bending_stiffness_n_m"] > 0.0


def test_a_measured_profile_is_compared_with_the_strip(tmp_path):
    """Of a strip whose stiffness is the input's: the elastica's own points, in centimetres."""
    weight = 0.743 * 9.81
    x, drop = elastica_profile(0.12, 20.0e6 * 1.2e-3**3 / 12.0, weight, np.linspace(0.0, 0.12, 9))
    rows = "".join(f"{100 * a:.5f},{100 * b:.5f}\n" for a, b in zip(x, drop, strict=True))
    (tmp_path / "strip.csv").write_text("x [cm],drop [cm]\n" + rows)
    parameters = CantileverParameters(
        out=tmp_path / "out", mesh_size=0.012, width=0.024, length=0.12, threads=1, measured=tmp_path / "strip.csv",
        write="summary",
    )  # fmt: skip
    summary = cantilever.SCENE.run(parameters)
    (share,) = summary["measured_largest_difference_ratio"].values()
    assert share < 0.01


@pytest.mark.parametrize("load", [1.0, 8.0, 50.0])
def test_heavy_elastica_against_a_boundary_value_problem(load):
    """theta'' = -load (1 - s) cos(theta), clamped at s = 0, no moment at s = 1."""
    s = np.linspace(0.0, 1.0, 401)
    guess = np.zeros((4, len(s)))
    for part in np.linspace(0.1, 1.0, 10) * load:
        solution = solve_bvp(
            lambda s, y, part=part: np.array([y[1], -part * (1.0 - s) * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]),
            lambda a, b: np.array([a[0], b[1], a[2], a[3]]), s, guess, tol=1e-9, max_nodes=50_000,
        )  # fmt: skip
        assert solution.success
        s, guess = solution.x, solution.y
    angle = float(np.arctan2(solution.y[3, -1], solution.y[2, -1]))
    assert elastica_stiffness(angle, 1.0, 1.0) == pytest.approx(1.0 / load, rel=1e-5)
    found_load, found_angle = heavy_elastica(float(solution.y[0, -1]))
    assert found_load == pytest.approx(load, rel=1e-5)
    assert found_angle == pytest.approx(angle, rel=1e-6)


def test_an_unknown_yarn_is_refused():
    with pytest.raises(InputError, match="yarn"):
        CantileverParameters(yarn="bias")
