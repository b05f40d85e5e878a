"""Friction laws and interfaces are checked before a run."""

import numpy as np
import pytest

from tests.support.folded_strips import fold_blank
from tests.support.sheet import plain_fabric
from tests.support.stacked_plies import THICKNESS, ply, square, stack_setup
from tests.support.summary_keys import keys_without_unit
from weavesim import Blank, Dynamics, InputError, Plane, SelfContact, Setup, Sheet, Simulation, Tool
from weavesim.process import (
    Coulomb,
    Friction,
    Interface,
    PressureFriction,
    StribeckFriction,
    ViscousFilm,
    YarnAngleFriction,
)
from weavesim.sheet.symmetry import Symmetry

PLIES = [ply("lower", square(0.01, 0.01)), ply("upper", square(0.01, 0.01, THICKNESS))]


def test_tables_are_in_the_units_of_the_kernels():
    angles, coefficients = YarnAngleFriction((0.0, 90.0), (0.1, 0.4)).table()
    np.testing.assert_allclose(angles, (0.0, 0.5 * np.pi))
    np.testing.assert_allclose(coefficients, (0.1, 0.4))
    assert Coulomb(0.3).table()[1].tolist() == [0.3]
    assert ViscousFilm(100.0, 1e-4, 0.05).table()[1].tolist() == [0.05]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Coulomb(-0.1), "at least 0"),
        (lambda: PressureFriction((0.0,), (0.2,)), "at least two"),
        (lambda: PressureFriction((0.0, 1e4), (0.2,)), "the same number of both"),
        (lambda: PressureFriction((1e4, 0.0), (0.2, 0.3)), "it must increase"),
        (lambda: YarnAngleFriction((0.0, 120.0), (0.2, 0.3)), "at most 90"),
        (lambda: StribeckFriction((0.0, 1.0), (0.2, -0.3), 100.0), "must not be negative"),
        (lambda: ViscousFilm(100.0, 0.0), "above 0"),
        (lambda: Interface("a", "a"), "joins two sheets"),
        (lambda: Interface("a", "b", stiffness_share=0.5), "at most 0.2"),
    ],
)
def test_bad_laws_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"interfaces": (Interface("lower", "uper"),)}, "no sheet 'uper'.*did you mean 'upper'"),
        ({"interfaces": (Interface("lower", "upper"), Interface("upper", "lower"))}, "is that of entry 0 already"),
        ({"dynamics": {"contact_thickness": "current"}}, "at the initial thickness"),
    ],
)
def test_bad_interfaces_are_refused(change, message):
    with pytest.raises(InputError, match=message):
        stack_setup(PLIES, Coulomb(0.2), duration=1e-3, **change)


@pytest.mark.parametrize(
    ("friction", "message"),
    [
        (YarnAngleFriction((0.0, 90.0), (0.2, 0.3)), "a tool has no yarns"),
        (-0.1, "friction = -0.1: at least 0 is needed"),
        ("much", "a number is needed, not a text"),
        ({"kind": "Coulom", "coefficient": 0.2}, "kind = 'Coulom': one of Coulomb"),
        ({"kind": "PressureFriction", "pressures": [1.0], "coefficients": [0.2]}, "at least two"),
    ],
)
def test_bad_friction_of_a_tool_is_refused(friction, message):
    with pytest.raises(InputError, match=message):
        Tool("table", Plane(), friction=friction)


def test_a_law_of_a_tool_survives_json_and_a_number_stays_one():
    for friction in (0.25, StribeckFriction((0.0, 1.0), (0.2, 0.3), 100.0)):
        tool = Tool("table", Plane(), friction=friction)
        again = Tool.from_json(tool.to_json())
        assert again == tool and type(again.friction) is type(friction)


def test_interfaces_survive_json():
    setup = stack_setup(PLIES, StribeckFriction((0.0, 1.0), (0.2, 0.3), 100.0), duration=1e-3)
    again = Setup.from_json(setup.to_json())
    assert again == setup and isinstance(again.interfaces[0].friction, Friction)


