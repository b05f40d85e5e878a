"""The film, for usdview, Omniverse, Blender or Houdini."""

from __future__ import annotations

from ...run.frame import Frame, Outcome, RunInfo
from ..film.film import Film
from ..writer import Writer


class FilmWriter(Writer):
    """``NAME.usdc``: a film of sheets and tools for usdview, Blender and others (``weavesim.output.Film``)."""

    name = "film"
    title = "film"
    packages = ("pxr", "matplotlib", "mapbox_earcut")
    needs_load = True

    @classmethod
    def load(cls) -> None:
        """Import USD."""
        Film.load()

    def start(self, info: RunInfo) -> None:
        """Begin the film."""
        self.folder.stat()  # USD would make a folder that is gone
        self._film = Film(self.folder / f"{info.name}.usdc")
        self._film.start(info)

    def frame(self, frame: Frame) -> None:
        """Add a frame."""
        self._film.frame(frame)

    def finish(self, outcome: Outcome) -> None:
        """Move the film to its final name."""
        self._film.finish(outcome)

    def discard(self) -> None:
        """Keep only what was saved under the name of the film."""
        self._film.discard()
