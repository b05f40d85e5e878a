"""What is written above and below a picture of a movie: run, time, stroke, side, and the scale of the colours.

It is drawn into strips of its own, at the same places in every frame, where it covers nothing of the scene.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..colours import colour_table, encoded
from ..pictures.style import INK

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont

# Heights over that of the picture.
_TOP, _BOTTOM = 0.05, 0.15
_TEXT, _NOTE = 1.0 / 40.0, 1.0 / 48.0
# Of the bar, over the width.
_LEFT, _RIGHT = 0.25, 0.75
_TICK_COUNT = 5


@dataclass(frozen=True)
class Scale:
    """The colours of a movie, in the unit of the film.

    Attributes:
        low, high: ends of the scale.
        smallest, largest: of all values in all frames; not a number if there are none.
        beyond: share of the values that lie beyond an end.
    """

    low: float
    high: float
    smallest: float
    largest: float
    beyond: float

    @classmethod
    def of(cls, values: Iterable[np.ndarray], low: float, high: float) -> Scale:
        """A scale from ``low`` to ``high`` of values that are numbers, (k,) arrays one after the other."""
        count, beyond, smallest, largest = 0, 0, np.inf, -np.inf
        for part in values:
            if len(part):
                count, beyond = count + len(part), beyond + int(np.sum((part < low) | (part > high)))
                smallest, largest = min(smallest, float(part.min())), max(largest, float(part.max()))
        if not count:
            return cls(low, high, float("nan"), float("nan"), 0.0)
        return cls(low, high, smallest, largest, beyond / count)

    def in_unit(self, factor: float) -> Scale:
        """The same in another unit."""
        low, high, smallest, largest = (factor * each for each in (self.low, self.high, self.smallest, self.largest))
        return Scale(low, high, smallest, largest, self.beyond)

    def note(self) -> str:
        """What the ends do not tell."""
        if not np.isfinite(self.largest):
            return "no values"
        text = f"all frames: smallest {self.smallest:.4g}, largest {self.largest:.4g}"
        if not self.beyond:
            return text
        share = "less than 0.01" if self.beyond < 1.0e-4 else f"{100.0 * self.beyond:.2g}"
        return f"{text}; {share} % of the values lie beyond the ends and have their colours"


@dataclass(frozen=True)
class Captions:
    """Strips above and below the scene.

    Attributes:
        size: width and height of the whole picture [pixels].
        title: of the scale, with its unit.
        scale: in that unit.
        side: from where the part is seen; "" says nothing.
    """

    size: tuple[int, int]
    title: str
    scale: Scale
    side: str = ""

    @property
    def scene_size(self) -> tuple[int, int]:
        """Width and height that are left for the scene [pixels]."""
        return self.size[0], self.size[1] - self._top - self._bottom

    @property
    def _top(self) -> int:
        return round(_TOP * self.size[1])

    @property
    def _bottom(self) -> int:
        return round(_BOTTOM * self.size[1])

    def around(self, scene: np.ndarray, about: str) -> np.ndarray:
        """The picture of a frame, (height, width, 3) bytes.

        Args:
            scene: as large as ``scene_size``.
            about: the frame.
        """
        return np.concatenate([self._head(about), scene, self._scale_strip])

    def _head(self, about: str) -> np.ndarray:
        canvas, draw = _strip(self.size[0], self._top)
        font, edge = _font(self.size[1] * _TEXT), self._top / 3.0
        draw.text((edge, 0.5 * self._top), about, INK, font, anchor="lm")
        draw.text((self.size[0] - edge, 0.5 * self._top), self.side, INK, font, anchor="rm")
        return np.asarray(canvas)

    @cached_property
    def _scale_strip(self) -> np.ndarray:
        width, height = self.size[0], self._bottom
        canvas, draw = _strip(width, height)
        left, right = round(_LEFT * width), round(_RIGHT * width)
        low, high = round(0.32 * height), round(0.48 * height)
        places = np.linspace(0, 255, right - left).round().astype(int)
        bar = np.rint(255.0 * encoded(colour_table())).astype(np.uint8)[places]
        pixels = np.array(canvas)
        pixels[low:high, left:right] = bar
        canvas, draw = _strip(width, height, pixels)
        text, note = _font(self.size[1] * _TEXT), _font(self.size[1] * _NOTE)
        draw.text((0.5 * (left + right), 0.15 * height), self.title, INK, text, anchor="mm")
        for value, x in zip(
            np.linspace(self.scale.low, self.scale.high, _TICK_COUNT),
            np.linspace(left, right, _TICK_COUNT),
            strict=True,
        ):
            draw.line([(x, high), (x, high + 0.04 * height)], INK)
            draw.text((x, 0.63 * height), f"{value:.4g}", INK, note, anchor="mm")
        draw.text((0.5 * (left + right), 0.85 * height), self.scale.note(), INK, note, anchor="mm")
        return np.asarray(canvas)


def _strip(width: int, height: int, pixels: np.ndarray | None = None) -> tuple[Any, Any]:
    from PIL import Image, ImageDraw

    canvas = Image.new("RGB", (width, height), "white") if pixels is None else Image.fromarray(pixels)
    return canvas, ImageDraw.Draw(canvas)


@cache
def _font(size: float) -> FreeTypeFont:
    """The font of the other pictures, as high as wanted [pixels]."""
    from matplotlib import get_data_path
    from PIL import ImageFont

    return ImageFont.truetype(str(Path(get_data_path(), "fonts", "ttf", "DejaVuSans.ttf")), size)
