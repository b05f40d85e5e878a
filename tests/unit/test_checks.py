"""Checked values: by position and by name, equal by content, the same through pickle and JSON, kinds told apart."""

import copy
import json
import pickle
from typing import ClassVar, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from pydantic import SerializeAsAny

from weavesim.arrays import BoolArray, FloatArray, IndexArray
from weavesim.checks import Kinded, Parameters, Positive, json_schema, typed_as
from weavesim.errors import InputError, did_you_mean
from weavesim.tools.shapes import Sphere


class Body(Kinded):
    is_kind: ClassVar[bool] = False
    height: float = 0.0


class Ball(Body):
    positional = ("radius",)
    radius: Positive


class Pile(Body):
    bodies: tuple[SerializeAsAny[Body], ...]


class Box(Parameters):
    positional = ("body", "values")
    body: SerializeAsAny[Body]
    values: FloatArray
    nodes: IndexArray = ()
    held: BoolArray | None = None


class Plain(Parameters):
    count: int = 1
    name: str = "plain"
    side: Literal["top", "bottom"] = "top"


def box() -> Box:
    values = np.linspace(0.0, 1.0, 60).reshape(20, 3) / 3.0
    return Box(Pile(bodies=(Ball(1.0), Pile(bodies=(Ball(2.0, height=0.1),)))), values, nodes=[3, 1])


def test_values_by_place_are_those_by_name():
    assert Ball(2.0) == Ball(radius=2.0)
    assert Ball(2.0) != Ball(2.5) and Ball(2.0) != Pile(bodies=())


@pytest.mark.parametrize("copied", [lambda b: pickle.loads(pickle.dumps(b)), lambda b: Box.from_json(b.to_json())])
def test_pickle_and_json_give_an_equal_read_only_value(copied):
    there = copied(box())
    assert there == box() and hash(there) == hash(box()) and there.content_hash == box().content_hash
    assert there.values.tobytes() == box().values.tobytes() and there.values.dtype == np.float64
    with pytest.raises(ValueError, match="read-only"):
        there.values[0, 0] = 1.0


def test_hash_sees_every_number():
    other = box().values.copy()
    other[7, 1] = np.nextafter(other[7, 1], 1.0)
    assert box().model_copy(update={"values": other}).content_hash != box().content_hash


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda b: pickle.loads(pickle.dumps(b)), lambda b: b])
def test_arrays_cannot_be_thawed(copied):
    there = copied(box())
    for array in (there.values, there.nodes, Box(Ball(1.0), np.empty((0, 3))).values):
        with pytest.raises(ValueError, match="cannot set WRITEABLE flag"):
            array.setflags(write=True)
    assert there == box()


def test_equal_values_have_equal_hashes_down_to_the_sign_of_zero():
    made = [
        lambda zero: Ball(1.0, height=zero),
        lambda zero: Pile(bodies=(Ball(1.0, height=zero),)),
        lambda zero: Box(Ball(1.0), [zero, 1.0]),
        lambda zero: Box(Ball(1.0), np.full((5, 20), zero)),
        lambda zero: Sphere(0.1, origin=(0.0, 0.0, zero)),
    ]
    for make in made:
        assert make(-0.0) == make(-0.0) and hash(make(-0.0)) == hash(make(-0.0))
        assert make(0.0) != make(-0.0) and make(0.0).content_hash != make(-0.0).content_hash
        assert type(make(0.0)).from_json(make(-0.0).to_json()) == make(-0.0)


@given(arrays.arrays(np.float64, arrays.array_shapes(min_dims=1, max_dims=3, min_side=0)))
def test_any_array_survives_json(values):
    there = Box.from_json(Box(Ball(1.0), values).to_json()).values
    assert there.shape == values.shape and there.tobytes() == values.tobytes()


@given(st.lists(st.booleans(), max_size=50))
def test_flags_survive_json(flags):
    there = Box.from_json(Box(Ball(1.0), [0.0], held=np.array(flags, dtype=bool)).to_json()).held
    assert there.dtype == bool and there.tolist() == flags