@pytest.mark.parametrize(
    ("height", "message"),
    [(0.7 * THICKNESS, r"start inside each other by 0\.36 mm"), (-THICKNESS, "upper starts below lower")],
)
def test_plies_that_start_inside_each_other_or_upside_down_are_refused(height, message):
    plies = [PLIES[0], ply("upper", square(0.01, 0.01, height))]
    setup = stack_setup(plies, Coulomb(0.2), duration=1e-3, accept_unusual=False, solver={"precision": "float32"})
    with pytest.raises(InputError, match=message):
        Simulation(setup).prepare()


def test_an_overlap_that_is_accepted_makes_no_force():
    """Known answer D: started 0.2 t overlapped, the kinetic energy stays 0."""
    plies = [PLIES[0], ply("upper", square(0.01, 0.01, 0.8 * THICKNESS))]
    run = Simulation(stack_setup(plies, Coulomb(0.2), duration=2e-4))
    run.run()
    assert run.history[-1]["kinetic"] < 1e-25
    report = run.summary()["interfaces"][0]
    assert report["max_entry_mm"] == pytest.approx(0.2e3 * THICKNESS, rel=1e-6) and report["force_n"] == 0.0
    assert not keys_without_unit(run.summary())


def test_use_beyond_a_friction_table_is_told_with_place_and_time():
    plies = [
        ply("lower", square(0.01, 0.005), pressure=2e3),
        ply("upper", square(0.01, 0.005, THICKNESS), (0.5, 0.0, 0.0), pressure=-2e3),
    ]
    run = Simulation(stack_setup(plies, PressureFriction((0.0, 500.0), (0.3, 0.2)), duration=1e-3))
    run.run()
    doubt = next(doubt for doubt in run.doubts() if "friction table" in doubt.text)
    assert doubt.place and doubt.time and doubt.value > 500.0 and "0 to 500 Pa" in doubt.text
    fields = run.frame.sheets[1].fields
    assert fields["ply_pressure_below"].mean() == pytest.approx(2e3, rel=0.2) and fields["ply_slip_below"].min() > 0.0
    assert "ply_pressure_above" not in fields


def test_self_contact_at_the_current_thickness_is_refused():
    sheet = Sheet(square(0.01, 0.01), plain_fabric(), name="cloth", self_contact=SelfContact())
    with pytest.raises(
        InputError, match="contact_thickness = 'current': self-contact of sheet cloth is at the initial"
    ):
        Setup("fold", sheets=(sheet,), duration=1e-3, dynamics=Dynamics(contact_thickness="current"))


def test_a_sheet_at_a_symmetry_plane_meets_its_image_with_both_faces():
    """Passes of both faces at each plane; neighbours of the plane, within a thickness, never touch their images."""
    blank = Blank.rectangle((0.0, 0.0), (0.01, 0.01), 0.0005)
    fabric = plain_fabric(thickness=0.001)
    sheet = Sheet(blank, fabric, self_contact=SelfContact())
    setup = Setup("corner", sheets=(sheet,), symmetry=("x", "y"), duration=1e-3, accept_unusual=True)
    mirrors = [each for each in Simulation(setup).model.passes if each.place.plane]
    assert [(each.place.plane, each.place.facing) for each in mirrors] == [("x", 1), ("x", -1), ("y", 1), ("y", -1)]
    for each in mirrors:
        assert each.thickness == pytest.approx(0.5 * fabric.thickness)
        away = blank.node_position[:, "xy".index(each.place.plane)]
        assert ((each.least_cosine > 1.0) == (away < fabric.thickness + 1e-9)).all()
    assert all(not each.place.plane for each in Simulation(setup.model_copy(
        update={"worlds": (setup.worlds[0].model_copy(update={"symmetry": Symmetry()}),)}
    )).model.passes)  # fmt: skip


def test_self_contact_needs_flat_coordinates_of_its_own():
    """The legs of a fold lie on each other in x and y: nothing tells there what is a neighbour."""
    blank = fold_blank(0.004, 0.02, 0.004)
    assert Sheet(blank, plain_fabric(), self_contact=SelfContact()).self_contact.friction == Coulomb(0.2)
    plan = Blank.from_mesh(blank.node_position, blank.quads, warp_direction=blank.warp_direction)
    with pytest.raises(InputError, match="self_contact: element .* material_coordinates"):
        Sheet(plan, plain_fabric(), self_contact=SelfContact())
