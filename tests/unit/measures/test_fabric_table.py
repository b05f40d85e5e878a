"""The table of a fabric: the same in any width, and plain about what nobody said."""

from weavesim import Origin, glass_polypropylene
from weavesim.measures.fabric_table import fabric_table, rows_of, summary_of


def test_a_narrow_terminal_has_the_same_table(monkeypatch):
    fabric = glass_polypropylene()
    wide, narrow = (" ".join(fabric_table(fabric, width).split()) for width in (170, 80))
    assert "Young's modulus of the warp yarn" in wide and "Young's modulus of the warp yarn" in narrow
    assert "in-plane bending stiffness of the yarns, which keeps the shear angle from jumping" in narrow


def test_what_nobody_said_is_told():
    fabric = glass_polypropylene().model_copy(update={"thickness": 1.3e-3})
    row = next(row for row in rows_of(fabric)[0] if row.cells[0] == "thickness")
    assert row.cells[5] == "not said" and "of 1 nobody said where they come from" in summary_of(fabric)
    fabric = fabric.model_copy(update={"provenance": (Origin(of="thickness", source="a\nb", note="c"),)})
    rows, sources = rows_of(fabric)
    assert sources == ["a\\nb; c"]  # no line of its own
    assert next(row for row in rows if row.cells[0] == "thickness").cells[3] == "not said"
