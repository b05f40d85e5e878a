"""What keeps runs from sharing launches is said."""

import re

import pytest

from tests.support.runs import one_sheet_setup, small_run
from weavesim.engine.setup import World
from weavesim.engine.worlds.alike import differences, obstacles
from weavesim.fabric.presets import glass_polypropylene
from weavesim.process.dynamics import Dynamics
from weavesim.process.friction import ViscousFilm
from weavesim.process.pressure import Pressure
from weavesim.process.self_contact import SelfContact
from weavesim.process.strokes import Stroke
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.tools.shapes import Plane
from weavesim.tools.tool import Tool

BLANK = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005)
TABLE = Tool("table", Plane(origin=(0.0, 0.0, -0.01)))
TWO_KNOTS, THREE_KNOTS = Stroke((0.0, 1e-3), (0.0, 1e-3)), Stroke((0.0, 5e-4, 1e-3), (0.0, 1e-4, 1e-3))


def setup(**given):
    settings = {"name": "small", "blank": BLANK, "fabric": glass_polypropylene(), "duration": 1e-3}
    return one_sheet_setup(**(settings | given))


def with_self_contact():
    one = setup()
    sheet = one.sheet.model_copy(update={"self_contact": SelfContact()})
    return one.model_copy(update={"worlds": (World(sheets=(sheet,)),)})


def with_two_sheets():
    sheets = [(Sheet(BLANK, glass_polypropylene(), name=name),) for name in "ab"]
    return setup().model_copy(update={"worlds": tuple(World(sheets=own, name=own[0].name) for own in sheets)})


FILM = ViscousFilm(0.1, 1e-3)


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (setup, None),
        (lambda: setup(tools=(TABLE,)), None),
        (with_two_sheets, "it has 2 sheets"),
        (with_self_contact, "its sheet may touch itself"),
        (
            lambda: setup(pressures=(Pressure(face="top", times=(0.0, 1e-3), pressures=(0.0, 1e3)),)),
            "there is pressure on its sheet",
        ),
        (lambda: setup(tools=(TABLE.model_copy(update={"friction": FILM}),)), "more than one coefficient"),
        (lambda: setup(tools=(TABLE,), dynamics=Dynamics(contact_samples="surface")), None),
    ],
)
def test_an_obstacle_is_named(given, why):
    found = obstacles(given())
    assert found == [] if why is None else len(found) == 1 and why in found[0]


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({}, None),
        ({"tools": [TABLE.model_copy(update={"friction": 0.4, "motion": TWO_KNOTS})]}, None),
        ({"precision": "float32"}, r"their precision differs \(float64 and float32\)"),
        ({"tools": []}, "their kinds of tools, loads and supports differ"),
        ({"tools": [TABLE, TABLE.model_copy(update={"name": "other"})]}, r"their number of tools differs \(1 and 2\)"),
        ({"blank": Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.002)}, "their number of elements differs"),
        ({"tools": [TABLE.model_copy(update={"motion": THREE_KNOTS})]}, "their kinds of curves and tables differ"),
    ],
)  # fmt: skip
def test_a_difference_is_named(given, why):
    moved = TABLE.model_copy(update={"motion": TWO_KNOTS})
    first, other = (small_run(tools=[moved]).model, small_run(**({"tools": [moved]} | given)).model)
    found = "; ".join(differences(first, other))
    assert found == "" if why is None else re.search(why, found)