def test_a_value_does_not_change_and_says_what_to_do():
    ball = Ball(1.0)
    with pytest.raises(InputError, match=r"Ball: radius does not change .* model_copy\(update=\{'radius': ...\}\)"):
        ball.radius = 2.0
    assert ball.radius == 1.0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Ball(-1.0), "radius = -1.0"),
        (lambda: Ball(), "radius: is required"),
        (lambda: Ball(1.0, 2.0), "Ball: 2 values are given by position; allowed are radius"),
        (lambda: Pile(1.0), "Pile: 1 values are given by position; allowed are none; give others by name: .*bodies"),
        (lambda: Ball(1.0, radius=2.0), "radius is given twice"),
        (lambda: Ball(True), "a number is needed, not true"),
        (lambda: Body(), "kind = 'Body': one of Ball, Pile"),
        (lambda: Box({"kind": "Cube"}, [1.0]), "kind = 'Cube': one of Ball, Pile"),
        (lambda: Box({"kind": ["Ball"]}, [1.0]), r"kind = \['Ball'\]: one of Ball, Pile"),
        (lambda: Box({"kind": {}}, [1.0]), "one of Ball, Pile"),
        (lambda: Pile(bodies=Ball(1.0)), r"bodies = Ball\(...\): give a list"),
        (lambda: Ball(float("inf")), "radius = inf: a finite number is needed"),
        (lambda: Ball(float("nan")), "radius = nan: a finite number is needed"),
        (lambda: Plain(cuont=2), "Plain: cuont = 2: unknown name; did you mean 'count'\\?"),
        (lambda: Plain(Name="x"), "Name = 'x': unknown name; did you mean 'name'\\?"),
        (lambda: Ball(1.0, hieght=2.0), "did you mean 'height'\\?"),
        (lambda: Plain(**{"qqqq": 1}), "Plain: qqqq = 1: unknown name$"),
        (lambda: Plain(**{"a\nb": 1}), r"Plain: a\\nb = 1: unknown name$"),
        (lambda: Ball.from_json('{"kind": "Ball", "radios": 1}'), "did you mean 'radius'\\?"),
        (lambda: Ball("1_0"), "radius = '1_0': a number is needed, not a text"),
        (lambda: Plain(count="1"), "count = '1': a number is needed, not a text"),
        (lambda: Plain(count=1.5), "Plain: count = 1.5: a whole number is needed"),
        (lambda: Plain(name=7), "Plain: name = 7: a text is needed"),
        (lambda: Plain(side="left"), "Plain: side = 'left': one of 'top' or 'bottom' is needed"),
        (lambda: Box(Ball(1.0), ["x"]), "an array of float64"),
        (lambda: Box(Ball(1.0), [1.0], nodes=[0.5]), "an array of int32"),
        (lambda: Box(Ball(1.0), [1.0], nodes=[2**40]), "out of range of int32"),
        (lambda: Box(Ball(1.0), {"shape": [3], "base64": "AAAA"}), "in base64"),
        (lambda: Box.from_json("{"), "not valid JSON"),
        (lambda: Box.from_json("[" * 100_000), "not valid JSON"),
        (lambda: Box.from_json('{"values": ' + "1" * 5000 + "}"), "not valid JSON"),
        (lambda: Ball.from_json('{"kind": "Ball", "radius": 1, "radius": 2}'), "'radius' occurs twice"),
        (lambda: Ball.from_json('{"kind": "Ball", "radius": NaN}'), "NaN: a finite number"),
        (lambda: Ball.from_json('{"kind": "Ball", "radius": 1e999}'), "radius = inf: a finite number"),
        (
            lambda: Box.from_json(box().to_json().replace('"radius": 2.0', '"radius": -2.0')),
            "Box: body: Pile: bodies.1: Pile: bodies.0: Ball: radius = -2.0",
        ),
        (lambda: Box.from_json('{"body": {"kind": "Ball", "radius": 1}, "values": [1], "other": 2}'), "other = 2"),
        (lambda: Box.from_json('{"body": {"kind": "Ball", "radius": 1}}'), "values: is required"),
    ],
)
def test_bad_values_are_named(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_messages_name_what_was_typed():
    with typed_as({"count": "--count"}), pytest.raises(InputError, match=r"^--count = 1.5: a whole number") as raised:
        Plain(count=1.5)
    assert "Plain" not in str(raised.value)
    with pytest.raises(InputError, match="^Plain: count = 1.5"):
        Plain(count=1.5)


def test_a_nearest_name_is_found_in_little_time():
    assert did_you_mean("thicknes", ["thickness"]) == "; did you mean 'thickness'?"
    assert did_you_mean("x" * 10**6, ["thickness"]) == did_you_mean("", []) == ""


def test_schema_knows_every_kind():
    schema = json_schema(Box)
    assert {"Ball", "Pile"} <= set(schema["$defs"])
    assert schema["$defs"]["Ball"]["properties"]["kind"] == {"const": "Ball", "type": "string"}
    text = json.dumps(schema)
    for name in ("Ball", "Pile"):
        assert f'{{"$ref": "#/$defs/{name}"}}' in text
