"""3MF as slicers and CAD programs write it."""

import io
import zipfile

import numpy as np
import pytest

from tests.support.mesh_files import die, split, written
from weavesim.errors import InputError
from weavesim.meshes import read_mesh
from weavesim.meshes.formats import threemf
from weavesim.tools import MeshShape

NODES, QUADS = die()
TRIANGLES = split(QUADS)
CORE = 'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"'
PRODUCTION = 'xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"'


def mesh_object(number: int, nodes=NODES, triangles=TRIANGLES) -> str:
    vertices = "".join(f'<vertex x="{x:.9g}" y="{y:.9g}" z="{z:.9g}"/>' for x, y, z in nodes)
    faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in triangles)
    return (
        f'<object id="{number}" type="model"><mesh><vertices>{vertices}</vertices><triangles>{faces}</triangles></mesh>'
        "</object>"
    )


def model(resources: str, build: str, attributes: str = 'unit="millimeter"') -> str:
    parts = f"<resources>{resources}</resources><build>{build}</build>"
    return f'<?xml version="1.0"?><model {attributes} {CORE}>{parts}</model>'


def archive(text: str, more: dict | None = None, name: str = "3D/3dmodel.model") -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as file:
        for key, value in {"[Content_Types].xml": "<Types/>", name: text, **(more or {})}.items():
            file.writestr(key, value)
    return buffer.getvalue()


ONE = model(mesh_object(1), '<item objectid="1"/>')


def read(folder, content):
    return read_mesh(written(folder, "die.3mf", content))


def test_a_body_is_read_with_its_unit(tmp_path):
    mesh = read(tmp_path, archive(ONE))
    assert mesh.vertices == pytest.approx(NODES) and np.array_equal(mesh.cells[0].nodes, TRIANGLES)
    assert mesh.metres_per_unit == 0.001
    path = tmp_path / "die.3mf"
    assert len(MeshShape.from_file(path, unit_scale=0.001, side=(0, 0, 1)).surface.faces) == 128
    with pytest.raises(InputError, match="its unit is 0.001 m, but unit_scale=1 is given"):
        MeshShape.from_file(path, side=(0, 0, 1))


@pytest.mark.parametrize(
    ("attributes", "metres"),
    [("", 1e-3), ('unit="inch"', 0.0254), ('unit="meter"', 1.0), ('unit="micron"', 1e-6), ('unit="foot"', 0.3048)],
)
def test_units(tmp_path, attributes, metres):
    assert read(tmp_path, archive(model(mesh_object(1), '<item objectid="1"/>', attributes))).metres_per_unit == metres


TURN = "0 1 0 -1 0 0 0 0 1 5 6 7"  # rows: x to y, y to -x, then a translation


def turned(p):
    return np.column_stack([-p[:, 1] + 5.0, p[:, 0] + 6.0, p[:, 2] + 7.0])


@pytest.mark.parametrize(
    ("resources", "build", "places"),
    [
        (mesh_object(1), f'<item objectid="1" transform="{TURN}"/>', [turned]),
        (mesh_object(1), f'<item objectid="1"/><item objectid="1" transform="{TURN}"/>', [lambda p: p, turned]),
        (mesh_object(1) + f'<object id="2"><components><component objectid="1" transform="{TURN}"/></components>'
         '</object>', f'<item objectid="2" transform="{TURN}"/>', [lambda p: turned(turned(p))]),
        (mesh_object(1) + '<object id="2"><components><component objectid="1"/>'
         f'<component objectid="1" transform="{TURN}"/></components></object>', '<item objectid="2"/>',
         [lambda p: p, turned]),
    ],
    ids=["turned", "twice", "nested", "group"],
)  # fmt: skip
def test_bodies_are_where_the_build_places_them(tmp_path, resources, build, places):
    mesh = read(tmp_path, archive(model(resources, build)))
    assert mesh.vertices == pytest.approx(np.concatenate([place(NODES) for place in places]))
    assert len(mesh.cells[0].nodes) == 128 * len(places)
    assert ("bodies taken" in "".join(mesh.notes)) == (len(places) > 1)


