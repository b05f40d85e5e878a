"""A film read back is the run."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from weavesim.errors import InputError
from weavesim.output.film.reading import StoredFilm
from weavesim.run.fields import FIELDS


@pytest.fixture(scope="module")
def film(film_path):
    return StoredFilm(film_path)


def test_every_frame_comes_back(film, coarse_run):
    info, frames = coarse_run
    assert film.name == info.name
    assert np.array_equal(film.times, [frame.time for frame in frames])
    assert np.array_equal(film.strokes, [frame.stroke for frame in frames])
    (sheet,) = film.sheets
    assert np.array_equal(sheet.faces, info.sheet.blank.quads)
    assert sorted(sheet.mirrors) == sorted((float(x), float(y), 1.0) for x, y in info.sheet.symmetry.mirror_factors)
    for code, frame in zip(film.frames, frames, strict=True):
        assert film.points(sheet, code) == pytest.approx(frame.position, abs=1e-7)
        assert film.values(sheet, "thickness", code) == pytest.approx(frame.fields["thickness"], rel=1e-6)
    assert film.values(sheet, "permeability", 0.0) is None


def test_tools_are_where_they_were(film, coarse_run):
    info, frames = coarse_run
    assert [tool.name for tool in film.tools] == [tool.name for tool in info.tools]
    for filmed, tool, distance in zip(film.tools, info.tools, frames[-1].tool_displacement, strict=True):
        vertices, faces = tool.display_triangles()
        assert np.array_equal(filmed.faces, faces)
        moved = vertices + distance * np.asarray(tool.axis)
        assert film.points(filmed, film.frames[-1]) == pytest.approx(moved, abs=1e-6)
        assert filmed.colour == pytest.approx(tool.colour)
    assert {tool.name: tool.opacity < 0.5 for tool in film.tools} == {
        "punch": False,
        "die": True,
        "blank_holder": False,
    }


def test_fields_have_units_and_descriptions(film, coarse_run):
    own = [field for field in FIELDS if field.name in coarse_run[1][0].fields and not field.diagnostic]
    assert {name: (f.unit, f.description) for name, f in film.fields.items()} == {
        field.file_name: (field.file_unit, field.description) for field in own
    }


def test_the_view_is_that_of_the_camera(film, film_path):
    stage = Usd.Stage.Open(str(film_path))
    for name in ("camera", "camera_back"):
        frustum = UsdGeom.Camera.Get(stage, f"/World/{name}").GetCamera(0.0).frustum
        view = film.view(name)
        assert view.eye == pytest.approx(np.array(frustum.position))
        assert view.target - view.eye == pytest.approx(
            np.array(frustum.ComputeViewDirection()) * np.linalg.norm(view.target - view.eye)
        )
        assert view.up == pytest.approx(np.array(frustum.ComputeUpVector()))
        assert view.angle == pytest.approx(frustum.GetFOV(), abs=0.1) or view.angle < frustum.GetFOV()


def test_what_is_no_film_is_told(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        StoredFilm(tmp_path / "none.usdc")
    (tmp_path / "text.usda").write_text("hello")
    with pytest.raises(InputError, match="damaged"):
        StoredFilm(tmp_path / "text.usda")
    Usd.Stage.CreateNew(str(tmp_path / "other.usda")).Save()
    with pytest.raises(InputError, match="no film of this version"):
        StoredFilm(tmp_path / "other.usda")
