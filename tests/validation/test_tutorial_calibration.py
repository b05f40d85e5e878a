"""The tutorial on calibration, from the tables on the page to a formed part: files, code, command and numbers."""

import re
import runpy
import shlex

import pytest
from typer.testing import CliRunner

from tests.support.paths import ROOT
from weavesim.app import calibrate_command
from weavesim.app.command_line import application
from weavesim.fabric.file import load_fabric

PAGE = (ROOT / "docs" / "tutorial_calibration.md").read_text(encoding="utf-8")
FILES = ("known.toml", "frame.csv", "biaxial_equal.csv", "biaxial_warp.csv", "biaxial_shear.csv", "cantilever.csv")


def blocks(kind):
    return re.findall(rf"```{kind}\n(.*?)```", PAGE, flags=re.DOTALL)


def file_of_page(name):
    """The first block after the name of a file."""
    return re.search(rf"`{name}`:\n\n```\w+\n(.*?)```", PAGE, flags=re.DOTALL)[1]


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """Names that are left after all Python of the page, and the folder in which it ran."""
    folder = tmp_path_factory.mktemp("tutorial")
    for name in FILES:
        (folder / name).write_text(file_of_page(name), encoding="utf-8")
    script = folder / "tutorial.py"
    script.write_text("\n\n".join(blocks("python")), encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        names = runpy.run_path(str(script))
    return names, folder


def test_the_page_shows_the_values_that_it_gives(played):
    names, _ = played
    shown = next(block for block in blocks("text") if block.startswith("unit cell:"))
    found = re.findall(
        r"^  ([\w.]+) +([\d.e+-]+) [\w ^/]*?(?:  (\S+) to (\S+))?(?:  \((\w[\w ]*)\))?$", shown, flags=re.MULTILINE
    )
    estimates = {e.name: e for part in names["calibration"].estimates.values() for e in part}
    assert {name for name, *_ in found} == set(estimates)
    for name, value, low, high, state in found:
        e = estimates[name]
        assert float(value) == pytest.approx(e.value, rel=2e-3), name
        if low:
            # intervals of the fit end where its steps do
            assert (float(low), float(high)) == pytest.approx((e.low, e.high), rel=2e-2), name
        else:
            assert state == e.state, name


def test_known_values_are_within_their_intervals(played):
    """The made-up tests have an E A of 27 kN, an L_3 of 0.66 mm, a friction of 7 N/m and a D of 0.7 mN m."""
    calibration = played[0]["calibration"]
    for name, value in (
        ("yarn_stiffness", 27e3), ("crossover_height", 0.66e-3), ("friction_limit_at_22.5_deg", 7.0),
        ("bending_stiffness", 7.0e-4),
    ):  # fmt: skip
        e = calibration.estimate(name)
        assert e.low < value < e.high, name
    assert calibration.estimate("yarn_bending").state == "held"
    assert not any("bad fit" in warning for warning in calibration.warnings)


def test_the_part_is_formed_of_the_calibrated_fabric(played):
    names, folder = played
    summary = names["summary"]
    assert summary["outcome"] == "finished" and summary["max_shear_angle_deg"] > 20.0
    assert load_fabric(folder / "calibrated" / "fabric.toml") == names["calibration"].fabric
    assert summary["energies_j"]["shear_friction_loss"] > 0.0
    assert (folder / "formed" / "summary.json").exists()


def test_the_command_has_the_options_of_the_code(played, monkeypatch):
    names, _ = played
    (command,) = (text.strip() for text in blocks("bash"))
    given = []
    monkeypatch.setattr(calibrate_command, "calibrate_into_folder", lambda parameters: given.append(parameters) or [])
    result = CliRunner().invoke(application, shlex.split(command.removeprefix("weavesim ")))
    assert result.exit_code == 0, result.output
    (parameters,) = given
    options = names["calibration"].options
    for name in type(options).model_fields:
        assert getattr(parameters, name) == getattr(options, name), name
    assert parameters.out.name == "calibrated"


def test_every_option_of_the_page_exists():
    from weavesim.app.calibrate_command import CalibrateParameters

    named = {name.replace("-", "_") for name in re.findall(r"--([a-z][a-z-]+)", PAGE)} - {"help", "fabric"}
    assert named <= set(CalibrateParameters.model_fields)
