"""What is found of a tool's surface: unit, direction, rim and size of the blank; and the job that is written of it."""

import numpy as np
import pytest
import trimesh

from tests.support.jobs import tray_surface, two_valleys, write_stl
from weavesim import InputError, glass_polypropylene
from weavesim.job.advice.damping import suggested_damping
from weavesim.job.build import Builder
from weavesim.job.draft.survey import survey
from weavesim.job.draft.template import Choices, blank_sides, mesh_size_for, new_job
from weavesim.job.read import read_job


@pytest.fixture(scope="module")
def tray(tmp_path_factory):
    return survey(write_stl(tmp_path_factory.mktemp("tray") / "die.stl", *tray_surface()))


def test_a_tray_in_millimetres(tray):
    assert (tray.unit, tray.up, tray.is_female) == ("mm", "+z", True)
    assert np.allclose(tray.size, [0.26, 0.22, 0.025])
    assert np.isclose(tray.rim_height, 0.0)
    assert np.allclose(tray.opening, [[-0.08, -0.06], [0.08, 0.06]], atol=2e-4)
    assert np.isclose(tray.radius, 0.008, rtol=0.05)
    assert "guessed from the size of 260 x 220 x 25" in tray.unit_reason


def test_the_sections_are_as_long_as_their_profile(tray):
    from tests.support.jobs import section

    for half, found in ((80.0, tray.arc[0]), (60.0, tray.arc[1])):
        profile = section(half, 10.0, 8.0, 25.0, 5.0, 8)
        assert np.isclose(found, 2e-3 * np.linalg.norm(np.diff(profile, axis=0), axis=1).sum(), rtol=1e-3)


@pytest.mark.parametrize(("scale", "unit"), [(1.0, "mm"), (1e-3, "m"), (1 / 25.4, "inch")])
def test_the_unit_is_guessed_from_the_size(tmp_path, scale, unit):
    vertices, faces = tray_surface()
    assert survey(write_stl(tmp_path / "die.stl", scale * vertices, faces)).unit == unit


def test_the_direction_of_an_open_surface_is_that_of_its_triangles(tmp_path):
    vertices, faces = tray_surface()
    path = write_stl(tmp_path / "die.stl", vertices[:, [2, 0, 1]], faces)
    assert survey(path).up == "+x"
    found = survey(path, up="-x")
    assert (found.up, found.is_female) == ("-x", False)


@pytest.mark.parametrize(("turn", "up"), [((0, 1, 2), "+z"), ((2, 0, 1), "+x"), ((1, 2, 0), "+y")])
def test_of_a_block_the_hollow_side_is_up(tmp_path, turn, up):
    block, pocket = trimesh.creation.box((200, 160, 60)), trimesh.creation.box((120, 80, 40))
    pocket.apply_translation((0, 0, 20))
    die = trimesh.boolean.difference([block, pocket], engine="manifold")
    write_stl(tmp_path / "die.stl", die.vertices[:, turn], die.faces)
    found = survey(tmp_path / "die.stl")
    assert (found.up, found.is_female) == (up, True)
    assert "is not flat" in found.up_reason
    assert np.allclose(np.sort(found.opening[1] - found.opening[0]), [0.08, 0.12], atol=1e-4)


def test_a_plate_shows_no_direction(tmp_path):
    trimesh.creation.box((200, 160, 6)).export(tmp_path / "die.stl")
    with pytest.raises(InputError, match="all its sides are flat; give the direction to the sheet with --up"):
        survey(tmp_path / "die.stl")


def test_the_blank_covers_the_opening_and_stays_on_the_rim(tray):
    sides = blank_sides(tray)
    assert (sides >= tray.arc).all()
    assert (sides <= tray.size[:2]).all()
    assert np.allclose(sides / 0.005, np.rint(sides / 0.005))


def test_elements_follow_the_radius_where_that_is_affordable():
    sides = np.array([0.25, 0.2])
    assert np.isclose(mesh_size_for(sides, 0.016), 0.005)
    assert mesh_size_for(sides, 0.0005) >= 0.25 / 100
    assert mesh_size_for(sides, np.inf) <= 0.25 / 40


@pytest.mark.parametrize("surface", [tray_surface, two_valleys], ids=["tray", "two valleys"])
def test_the_new_job_can_be_built_as_it_is(tmp_path, surface):
    path = write_stl(tmp_path / "die.stl", *surface())
    text = new_job(survey(path), Choices("part", "die.stl", "glass-polypropylene", gap=1.2e-3), glass_polypropylene())
    (tmp_path / "job.toml").write_text(text)
    builder = Builder(read_job(tmp_path / "job.toml"))
    assert [tool.name for tool in builder.file.job.tool] == ["die", "punch", "ring"]
    setup = builder.setup()
    # what is written is what is suggested for the strokes of the job, about
    assert 0.6 < setup.worlds[0].dynamics.damping / suggested_damping(setup.duration) < 1.6
    assert "Suggested: vibrations of the sheet fall by e six times" in text
    low = setup.tools[1].shape.display_triangles()[0][:, 2].min() - setup.tools[1].motion.displacements[-1]
    die = setup.tools[0].shape.display_triangles()[0][:, 2].min()
    assert np.isclose(low - die, 1.2e-3, atol=1e-5)


def test_the_ridge_between_two_valleys_has_its_radius(tmp_path):
    found = survey(write_stl(tmp_path / "die.stl", *two_valleys()))
    assert found.is_female
    assert np.isclose(found.radius, 0.003, rtol=0.15)


def test_a_raised_tool_has_no_ring(tmp_path):
    vertices, faces = tray_surface()
    found = survey(write_stl(tmp_path / "die.stl", vertices * [1, 1, -1], faces))
    assert not found.is_female
    text = new_job(found, Choices("part", "die.stl", "glass-polypropylene"), glass_polypropylene())
    assert "ring_of" not in text and "No holder" in text
    (tmp_path / "job.toml").write_text(text)
    Builder(read_job(tmp_path / "job.toml"))


@pytest.mark.parametrize("rim", [12.0, 20.0, 60.0])
def test_a_blank_on_a_raised_tool_ends_on_it_when_it_is_drawn_down(tmp_path, rim):
    vertices, faces = tray_surface(rim=rim)
    found = survey(write_stl(tmp_path / "die.stl", vertices * [1, 1, -1], faces))
    sides, drawn_in = blank_sides(found), found.arc - (found.opening[1] - found.opening[0])
    assert (sides > found.arc - 0.005).all() and (sides - drawn_in < found.size[:2]).all()


@pytest.mark.parametrize("raised", [False, True])
def test_the_stages_of_a_new_job_can_be_taken_as_they_are(tmp_path, raised):
    vertices, faces = tray_surface()
    path = write_stl(tmp_path / "die.stl", vertices * [1, 1, -1 if raised else 1], faces)
    text = new_job(survey(path), Choices("part", "die.stl", "glass-polypropylene", gap=1.2e-3), glass_polypropylene())
    begin, end = text.index("#[[stage]]"), text.index("[output]")
    example = "\n".join(line.removeprefix("#") for line in text[begin:end].split("\n"))
    assert ("and the ring" in example) != raised
    (tmp_path / "job.toml").write_text(text[:begin] + example + text[end:])
    setup = Builder(read_job(tmp_path / "job.toml")).setup()
    assert [stage.name for stage in setup.stages] == ["close", "hold", "release"]
    assert setup.stages[0].duration == setup.tools[1].motion.duration
    assert setup.stages[2].tools == ("die",) and setup.stages[2].end is not None
