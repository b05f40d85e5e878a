"""The code of the tutorial on unit cells, block by block, verbatim."""

import re
import runpy

import pytest

from tests.support.paths import ROOT

PAGE = ROOT / "docs" / "tutorial_unit_cell.md"


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """Names that are left after all blocks, and the folder in which they ran."""
    folder = tmp_path_factory.mktemp("tutorial")
    # a file: Warp reads the source of its functions
    script = folder / "tutorial.py"
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert len(blocks) == 4
    script.write_text("\n\n".join(blocks), encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        names = runpy.run_path(str(script))
    return names, folder


@pytest.mark.slow
def test_the_net_forms_over_the_double_dome(played):
    names, _ = played
    summary, simulation = names["summary"], names["simulation"]
    assert summary["outcome"] == "finished"
    assert simulation.frame.stroke == pytest.approx(0.02, rel=1e-3)
    assert summary["unit_cell_failures"] == 0
    assert summary["unit_cell_max_residual"] < 1e-5
    assert summary["energy_balance_error"] < 0.05
    assert summary["max_shear_angle_deg"] > 2.0
    assert summary["energies_j"]["unit_cell"] > 0.0
    # the cell's shear and stretch, not the sheet's own law, hold the net
    assert summary["energies_j"]["unit_cell"] > summary["energies_j"]["shear"]


def test_results_are_written_as_for_any_fabric(played):
    _, folder = played
    out = folder / "out" / "bonded_net"
    for name in ("double_dome.usdc", "report.html", "summary.json", "history.csv", "paraview"):
        assert (out / name).exists(), name
    assert "unit_cell_energy_j" in (out / "history.csv").read_text().splitlines()[0]


def test_the_cell_is_about_thirty_lines():
    block = re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL).group(1)
    assert len([line for line in block.splitlines() if line.strip()]) <= 35