def test_a_mirrored_body_is_not_turned_inside_out(tmp_path):
    build = '<item objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/>'
    mesh = read(tmp_path, archive(model(mesh_object(1), build)))
    assert np.array_equal(mesh.cells[0].nodes, TRIANGLES[:, ::-1])


def test_parts_in_other_files_are_followed(tmp_path):
    main = model(
        '<object id="2"><components><component objectid="1" p:path="/3D/Objects/a.model"/></components></object>',
        '<item objectid="2"/>', f'{PRODUCTION} requiredextensions="p"',
    )  # fmt: skip
    content = archive(main, {"3D/Objects/a.model": model(mesh_object(1), "")})
    assert len(read(tmp_path, content).cells[0].nodes) == 128


LATTICE = 'xmlns:b="http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02"'


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (archive(model(mesh_object(1), "")), "places no bodies"),
        (archive(model(mesh_object(1), '<item objectid="7"/>')), "an object that is not there"),
        (archive(model(mesh_object(1, triangles=[(0, 1, 81)]), '<item objectid="1"/>')), "a vertex that is not there"),
        (archive(model(mesh_object(1, NODES * np.nan), '<item objectid="1"/>')), "not finite"),
        (archive(ONE.replace("/model>", "")), "damaged"),
        (archive(ONE.replace("millimeter", "furlong")), "its unit is none of 3MF"),
        (archive(ONE, name="other.model"), "without 3D/3dmodel.model"),
        (archive(model(mesh_object(1), '<item objectid="1"/>', f'{LATTICE} requiredextensions="b"')), "an extension"),
        (archive(model(mesh_object(1).replace("</mesh>", f"<b:beamlattice {LATTICE}/></mesh>"), "")), "a beamlattice"),
        (archive(model(mesh_object(1), '<item objectid="1" transform="1 0 0"/>')), "damaged"),
        (archive(model('<object id="1"><components><component objectid="1"/></components></object>',
                       '<item objectid="1"/>')), "contain each other"),
        (archive(ONE)[:500], "not like 3MF"),
        (b"PK\x03\x04 nothing", "not like 3MF"),
    ],
)  # fmt: skip
def test_what_cannot_be_taken_is_named(tmp_path, content, message):
    with pytest.raises(InputError, match=message):
        read(tmp_path, content)


def test_a_damaged_part_is_refused(tmp_path):
    content = bytearray(archive(ONE))
    place = content.index(b"3D/3dmodel.model") + 200
    content[place : place + 20] = bytes(20)
    with pytest.raises(InputError, match="cannot be read"):
        read(tmp_path, bytes(content))


def test_a_bomb_is_not_unpacked(tmp_path, monkeypatch):
    """64 MiB of blanks in 64 KiB; the limit is lowered from 512 MiB to 16 MiB."""
    monkeypatch.setattr(threemf, "LARGEST_TEXT", 2**24)
    with pytest.raises(InputError, match=r"unpacks to 64\S* MiB; at most 16 MiB"):
        read(tmp_path, archive(ONE, {"bomb": b" " * 2**26}))


def test_bodies_that_multiply_are_refused(tmp_path):
    """Each object places the one before ten times: ten to the power of nine bodies."""
    groups = "".join(
        f'<object id="{k}"><components>{10 * f"""<component objectid="{k - 1}"/>"""}</components></object>'
        for k in range(2, 11)
    )
    small = mesh_object(1, NODES[:3], [(0, 1, 2)])
    with pytest.raises(InputError, match="more bodies than a tool can have"):
        read(tmp_path, archive(model(small + groups, '<item objectid="10"/>')))


def test_deep_nesting_is_refused_or_passed_over(tmp_path):
    for text in (50_000 * "<a>" + 50_000 * "</a>", 50_000 * "<a>"):
        with pytest.raises(InputError, match="cannot be read"):
            read(tmp_path, archive(f"<model {CORE}>{text}</model>"))


def test_entities_do_not_multiply(tmp_path):
    bomb = "".join(f'<!ENTITY e{k} "{10 * f"&e{k - 1};"}">' for k in range(1, 12))
    text = f'<?xml version="1.0"?><!DOCTYPE model [<!ENTITY e0 "0123456789">{bomb}]><model {CORE}>&e11;</model>'
    with pytest.raises(InputError, match="cannot be read"):
        read(tmp_path, archive(text))
