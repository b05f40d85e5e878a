"""PNG files have the pixels, the size and the texts that they were given."""

import io

import numpy as np
import pytest
from PIL import Image

from weavesim.output.drawing.png import png_of


@pytest.mark.parametrize("channel_count", [3, 4])
def test_others_read_what_was_written(channel_count):
    pixels = np.random.default_rng(3).integers(0, 256, (37, 53, channel_count), dtype=np.uint8)
    with Image.open(io.BytesIO(png_of(pixels, 150.0, {"weavesim run": "run 5", "Software": "weavesim"}))) as picture:
        assert picture.mode == "RGB"
        assert np.array_equal(np.asarray(picture), pixels[:, :, :3])
        assert picture.info["dpi"] == pytest.approx((150.0, 150.0), rel=1e-3)
        assert (picture.info["weavesim run"], picture.info["Software"]) == ("run 5", "weavesim")


def test_an_even_picture_takes_a_hundredth_of_its_bytes():
    assert len(png_of(np.full((1000, 1000, 3), 255, dtype=np.uint8), 150.0)) < 30_000
