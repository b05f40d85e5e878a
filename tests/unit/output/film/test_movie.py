"""Movies of a film: every frame, the right colours, and only fields that are there."""

import sys
from dataclasses import astuple

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.output.film.movie import Movie, _about, _side, drawn_frames, scale_of, write_mp4, write_pictures
from weavesim.output.film.reading import StoredFilm

pytest.importorskip("pyvista")
SIZE = (240, 160)


@pytest.fixture(scope="module")
def film(film_path):
    return StoredFilm(film_path)


@pytest.fixture(scope="module")
def pictures(film):
    return list(drawn_frames(film, Movie(size=SIZE)))


def coloured(picture) -> np.ndarray:
    """Pixels of the sheet, above the legend: those that are neither grey nor beige."""
    rows = picture[: int(0.85 * len(picture))].astype(int)
    return rows[np.ptp(rows, axis=2) > 60]


def test_every_frame_is_drawn_and_the_sheet_forms(pictures, film):
    assert len(pictures) == len(film.frames)
    for picture in pictures:
        assert picture.shape == (160, 240, 3) and picture.dtype == np.uint8
        assert (picture == 255).all(axis=2).mean() < 0.9
    # all violet at the start, green where it is sheared at the end
    first, last = coloured(pictures[0]), coloured(pictures[-1])
    assert np.all(first[:, 1] < first[:, 2] - 20)
    assert (last[:, 1] > last[:, 0] + 60).sum() > 20 > (first[:, 1] > first[:, 0] + 60).sum()


def test_the_scale_is_the_same_in_every_frame(pictures):
    strips = [picture[int(0.86 * len(picture)) :] for picture in pictures]
    assert all(np.array_equal(strip, strips[0]) for strip in strips)
    assert len(np.unique(strips[0].reshape(-1, 3), axis=0)) > 50


def test_a_movie_tells_stroke_and_side(film):
    assert _about(film, len(film.frames) - 1) == "double dome,  time 0.06 s,  stroke 60.0 mm"
    assert _side(film, Movie()) == "seen from below, turned over"
    assert _side(film, Movie(back=True)) == "seen from above"


def test_the_whole_part_is_larger_than_what_was_computed(pictures, film):
    (quarter, *_) = drawn_frames(film, Movie(size=SIZE, mirror=False, tools=False))
    (whole, *_) = drawn_frames(film, Movie(size=SIZE, tools=False))
    assert 2.5 < len(coloured(whole)) / len(coloured(quarter)) < 6.0
    assert len(coloured(whole)) >= len(coloured(pictures[0]))


def test_the_scale_is_that_of_all_frames_or_as_it_is_wanted(film, coarse_run):
    thickness = film.fields["thickness"]
    low, high, smallest, largest, beyond = astuple(scale_of(film, Movie("thickness"), thickness))
    values = np.concatenate([frame.fields["thickness"] for frame in coarse_run[1]])
    assert values.min() <= low < high <= values.max() * (1.0 + 1e-6)
    assert (smallest, largest) == pytest.approx((values.min(), values.max())) and 0.0 < beyond < 0.01
    assert astuple(scale_of(film, Movie("thickness", limits=(0.0, 2e-3)), thickness))[:2] == (0.0, 2e-3)
    angle = scale_of(film, Movie(), film.fields["shear_angle_deg"])
    assert (angle.low, angle.high, angle.beyond) == (0.0, 60.0, 0.0) and angle.smallest >= 0.0


def test_a_movie_has_every_frame_at_its_rate(tmp_path, film):
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "movie.mp4"
    write_mp4(film, Movie("thickness", size=SIZE, frames_per_second=12.0), path)
    count, seconds = imageio_ffmpeg.count_frames_and_secs(str(path))
    assert count == len(film.frames) and seconds == pytest.approx(count / 12.0, abs=0.1)
    reader = imageio_ffmpeg.read_frames(str(path))
    about = next(reader)
    assert about["source_size"] == SIZE and about["codec"].startswith("h264")
    first, *_, last = (np.frombuffer(data, dtype=np.uint8).reshape(160, 240, 3).astype(int) for data in reader)
    assert np.abs(first - last).mean() > 1.0
    assert [file.name for file in tmp_path.iterdir()] == ["movie.mp4"]


def test_pictures_are_numbered(tmp_path, film):
    files = write_pictures(film, Movie("warp_stretch", size=(96, 64), back=True), tmp_path / "frames")
    assert [file.name for file in files] == [f"frame_{k:04d}.png" for k in range(len(film.frames))]
    assert all(file.stat().st_size > 300 for file in files)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"size": (101, 100)}, "even numbers"), ({"size": (10, 100)}, "even numbers"),
        ({"frames_per_second": 0.0}, "0.1"),
        ({"frames_per_second": float("nan")}, "0.1 to 240"), ({"limits": (1.0, 1.0)}, "smaller"),
        ({"limits": (float("nan"), 1.0)}, "smaller"),
    ],
)  # fmt: skip
def test_movies_that_cannot_be_are_refused(given, words):
    with pytest.raises(InputError, match=words):
        Movie(**given)


def test_an_unknown_field_is_refused_with_those_there_are(film, tmp_path):
    with pytest.raises(InputError, match="field 'colour': the film has .*shear_angle_deg, .*thickness"):
        write_mp4(film, Movie("colour"), tmp_path / "movie.mp4")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("package", "words"), [("pyvista", "PyVista"), ("imageio_ffmpeg", "imageio-ffmpeg")])
def test_a_missing_package_is_named_with_what_to_install(film, tmp_path, monkeypatch, package, words):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(InputError, match=rf'{words}.*pip install "weavesim\[film\]"'):
        write_mp4(film, Movie(size=SIZE), tmp_path / "movie.mp4")
