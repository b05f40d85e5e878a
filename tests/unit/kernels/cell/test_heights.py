"""Heights of the plain weave: a stiff contact leaves no difference of rounded heights in its force."""

import pytest

from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.response import respond


@pytest.mark.parametrize("contact", ["bilateral", "unilateral"])
@pytest.mark.parametrize("contact_stiffness", [1e6, 1e9, 1e12, 1e15])
def test_crossover_force_of_a_stiff_contact(contact_stiffness, contact):
    """That of an incompressible crossover, in both precisions: from 1e9 N/m on it hardly depends on the stiffness."""
    stretch, soft = [[1.001, 1.0]], {"warp_second_moment": 1e-20, "weft_second_moment": 1e-20}
    exact = respond(PlainWeave.glass_polypropylene(contact_stiffness_value=1e9, **soft), stretch).crossover_force[0]
    cell = PlainWeave.glass_polypropylene(contact=contact, contact_stiffness_value=contact_stiffness, **soft)
    for precision in ("float32", "float64"):
        found = respond(cell, stretch, precision=precision, increment_count=5)
        assert found.crossover_force[0] == pytest.approx(exact, rel=0.5 if contact_stiffness < 1e9 else 1e-3)
        assert found.residual[0] < 1e-4


def test_heights_are_of_opposite_sign_in_a_stiff_contact():
    """Crimp goes from the pulled yarn to the other."""
    cell = PlainWeave.glass_polypropylene(contact_stiffness_value=1e12)
    warp, weft = respond(cell, [[1.001, 1.0]], precision="float32").unknowns[0]
    assert warp < 0.0 and weft == pytest.approx(-warp, rel=1e-6)
