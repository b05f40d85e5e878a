"""Units in headers: their factors, and what is no unit."""

import math

import pytest

from weavesim.tables.units import parse_unit, split_header, unit_cell

LENGTH, FORCE, MOMENT = (0, 1, 0, 0), (0, 1, 1, -2), (0, 2, 1, -2)


@pytest.mark.parametrize(
    ("text", "factor", "dimension"),
    [
        ("deg", math.pi / 180, (1, 0, 0, 0)),
        ("°", math.pi / 180, (1, 0, 0, 0)),
        ("Grad", math.pi / 180, (1, 0, 0, 0)),
        ("mrad", 1e-3, (1, 0, 0, 0)),
        ("kN", 1e3, FORCE),
        ("KN", 1e3, FORCE),
        ("mN", 1e-3, FORCE),
        ("MN", 1e6, FORCE),
        ("lbf", 4.4482216152605, FORCE),
        ("kgf", 9.80665, FORCE),
        ("N/mm", 1e3, (0, 0, 1, -2)),
        ("N/m", 1.0, (0, 0, 1, -2)),
        ("N mm/mm", 1.0, FORCE),
        ("N·m/m", 1.0, FORCE),
        ("gf·cm/cm", 9.80665e-3, FORCE),
        ("gf.cm²/cm", 9.80665e-5, MOMENT),
        ("cm^-1", 100.0, (0, -1, 0, 0)),
        ("1/mm", 1e3, (0, -1, 0, 0)),
        ("m⁻¹", 1.0, (0, -1, 0, 0)),
        ("mm**2", 1e-6, (0, 2, 0, 0)),
        ("N/mm^2", 1e6, (0, -1, 1, -2)),
        ("MPa", 1e6, (0, -1, 1, -2)),
        ("psi", 6894.757293168, (0, -1, 1, -2)),
        ("in", 0.0254, LENGTH),
        ("µm", 1e-6, LENGTH),
        ("g/m²", 1e-3, (0, -2, 1, 0)),
        ("%", 0.01, (0, 0, 0, 0)),
        ("sec.", 1.0, (0, 0, 0, 1)),
    ],
)
def test_units_have_their_factors(text, factor, dimension):
    unit = parse_unit(text)
    assert unit is not None and unit.factor == pytest.approx(factor, rel=1e-9) and unit.dimension == dimension


@pytest.mark.parametrize(
    "text", ["", " ", "lbs", "grad", "mPa", "n", "furlong", "N/", "/m", "1", "m^0", "m^99", "x" * 1000, "N//m"]
)
def test_what_is_no_unit(text):
    assert parse_unit(text) is None


@pytest.mark.parametrize(
    ("header", "name", "unit"),
    [
        ("force [kN]", "force", "kN"),
        ("Force(N)", "Force", "N"),
        ("force / N", "force", "N"),
        ("moment / N mm/mm", "moment", "N mm/mm"),
        ("Kraft in N", "Kraft", "N"),
        ("Kraft, N", "Kraft", "N"),
        ("angle_deg", "angle", "deg"),
        ("Force_kN", "Force", "kN"),
        ("angle°", "angle", "°"),
        ("force <N>", "force", "N"),
        ("loading/unloading", "loading/unloading", None),
        ("angle", "angle", None),
        ("force_mean", "force_mean", None),
        ("force_n", "force_n", None),
        ("force_MPA", "force", "MPA"),
        ("in", "in", None),
        ("x" * 500 + " [N]", "x" * 500 + " [N]", None),
        ("[N]", "[N]", None),
    ],
)
def test_headers_are_split(header, name, unit):
    found, its_unit = split_header(header)
    assert (found, its_unit.text if its_unit else None) == (name, unit)


def test_text_in_brackets_is_an_unknown_unit():
    for header in ("force [lbs]", "force (mean)", "force []", "force_mn", "force (1)"):
        name, unit = split_header(header)
        assert name == header and unit.is_known is False
    assert unit_cell("(mean)").is_known is False and unit_cell("mean") is None and unit_cell("[kN]").factor == 1e3
