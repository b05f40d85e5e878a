"""Laws from the values of a file: kinds and arguments by name, and never a message of Python's own."""

import random
from typing import Any

import pytest

from tests.support.paths import ROOT
from weavesim.checks import Parameters
from weavesim.errors import InputError
from weavesim.fabric.bending import BendingCurve
from weavesim.fabric.construction import chosen, constructed
from weavesim.fabric.file import load_fabric
from weavesim.fabric.shear import MomentCurve

CURVES = {"MomentCurve": MomentCurve, "BendingCurve": BendingCurve}


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("MomentCurv", "kind = 'MomentCurv': one of MomentCurve, BendingCurve is needed; did you mean 'MomentCurve'"),
        ("MomentCurve.from_frame", "has the constructors .*did you mean 'from_picture_frame'"),
        ("MomentCurve.model_validate", "has the constructors"),
        ("MomentCurve.__init__", "has the constructors"),
        ([1], r"kind = \[1\]: one of"),
        (True, "kind = True: one of"),
        ("", "kind = '': one of"),
        ("a\nb", r"kind = 'a\\nb'"),
    ],
)
def test_unknown_kinds_are_refused(kind, message):
    with pytest.raises(InputError, match=message):
        chosen(kind, CURVES)


@pytest.mark.parametrize(
    ("kind", "values", "message"),
    [
        ("MomentCurve.from_picture_frame", {"frameside": 1}, "frameside = 1: unknown name; did you mean 'frame_side'"),
        ("MomentCurve.from_picture_frame", {"self": 1}, "self = 1: unknown name"),
        ("MomentCurve.from_picture_frame", {"cls": 1}, "cls = 1: unknown name"),
        ("MomentCurve.from_picture_frame", {"frame_side": "a"}, "frame_side = 'a': a number is needed"),
        ("MomentCurve.from_picture_frame", {"fabric_side": (1,)}, "fabric_side: a number is needed"),
        ("MomentCurve.from_picture_frame", {"angle": 1.0}, "angle = 1.0: a list of finite numbers is needed"),
        ("MomentCurve.from_picture_frame", {"angle": (True,)}, "angle: a list of finite numbers is needed"),
        ("MomentCurve.from_picture_frame", {"angle": ((0,),)}, "angle: a list of finite numbers is needed"),
        (
            "MomentCurve.from_picture_frame",
            {},
            "angle: is required; machine_force: is required; frame_side: is required",
        ),
        ("MomentCurve.from_polynomial", {"coefficients": (1,), "trusted_angle": "x"}, "trusted_angle = 'x': a number"),
        ("MomentCurve.from_polynomial", {"coefficients": (1,), "locking_angel": 1}, "did you mean 'locking_angle'"),
        ("MomentCurve.from_polynomial", {"coefficients": (1e308, 1e308)}, "."),
        ("BendingCurve.from_kawabata", {"rigidity": "1", "hysteresis": 1}, "rigidity = '1': a number is needed"),
        ("BendingCurve.from_kawabata", {"rigidity": None, "hysteresis": 1}, "rigidity: a number is needed"),
        ("BendingCurve.straight", {"stiffness": -1.0}, "must not be negative"),
        ("BendingCurve", {"self": 1}, "."),
    ],
)
@pytest.mark.filterwarnings("ignore:overflow")
def test_bad_arguments_are_refused_by_name(kind, values, message):
    cls, make = chosen(kind, CURVES)
    with pytest.raises(InputError, match=message) as raised:
        constructed(cls, make, values)
    assert not any(words in str(raised.value) for words in PYTHON)


def test_a_law_of_ones_own_may_have_types_that_only_a_checker_knows():
    class Own(Parameters):
        value: float

        @classmethod
        def from_test(cls, test: "OnlyForCheckers"):  # noqa: F821
            return cls(value=test)

        @classmethod
        def from_any(cls, test: Any, other: Parameters | None = None):
            return cls(value=test)

    assert constructed(Own, Own.from_test, {"test": 2.0}).value == 2.0
    assert constructed(Own, Own.from_any, {"test": 2.0, "other": None}).value == 2.0
    with pytest.raises(InputError, match="value = 'x': a number is needed"):
        constructed(Own, Own.from_test, {"test": "x"})


# Words of Python's own messages.
PYTHON = (
    "not supported", "positional", "keyword argument", "NoneType", "unhashable", "object is not", "has no attribute",
    "Input should", "unsupported operand", "Traceback", "instances of", "division by zero",
)  # fmt: skip
VALUES = (
    "[1]", "[[1]]", "[]", "[true]", "[1, 'a']", "[0, 1e308]", "[0.0, 0.0]", "{a = 1}", "{}", "{kind = 'MomentCurve'}",
    "{kind = 'MomentCurve.from_polynomial'}", "{csv = '/dev/zero', column = 'a'}", "{csv = 1, column = 2}",
    "{column = 'force_n'}", "{csv = 'frame.csv', column = 'force_n'}", "true", "'x'", "''", "'a\\nb'", "1979-05-27",
    "10:00:00",
    "-1", "0", "1.5", "5", "1e300", "1e-300", "9007199254740991", "1" * 5000, "nan", "-inf",
    "'MomentCurve.from_polynomial'", "'PlainWeave.straight'",
)  # fmt: skip


@pytest.mark.parametrize("seed", range(6))
def test_mutated_fabric_files_give_a_fabric_or_a_message(tmp_path, seed):
    """Values of every wrong kind at every key of the documented file, keys left out, misspelt, doubled."""
    chance = random.Random(seed)
    page = (ROOT / "docs" / "fabrics.md").read_text(encoding="utf-8")
    lines = page.split("```toml\n")[1].split("```")[0].split("\n")
    (tmp_path / "frame.csv").write_text("angle_deg,force_n\n0,0\n20,5\n40,20\n")
    places = [index for index, line in enumerate(lines) if "=" in line]
    for _ in range(100):
        changed = list(lines)
        for place in chance.sample(places, chance.randint(1, 2)):
            key = lines[place].split("=")[0].strip()
            changed[place] = chance.choice([f"{key} = {chance.choice(VALUES)}"] * 4 + [f"{key[1:]} = 1", ""])
        path = tmp_path / "ours.toml"
        path.write_text("\n".join(changed))
        try:
            load_fabric(path)
        except InputError as error:
            assert str(error).startswith(f"fabric file {path}") and ("\n" not in str(error) or "unusual" in str(error))
            assert not any(words in str(error) for words in PYTHON), (error, set(changed) - set(lines))
