"""What is written about a picture of a movie lies in strips of its own and tells what the colours leave out."""

import numpy as np
import pytest

from weavesim.output.film.captions import Captions, Scale


def test_a_scale_tells_what_lies_beyond_its_ends():
    scale = Scale.of([np.array([1.0, 2.0, 3.0, 9.0])], 1.0, 4.0)
    assert scale.note() == (
        "all frames: smallest 1, largest 9; 25 % of the values lie beyond the ends and have their colours"
    )
    assert Scale.of([np.array([1.0, 4.0])], 1.0, 4.0).note() == "all frames: smallest 1, largest 4"
    assert "less than 0.01 %" in Scale.of([np.linspace(0.0, 1.00001, 100_000)], 0.0, 1.0).note()
    assert Scale.of([np.zeros(0)], 0.0, 1.0).note() == "no values"
    assert scale.in_unit(1e3) == Scale(1e3, 4e3, 1e3, 9e3, 0.25)


@pytest.mark.parametrize("size", [(1280, 720), (240, 160), (96, 64)])
def test_the_scene_is_left_as_it_is(size):
    captions = Captions(size, "thickness [mm]", Scale(1.0, 2.0, 0.9, 2.1, 0.1), "seen from above")
    width, height = captions.scene_size
    scene = np.random.default_rng(1).integers(0, 255, (height, width, 3)).astype(np.uint8)
    pictures = [captions.around(scene, f"run,  stroke {stroke:.1f} mm") for stroke in (0.0, 61.2)]
    assert all(picture.shape == (size[1], size[0], 3) for picture in pictures)
    top = round(0.05 * size[1])
    assert all(np.array_equal(picture[top : top + height], scene) for picture in pictures)
    below = [picture[top + height :] for picture in pictures]
    assert np.array_equal(*below) and not np.array_equal(pictures[0][:top], pictures[1][:top])
    bar = below[0][round(0.4 * len(below[0])), round(0.25 * width) : round(0.75 * width)]
    assert bar[[0, -1]].tolist() == [[68, 1, 84], [253, 231, 37]]
