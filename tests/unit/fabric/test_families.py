"""The registry of laws: files, JSON, presets, test lists and documentation know the same kinds."""

import pytest

from tests.support.registered_cells import CELLS
from tests.support.registered_laws import TERMS
from weavesim.checks import Kinded, json_schema
from weavesim.errors import InputError
from weavesim.fabric import (
    PRESETS,
    UNIT_CELLS,
    BendingLaw,
    CrossoverFriction,
    Fabric,
    FamilyBending,
    ShearLaw,
    UnitCell,
    YarnBending,
    glass_polypropylene,
    load_fabric,
)
from weavesim.fabric.families import constructors, kinds_of_field, kinds_within

FAMILIES = (UnitCell, ShearLaw, CrossoverFriction, BendingLaw, FamilyBending)


def built_in(family: type[Kinded]) -> set[str]:
    return {name for name, kind in family.kinds().items() if kind.__module__.startswith("weavesim.")}


def values_within(value) -> list:
    """A value and all checked values that it is made of."""
    if not hasattr(type(value), "model_fields"):
        return []
    inner = [values_within(getattr(value, name)) for name in type(value).model_fields]
    return [value, *(item for items in inner for item in items)]


@pytest.mark.parametrize("family", FAMILIES[1:])
def test_every_kind_of_law_is_on_the_list_of_the_energies(family):
    listed = [item for added, _ in TERMS.values() for value in added.values() for item in values_within(value)]
    assert built_in(family) == {type(item).__name__ for item in listed if isinstance(item, family)} != set()


def test_every_unit_cell_is_on_the_list_of_cells():
    assert built_in(UnitCell) <= {type(registered.make()).__name__ for registered in CELLS.values()}


def test_examples_of_cells_are_the_assumed_presets():
    assert set(UNIT_CELLS) == {name for kind in built_in(UnitCell) for name in UnitCell.kinds()[kind].examples()}
    assumed = {f"assumed-{name}" for name in UNIT_CELLS if not name.startswith("plain-weave")}
    assert {name for name in PRESETS if not name.startswith("glass-polypropylene")} == assumed


@pytest.mark.parametrize("name", PRESETS)
def test_json_gives_an_equal_fabric_and_is_a_fabric_file(name, tmp_path):
    fabric = PRESETS[name]()
    text = fabric.to_json()
    assert Fabric.from_json(text) == fabric
    path = tmp_path / "fabric.json"
    path.write_text(text)
    assert load_fabric(path) == fabric


@pytest.mark.parametrize("name", TERMS)
def test_json_knows_every_law(name):
    fabric = Fabric.model_copy(glass_polypropylene(), update=TERMS[name][0])
    assert Fabric.from_json(fabric.to_json()) == fabric


def test_a_fabric_is_made_of_these():
    assert set(kinds_of_field(Fabric, "shear")) == set(ShearLaw.kinds())
    assert set(kinds_of_field(YarnBending, "warp")) == {"BendingCurve"}
    assert kinds_of_field(Fabric, "thickness") == {}
    inside = set(kinds_within(Fabric))
    assert {name for family in FAMILIES for name in built_in(family)} | {"Compaction", "Stabilisation"} <= inside


def test_constructors_are_those_that_make_a_value():
    assert set(constructors(ShearLaw.kinds()["LinearShear"])) == set()
    assert set(constructors(UnitCell.kinds()["PlainWeave"])) == {"glass_polypropylene", "straight"}


def test_an_old_or_foreign_kind_is_refused(tmp_path):
    path = tmp_path / "old.toml"
    path.write_text('based_on = "glass-polypropylene"\n[unit_cell]\nkind = "UnitCell"\n')
    with pytest.raises(InputError, match=r"\[unit_cell\] kind = 'UnitCell': one of .*PlainWeave"):
        load_fabric(path)
    text = glass_polypropylene().to_json()
    with pytest.raises(InputError, match="unit_cell: kind = 'UnitCell': one of .*PlainWeave"):
        Fabric.from_json(text.replace("PlainWeave", "UnitCell"))
    path.write_text('based_on = "glass-polypropylene"\n[shear]\nkind = "YarnBending"\n')
    with pytest.raises(InputError, match=r"\[shear\] kind = 'YarnBending': one of LinearShear, MomentCurve is needed"):
        load_fabric(path)
    path.write_text('based_on = "glass-polypropylene"\n[thickness]\nvalue = 1e-3\n')
    with pytest.raises(InputError, match="thickness: a value is needed, not a table"):
        load_fabric(path)


def test_schema_holds_every_kind():
    definitions = json_schema(Fabric)["$defs"]
    assert {name for family in FAMILIES for name in built_in(family)} <= set(definitions)


def test_every_field_says_what_it_means():
    kinds = [Fabric, *(kind for kind in kinds_within(Fabric).values() if kind.__module__.startswith("weavesim."))]
    assert [
        f"{kind.__name__}.{name}" for kind in kinds for name, f in kind.model_fields.items() if not f.description
    ] == []
