"""A film as a movie for any player, or as pictures: drawn by PyVista, encoded by FFmpeg."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import InputError
from ..colours import LARGEST_SHOWN_ANGLE, encoded
from ..files import replacing
from ..pictures.style import colour_map
from .captions import Captions, Scale
from .reading import FilmedField, FilmedMesh, StoredFilm

if TYPE_CHECKING:
    import pyvista

INSTALL = 'install it with: pip install "weavesim[film]"'
# Fields that are shown regardless of their sign, on the same scale in all movies.
_ANGLE = "shear_angle_deg"
# Shares of all values beyond which a scale does not reach: a few elements would take all of its colours.
_SCALE = (0.002, 0.998)
# Units that are shown as larger or smaller ones, with their factors.
_SHOWN = {"m": ("mm", 1.0e3), "degrees": ("°", 1.0), "1": ("", 1.0)}
_LARGEST_SIDE = 8192


@dataclass(frozen=True)
class Movie:
    """What to draw of a film.

    Attributes:
        field: of the elements, with or without the unit in its name: "thickness", "shear_angle".
        mirror: whether to draw the whole part.
        tools: whether to draw tools.
        back: whether to look at the other side.
        size: width and height [pixels].
        frames_per_second: of the movie.
        limits: of the scale, in the unit of the film; by default from all frames.

    Raises:
        InputError: a size or a rate that no movie has, or limits that are not.
    """

    field: str = "shear_angle"
    mirror: bool = True
    tools: bool = True
    back: bool = False
    size: tuple[int, int] = (1280, 720)
    frames_per_second: float = 24.0
    limits: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if min(self.size) < 64 or max(self.size) > _LARGEST_SIDE or any(side % 2 for side in self.size):
            raise InputError(
                f"size of the movie {self.size[0]} x {self.size[1]}: even numbers from 64 to {_LARGEST_SIDE} are needed"
            )
        if not 0.1 <= self.frames_per_second <= 240.0:
            raise InputError(f"frames per second {self.frames_per_second:g}: give a number from 0.1 to 240")
        if self.limits is not None and not self.limits[0] < self.limits[1]:
            raise InputError(f"range {self.limits[0]:g} {self.limits[1]:g}: the first number must be the smaller one")


def write_mp4(film: StoredFilm, movie: Movie, path: Path) -> None:
    """Draw every frame into a movie (H.264).

    Raises:
        InputError: an unknown field, or a package is missing.
    """
    try:
        import imageio_ffmpeg
    except ImportError:
        raise InputError(f"a movie needs imageio-ffmpeg, which is not here: {INSTALL}") from None
    pictures = drawn_frames(film, movie)
    with replacing(path) as temporary:
        writer = imageio_ffmpeg.write_frames(
            str(temporary), movie.size, fps=movie.frames_per_second, codec="libx264", quality=8, macro_block_size=2
        )
        writer.send(None)
        try:
            for picture in pictures:
                writer.send(np.ascontiguousarray(picture))
        finally:
            writer.close()


def write_pictures(film: StoredFilm, movie: Movie, folder: Path) -> list[Path]:
    """Draw every frame into a picture, ``frame_0000.png`` ...

    Raises:
        InputError: an unknown field, or a package is missing.
    """
    from PIL import Image

    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for index, picture in enumerate(drawn_frames(film, movie)):
        files.append(folder / f"frame_{index:04d}.png")
        with replacing(files[-1]) as temporary:
            Image.fromarray(picture).save(temporary)
    return files


def field_of(film: StoredFilm, name: str) -> FilmedField:
    """A field by its name, with or without the unit.

    Raises:
        InputError: there is no such field.
    """
    for found in film.fields.values():
        if name in (found.name, found.name.removesuffix("_deg")):
            return found
    raise InputError(f"field {name!r}: the film has {', '.join(film.fields)}")


def scale_of(film: StoredFilm, movie: Movie, field: FilmedField) -> Scale:
    """The scale in the unit of the film, with what it leaves out."""

    def parts() -> Iterator[np.ndarray]:
        for sheet in film.sheets:
            for frame in film.frames:
                if (values := film.values(sheet, field.name, frame)) is not None:
                    values = values[np.isfinite(values)]
                    yield np.abs(values) if field.name == _ANGLE else values

    if movie.limits is not None:
        return Scale.of(parts(), *movie.limits)
    if field.name == _ANGLE:
        return Scale.of(parts(), 0.0, LARGEST_SHOWN_ANGLE)
    every = list(parts())  # quantiles need all at once
    return Scale.of(every, *_usual(np.concatenate([np.empty(0), *every])))


def _usual(values: np.ndarray) -> tuple[float, float]:
    """Ends of a scale that leaves out the furthest values."""
    low, high = map(float, np.quantile(values, _SCALE)) if len(values) else (0.0, 1.0)
    margin = 0.0 if high - low > 1.0e-9 * max(abs(low), abs(high)) else max(1.0e-3 * abs(high), 1.0e-12)
    return low - margin, high + margin


def drawn_frames(film: StoredFilm, movie: Movie) -> Iterator[np.ndarray]:
    """The pictures of all frames, (height, width, 3) bytes.

    Raises:
        InputError: an unknown field, or PyVista is missing; before the first frame.
    """
    field = field_of(film, movie.field)
    try:
        import pyvista  # noqa: F401
    except ImportError:
        raise InputError(f"a movie needs PyVista, which is not here: {INSTALL}") from None
    return _draw(film, movie, field, scale_of(film, movie, field))


def _draw(film: StoredFilm, movie: Movie, field: FilmedField, scale: Scale) -> Iterator[np.ndarray]:
    import pyvista

    unit, factor = _SHOWN.get(field.unit, (field.unit, 1.0))
    shown = scale.in_unit(factor)
    captions = Captions(movie.size, _title(field, unit), shown, _side(film, movie))
    with _quiet():
        plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(captions.scene_size), lighting="light kit")
        plotter.set_background("white")
        limits = (shown.low, shown.high)
        updates = [_add_sheet(plotter, film, movie, sheet, field, factor, limits) for sheet in film.sheets]
        updates += [_add_tool(plotter, film, tool) for tool in film.tools if movie.tools]
        _look(plotter, film, movie, captions.scene_size)
        for place, frame in enumerate(film.frames):
            for update in updates:
                update(frame)
            plotter.render()
            scene = np.asarray(plotter.screenshot(return_img=True))[..., :3]
            yield captions.around(scene, _about(film, place))
        plotter.close()


def _about(film: StoredFilm, place: int) -> str:
    """Run, time and stroke of a frame."""
    words = [film.name.replace("_", " "), f"time {film.times[place]:.4g} s"]
    if np.ptp(film.strokes) > 0.0:
        words.append(f"stroke {1e3 * film.strokes[place]:.1f} mm")
    return ",  ".join(words)


def _side(film: StoredFilm, movie: Movie) -> str:
    """From where the part is seen; from below its z axis points down in the picture."""
    return "seen from below, turned over" if film.view(_camera(movie)).up[2] < 0.0 else "seen from above"


def _camera(movie: Movie) -> str:
    return "camera_back" if movie.back else "camera"


def _title(field: FilmedField, unit: str) -> str:
    name = field.name.removesuffix("_deg").replace("_", " ")
    name = f"absolute {name}" if field.name == _ANGLE else name
    return f"{name} [{'degrees' if unit == '°' else unit}]" if unit else name


def _add_sheet(
    plotter: Any,
    film: StoredFilm,
    movie: Movie,
    sheet: FilmedMesh,
    field: FilmedField,
    factor: float,
    limits: tuple[float, float],
) -> Callable[[float], None]:
    """Add a sheet to a scene; returns what shows it at a time code."""
    mirrors = sheet.mirrors if movie.mirror else sheet.mirrors[:1]

    def points(frame: float) -> np.ndarray:
        own = film.points(sheet, frame)
        return np.concatenate([own * mirror for mirror in mirrors])

    def values(frame: float) -> np.ndarray:
        own = film.values(sheet, field.name, frame)
        shown = np.full(len(film.faces(sheet, frame)), np.nan) if own is None else factor * own
        return np.tile(np.abs(shown) if field.name == _ANGLE else shown, len(mirrors))

    count = len(film.points(sheet, film.frames[0]))

    def faces(frame: float) -> np.ndarray:
        return np.concatenate([film.faces(sheet, frame) + k * count for k in range(len(mirrors))])

    trimmed = film.is_trimmed(sheet)
    mesh = _mesh(points(film.frames[0]), faces(film.frames[0]))
    mesh.cell_data["value"] = values(film.frames[0])
    plotter.add_mesh(
        mesh, scalars="value", cmap=colour_map(), clim=list(limits), nan_color="#c8ccd4",
        show_scalar_bar=False, ambient=0.25, diffuse=0.8, specular=0.05,
    )  # fmt: skip

    def show(frame: float) -> None:
        mesh.points = points(frame)
        if trimmed and mesh.n_cells != len(now := faces(frame)):
            mesh.faces = _with_counts(now)
        mesh.cell_data["value"] = values(frame)

    return show


def _add_tool(plotter: Any, film: StoredFilm, tool: FilmedMesh) -> Callable[[float], None]:
    """The same for a tool."""
    mesh = _mesh(film.points(tool, film.frames[0]), tool.faces)
    colour = encoded(np.array(tool.colour)).tolist()
    actor = plotter.add_mesh(mesh, color=colour, opacity=tool.opacity, specular=0.1, ambient=0.15)

    def show(frame: float) -> None:
        actor.SetVisibility(film.is_shown(tool, frame))
        mesh.points = film.points(tool, frame)

    return show


def _mesh(points: np.ndarray, faces: np.ndarray) -> pyvista.PolyData:
    import pyvista

    return pyvista.PolyData(points, _with_counts(faces))


def _with_counts(faces: np.ndarray) -> np.ndarray:
    """Faces as VTK has them: each with its number of corners before them, flat."""
    return np.insert(faces, 0, faces.shape[1], axis=1).ravel()


def _look(plotter: Any, film: StoredFilm, movie: Movie, size: tuple[int, int]) -> None:
    view = film.view(_camera(movie))
    camera = plotter.camera
    camera.position, camera.focal_point, camera.up = view.eye.tolist(), view.target.tolist(), view.up.tolist()
    # the width of the film's own format has to be seen in narrower pictures too
    narrow = max(1.0, 1.5 * size[1] / size[0])
    camera.view_angle = float(np.rad2deg(2.0 * np.arctan(narrow * np.tan(np.deg2rad(0.5 * view.angle)))))
    plotter.reset_camera_clipping_range()


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep VTK from telling that there is no display: it draws without one."""
    from vtkmodules.vtkCommonCore import vtkLogger

    before = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        yield
    finally:
        vtkLogger.SetStderrVerbosity(before)
