# ruff: noqa: E501
"""Friction laws in jobs: of tools, of interfaces, of one pair; with units, and broken ones refused by name."""

import pytest

from tests.support.jobs import changed, write_tray
from weavesim import Coulomb, InputError, PressureFriction, StribeckFriction, ViscousFilm, YarnAngleFriction
from weavesim.job.build import setup_of
from weavesim.job.read import read_job

STACK = """\
[[ply]]
fabric = "glass-polypropylene"
rectangle = ["100 mm", "80 mm"]
mesh_size = "10 mm"
layup = "0/45/90"

[[tool]]
name = "table"
shape = { kind = "Plane" }
faces = "up"
friction = 0.1

[interface]
friction = 0.3

[process]
duration = "5 ms"
"""


def stack(folder, *changes):
    return setup_of(read_job(write_tray(folder, changed(STACK, *changes))))


def test_numbers_are_coefficients(tmp_path):
    setup = stack(tmp_path)
    assert setup.tools[0].friction == 0.1
    assert [each.friction for each in setup.interfaces] == [Coulomb(0.3), Coulomb(0.3)]
    assert stack(tmp_path, ("friction = 0.1", 'friction = "0.15"')).tools[0].friction == 0.15


def test_every_law_with_its_units(tmp_path):
    stribeck = 'friction = { kind = "StribeckFriction", hersey_numbers = ["0 mm", "1 mm"], coefficients = [0.3, 0.1], viscosity = "200 Pa s" }'
    film = 'friction = { kind = "ViscousFilm", viscosity = 500, thickness = "0.1 mm" }'
    setup = stack(tmp_path, ("friction = 0.1", stribeck), ("friction = 0.3", film))
    assert setup.tools[0].friction == StribeckFriction((0.0, 1e-3), (0.3, 0.1), 200.0)
    assert setup.interfaces[0].friction == ViscousFilm(500.0, 1e-4)
    pressure = 'friction = { kind = "PressureFriction", pressures = ["1 kPa", "1 bar"], coefficients = [0.4, 0.2] }'
    angle = 'friction = { kind = "YarnAngleFriction", angles = [0, "90 deg"], coefficients = [0.4, 0.2] }'
    setup = stack(tmp_path, ("friction = 0.1", pressure), ("friction = 0.3", angle))
    assert setup.tools[0].friction == PressureFriction((1e3, 1e5), (0.4, 0.2))
    assert setup.interfaces[1].friction == YarnAngleFriction((0.0, 90.0), (0.4, 0.2))


def test_one_pair_may_differ(tmp_path):
    pair = '[[interface.pair]]\nlower = "ply_2"\nupper = "ply_3"\nfriction = { kind = "Coulomb", coefficient = 0.5 }\npasses = "one"\n'
    setup = stack(tmp_path, ("[process]", f"{pair}\n[process]"))
    assert [(each.friction, each.passes) for each in setup.interfaces] == [
        (Coulomb(0.3), "both"),
        (Coulomb(0.5), "one"),
    ]


def test_a_ply_may_touch_itself_and_tools_are_met_between_nodes(tmp_path):
    one = ('layup = "0/45/90"', "self_contact = true")
    setup = stack(tmp_path, one, ("[process]", '[process]\ncontact_samples = "surface"'))
    assert setup.sheet.self_contact is not None and setup.sheet.self_contact.friction == Coulomb(0.3)
    assert setup.worlds[0].dynamics.contact_samples == "surface"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("friction = 0.1", 'friction = { kind = "Stribeck" }', "line 11, [[tool]] table: friction: kind = 'Stribeck': one of Coulomb, PressureFriction, StribeckFriction, ViscousFilm is needed; did you mean 'StribeckFriction'?"),
        ("friction = 0.1", 'friction = { kind = "YarnAngleFriction", angles = [0, 90], coefficients = [0.1, 0.2] }', "a tool has no yarns"),
        ("friction = 0.1", "friction = { coefficient = 0.1 }", "friction: kind = None: one of Coulomb"),
        ("friction = 0.1", 'friction = { kind = "Coulomb", coeficient = 0.1 }', "coeficient: Coulomb has no such value; did you mean 'coefficient'?"),
        ("friction = 0.1", 'friction = { kind = "ViscousFilm", viscosity = 1 }', "ViscousFilm: thickness: is required"),
        ("friction = 0.1", 'friction = { kind = "ViscousFilm", viscosity = "1 Pa", thickness = 1e-4 }', "viscosity = '1 Pa': 'Pa' is no unit of it, write '0.2 Pa s'"),
        ("friction = 0.1", 'friction = { kind = "PressureFriction", pressures = [2, 1], coefficients = [0.1, 0.2] }', "pressures goes from 2 to 1; it must increase"),
        ("friction = 0.3", 'friction = "slippery"', "[interface]: friction = 'slippery'"),
        ("friction = 0.3", 'friction = { kind = "PressureFriction", pressures = [1, 2], coefficients = [0.1] }', "[interface]: friction: PressureFriction: it has 2 pressures and 1 coefficients"),
        ("[process]", '[[interface.pair]]\nlower = "ply_1"\nupper = "ply_3"\n[process]', "no neighbours; there are ply_1 / ply_2, ply_2 / ply_3"),
        ("[process]", '[[interface.pair]]\nlower = "ply_1"\nupper = "ply_2"\n' * 2 + "[process]", "this pair is given twice"),
        ("[process]", '[[interface.pair]]\nlower = "ply_1"\n[process]', "upper: is required"),
        ("[process]", '[process]\ncontact_samples = "between"', "contact_samples = 'between': one of 'nodes' or 'surface' is needed"),
        ('layup = "0/45/90"', "", "has no effect with a single ply that does not touch itself"),
    ],
)  # fmt: skip
def test_broken_friction_is_refused(tmp_path, old, new, message):
    with pytest.raises(InputError) as error:
        stack(tmp_path, (old, new))
    assert message in str(error.value) and "tray.toml" in str(error.value)
