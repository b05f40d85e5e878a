"""A cloth on a ball, coarse: both cases come to rest and wrinkle, differently, as in Figure 5 of the paper."""

import json

import numpy as np
import pytest

from weavesim.measures.defects.judgement import Limits
from weavesim.output.stored.file import read_results
from weavesim.output.stored.judged import judge_run
from weavesim.scenes.hemisphere import CASES, SCENE, UNEVENNESS, HemisphereParameters, unevenness
from weavesim.sheet.blank import Blank

# Forming runs of seconds each.
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("hemisphere")


@pytest.fixture(scope="module")
def summaries(folder):
    return SCENE.run(HemisphereParameters(out=folder, mesh_size=0.01, frame_count=40))


@pytest.mark.parametrize("case", CASES)
def test_it_comes_to_rest_on_the_ball(summaries, case):
    summary = summaries[case]
    assert summary["kinetic_energy_ratio"] < 0.02
    assert summary["energy_balance_error"] < 0.01
    # A fold that creases along one row of elements shows in the hourglass energy first.
    assert summary["hourglass_energy_ratio"] < 0.1
    assert summary["unit_cell_failures"] == 0
    assert summary["penetration_at_nodes_mm"] < 0.1
    assert 0.97 < summary["min_stretch"] <= summary["max_stretch"] < 1.02


def test_both_wrinkle_and_differently(summaries):
    low, high = (summaries[case] for case in CASES)
    assert low["fold_count"] >= 4
    assert high["fold_count"] >= 4
    assert low["fold_count"] > high["fold_count"]
    assert min(low["wrinkle_amplitude_mm"], high["wrinkle_amplitude_mm"]) > 5.0


@pytest.mark.parametrize("case", CASES)
def test_the_verdict_finds_every_fold(summaries, folder, case):
    """Each outward maximum of the rim is in a wrinkle, or within two elements of one."""
    judged = judge_run(read_results(folder / case), Limits())
    (sheet,) = judged.sheets
    wrinkled = np.concatenate([region.elements for region in sheet.regions if region.kind == "wrinkle"])
    blank, position = sheet.sheet.blank, sheet.sheet.position
    loop = blank.boundary_loop()
    radius = np.hypot(*position[loop, :2].T)
    window = np.stack([np.roll(radius, k) for k in range(-3, 4)])
    crests = loop[radius == window.max(axis=0)]
    assert len(crests) >= summaries[case]["fold_count"] >= 4
    near = np.linalg.norm(
        blank.material_coordinates[crests][:, None] - blank.element_centres()[wrinkled, :2][None], axis=2
    ).min(axis=1)
    assert near.max() < 0.02
    assert not judged.passed


def test_the_softer_in_shear_shears_at_least_twice_as_much(summaries):
    low, high = (summaries[case]["max_shear_angle_deg"] for case in CASES)
    assert high > 2.0 * low


def test_close_parts_are_counted_and_written(summaries, folder):
    for case in CASES:
        written = json.loads((folder / case / "summary.json").read_text())
        assert written["close_pair_count"] == summaries[case]["close_pair_count"] >= 0
        assert (folder / case / "hemisphere.usdc").exists()


def test_every_mesh_sees_the_same_unevenness():
    coarse, fine = (Blank.rectangle((-0.2, -0.2), (0.2, 0.2), size) for size in (0.02, 0.01))
    shared = [
        int(np.argmin(np.linalg.norm(fine.material_coordinates - point, axis=1)))
        for point in coarse.material_coordinates
    ]
    velocity = unevenness(coarse, seed=3)
    assert velocity == pytest.approx(unevenness(fine, seed=3)[shared], abs=1e-12)
    assert 0.1 * UNEVENNESS < np.abs(velocity).max() < 6.0 * UNEVENNESS
    assert not np.allclose(velocity, unevenness(coarse, seed=4), atol=0.1 * UNEVENNESS)
