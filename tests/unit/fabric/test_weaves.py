"""The plain weave's parameters: derived quantities, and which values are refused."""

import math

import pytest

from weavesim.errors import InputError
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.presets import glass_polypropylene


def test_unit_cell_has_the_papers_parameters():
    cell = PlainWeave(
        warp_modulus=70e9, weft_modulus=50e9, contact_modulus=1e8, warp_cross_section=1e-7, weft_cross_section=2e-7,
        contact_cross_section=1e-5, warp_second_moment=1e-16, weft_second_moment=2e-16, warp_half_spacing=3e-3,
        weft_half_spacing=2e-3, crossover_height=4e-4, warp_crimp_share=0.25,
    )  # fmt: skip
    assert cell.axial_stiffness == pytest.approx((7000.0, 10000.0))
    assert cell.bending_stiffness == pytest.approx((7e-6, 1e-5))
    assert cell.crimp_height == pytest.approx((1e-4, 3e-4))
    assert cell.chord_length == pytest.approx((math.hypot(3e-3, 1e-4), math.hypot(2e-3, 3e-4)))
    assert cell.contact_stiffness == pytest.approx(1e8 * 1e-5 / 4e-4)
    # yarns along the warp are spaced by the weft's crossover distance
    assert cell.yarn_stiffness_per_width == pytest.approx((7000.0 / 4e-3, 10000.0 / 6e-3))
    assert cell.compressive_stiffness == pytest.approx(
        (3 * 7e-6 / cell.chord_length[0] ** 2, 3 * 1e-5 / cell.chord_length[1] ** 2)
    )


def cell_with(**changes) -> PlainWeave:
    return PlainWeave(**(glass_polypropylene().unit_cell.model_dump() | changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"warp_modulus": -1.0}, "warp_modulus = -1.0"),
        ({"weft_modulus": 0.0}, "weft_modulus = 0.0"),
        ({"contact_modulus": math.nan}, "contact_modulus = nan"),
        ({"warp_cross_section": math.inf}, "warp_cross_section = inf"),
        ({"warp_second_moment": -1e-20}, "warp_second_moment"),
        ({"warp_crimp_share": 1.2}, "warp_crimp_share = 1.2"),
        ({"contact": "sticky"}, "contact = 'sticky'"),
        ({"crossover_height": 0.0}, "contact_stiffness_value"),
        ({"weft_compressive_stiffness": -3.0}, "weft_compressive_stiffness = -3.0"),
        ({"wrap_modulus": 1.0}, "wrap_modulus"),
        ({"warp_modulus": "stiff"}, "warp_modulus = 'stiff'"),
    ],
)
def test_bad_cells_are_refused_by_name(changes, message):
    with pytest.raises(InputError, match=message):
        cell_with(**changes)
