"""The folder of a run: film, ParaView series, tables, pictures, report and summary."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..measures.angles import shear_angle_at
from ..measures.border import draw_in, integrated_yarn_stretch
from ..measures.proximity import close_pairs
from ..measures.zigzag import checkerboard
from ..run.frame import Frame, Observer, Outcome, RunInfo
from . import pictures
from .curves import Curves
from .files import check_writable, plain, write_summary
from .film import Film
from .report.page import Report, shown, write_report
from .series import ParaViewSeries
from .tables import History, write_draw_in, write_shear_angles, write_table

logger = logging.getLogger(__name__)

_AXIS_NAMES = {"x": "long_axis", "y": "short_axis"}
# Yarns within this angle of a symmetry line count as lying along it [degrees].
_LARGEST_MISALIGNMENT = 1.0


class ResultFolder:
    """Observer of a run that leaves everything in one folder.

    During the run the film ``NAME.usdc`` and the series in ``paraview/`` grow; ``write`` adds the tables, pictures,
    ``report.html`` and ``summary.json``. A file that cannot be written, on a full disk for example, is given up with a
    warning, and the run goes on.

    Attributes:
        path: the folder; made if it is not there. Nothing in it is touched before the run starts.
        history: scalars of all frames, and the last frame.
        warnings: what could not be written, for the report.

    Args:
        path: the folder.
        points: material points for ``shear_angle.csv`` and its picture, (k, 2) [m]; None for neither.
        measured_angles: measured point numbers and angles [degrees] to draw beside the computed ones.
        measured_outline: a measured outline in plan (k, 2) [m] to draw beside the computed one.
        curves: the scene's own numbers of every frame, for a CSV and charts of their own.
        draw_in: whether the border's way inwards means something: its table, its picture, its entries of the summary.
        film, paraview: whether to write them.

    Raises:
        InputError: the folder cannot be written to, or angles were measured but no points are given.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        points: np.ndarray | None = None,
        measured_angles: tuple[np.ndarray, np.ndarray] | None = None,
        measured_outline: np.ndarray | None = None,
        curves: Curves | None = None,
        draw_in: bool = True,
        film: bool = True,
        paraview: bool = True,
    ) -> None:
        self.path = Path(path)
        self.history = History()
        self.warnings: list[str] = []
        self._points, self._measured_angles, self._measured_outline = points, measured_angles, measured_outline
        if measured_angles is not None:
            point_count = 0 if points is None else len(points)
            if max(measured_angles[0], default=0) > point_count:
                raise InputError(
                    f"measured angles: point {max(measured_angles[0])} is given, but the run has {point_count} points"
                )
        self._curves = curves
        self._with_draw_in = draw_in
        self._with_film, self._with_paraview = film, paraview
        self._streams: dict[str, Observer] = {}
        self._outcome: Outcome | None = None
        check_writable(self.path)
        if film:
            Film.load()

    # ------------------------------------------------------------------------------------------------ during a run

    def start(self, info: RunInfo) -> None:
        self._info = info
        self.warnings.clear()
        self.history.start(info)
        if self._curves:
            self._curves.start(info)
        self._streams = {}
        if self._with_film:
            self._streams["film"] = Film(self.path / f"{info.name}.usdc")
        if self._with_paraview:
            self._streams["ParaView series"] = ParaViewSeries(self.path / "paraview")
        self._tell_streams(lambda stream: stream.start(info))

    def frame(self, frame: Frame) -> None:
        self.history.frame(frame)
        if self._curves:
            self._curves.frame(frame)
        self._tell_streams(lambda stream: stream.frame(frame))

    def finish(self, outcome: Outcome) -> None:
        self._outcome = outcome
        self._tell_streams(lambda stream: stream.finish(outcome))

    def _tell_streams(self, message: Callable[[Observer], None]) -> None:
        for name, stream in list(self._streams.items()):
            if not self._attempt(name, partial(message, stream)):
                del self._streams[name]
                if isinstance(stream, Film):
                    with contextlib.suppress(OSError):
                        stream.discard()

    def _attempt(self, what: str, action: Callable[[], object]) -> bool:
        """Whether ``action`` could write what it should; if not, that is said once."""
        try:
            action()
        except OSError as error:
            text = f"{what} could not be written and is given up: {error.strerror or error}"
            self.warnings.append(text)
            logger.warning("%s", text)
            return False
        return True

    # ------------------------------------------------------------------------------------------------- after a run

    def write(self, summary: Mapping[str, Any], *, setup: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """Write tables, pictures, report and summary of the run so far.

        Args:
            summary: numbers of the run; an entry here goes before one of the same name found here.
            setup: more to say in the report about what was run, by name.

        Returns:
            The whole summary, as written.

        Raises:
            InputError: no run was started.
        """
        frame = self.history.last_frame
        if frame is None:
            raise InputError("results: there is no frame to write; run the simulation with this folder as an observer")
        sheet, blank = self._info.sheet, self._info.sheet.blank
        summary = {**self._measures(frame), **summary}
        angle, symmetry = frame.fields["shear_angle"], sheet.symmetry
        self._attempt("history.csv", lambda: self.history.write(self.path / "history.csv"))
        if self._with_draw_in:
            path = self.path / "draw_in.csv"
            self._attempt("draw_in.csv", lambda: write_draw_in(path, blank, frame.position, symmetry))
        if (points := self._points) is not None:
            path = self.path / "shear_angle.csv"
            self._attempt("shear_angle.csv", lambda: write_shear_angles(path, blank, angle, points, symmetry))
        if (curves := self._curves) is not None:
            columns, path = curves.columns, self.path / f"{curves.name}.csv"
            rows = zip(*(values.tolist() for values in columns.values()), strict=True)
            self._attempt(path.name, lambda: write_table(path, list(columns), rows))
        shown_pictures = self._write_pictures(frame)
        summary["warnings"] = [*map(str, summary.get("warnings") or ()), *self.warnings]
        report = self._report(summary, setup or {}, shown_pictures)
        if not self._attempt("report.html", lambda: write_report(self.path / "report.html", report)):
            summary["warnings"].append(self.warnings[-1])
        self._attempt("summary.json", lambda: write_summary(self.path / "summary.json", summary))
        return plain(summary)

    def _measures(self, frame: Frame) -> dict[str, Any]:
        sheet, blank = self._info.sheet, self._info.sheet.blank
        angle, symmetry = frame.fields["shear_angle"], sheet.symmetry
        stretches = {"warp": frame.fields["warp_stretch"], "weft": frame.fields["weft_stretch"]}
        both = np.concatenate(list(stretches.values()))
        zigzag = checkerboard(blank, angle)
        found: dict[str, Any] = {
            "outcome": self._outcome.value if self._outcome else "running",
            "frame_count": self.history.frame_count,
            "max_shear_angle_deg": float(np.rad2deg(np.abs(angle).max())),
            "min_stretch": float(both.min()),
            "max_stretch": float(both.max()),
            "checkerboard_rms_deg": zigzag.rms,
            "checkerboard_max_deg": zigzag.maximum,
            "close_pair_count": close_pairs(frame.position, blank.quads, 0.5 * sheet.fabric.thickness),
        }
        if self._points is not None:
            found["shear_angle_points_deg"] = shear_angle_at(blank, angle, self._points, symmetry).tolist()
        thickness, fraction = (frame.fields.get(name) for name in ("thickness", "fibre_volume_fraction"))
        if thickness is not None:
            found["min_thickness_mm"] = 1.0e3 * float(thickness.min())
            found["max_thickness_mm"] = 1.0e3 * float(thickness.max())
        if fraction is not None:
            found["min_fibre_volume_fraction"] = float(fraction.min())
            found["max_fibre_volume_fraction"] = float(fraction.max())
        for along, name in _AXIS_NAMES.items() if self._with_draw_in else ():
            with contextlib.suppress(InputError):  # the blank need not lie over the origin
                found[f"draw_in_{name}_mm"] = 1.0e3 * draw_in(blank, frame.position, along)
                for direction, stretch in zip(
                    (blank.warp_direction, blank.weft_direction), stretches.values(), strict=True
                ):
                    component = np.abs(direction[:, "xy".index(along)])
                    if component.min() > np.cos(np.deg2rad(_LARGEST_MISALIGNMENT)):
                        found[f"integrated_yarn_stretch_{name}_mm"] = 1.0e3 * integrated_yarn_stretch(
                            blank, stretch, along
                        )
        return found

    def _write_pictures(self, frame: Frame) -> list[tuple[Path, str]]:
        sheet, blank, history = self._info.sheet, self._info.sheet.blank, self.history
        tools, symmetry = self._info.tools, sheet.symmetry
        wanted: list[tuple[str, str, Callable[[], Any]]] = [
            (
                "formed_sheet.png",
                "The formed sheet at the last frame. Each element has the colour of its own shear angle, without "
                "smoothing; the lines follow the yarns.",
                lambda: pictures.formed_sheet(blank, frame, symmetry),
            )
        ]
        if self._curves is not None:
            columns = self._curves.columns
            wanted += [
                (f"{chart.name}.png", chart.caption, partial(pictures.chart_of, chart, columns))
                for chart in self._curves.charts
            ]
        if (points := self._points) is not None:
            wanted.append(
                (
                    "point_angles.png",
                    "Shear angles at the material points: signed element values averaged to the nodes by area, "
                    "mirrored elements included, then interpolated bilinearly; absolute values are shown.",
                    lambda: pictures.point_angles(blank, frame, points, symmetry, self._measured_angles),
                )
            )
        if self._meets_both_axes():
            if self._with_draw_in:
                wanted.append(
                    (
                        "draw_in.png",
                        "Draw-in: the outline before and after, and the plan movement of the border against its flat "
                        "normal.",
                        lambda: pictures.draw_in_picture(blank, frame, symmetry, self._measured_outline),
                    )
                )
            wanted.append(
                (
                    "sections.png",
                    "Sections along the symmetry lines, sheet drawn in its thickness.",
                    lambda: pictures.sections(blank, frame, tools, sheet.fabric.thickness, symmetry),
                )
            )
        if tools:
            wanted.append(
                (
                    "tool_forces.png",
                    "Force between sheet and each tool, along the tool's axis.",
                    lambda: pictures.tool_forces(history, tools, symmetry),
                )
            )
        if history.drive_names:
            wanted.append(
                (
                    "drive_forces.png",
                    "Force of the supports on the sheet along each prescribed motion: work per unit of its "
                    "displacement.",
                    lambda: pictures.drive_forces(history),
                )
            )
        wanted.append(
            (
                "energies.png",
                "Energies of the ledger: the stack of stored and lost energies against the supplied work, each by "
                "itself, and the ratios by which a quasi-static run is judged.",
                lambda: pictures.energies(history),
            )
        )
        folder = self.path / "pictures"
        if not self._attempt("pictures", lambda: folder.mkdir(exist_ok=True)):
            return []
        return [
            (folder / name, caption)
            for name, caption, draw in wanted
            if self._attempt(name, partial(_draw_and_write, draw, folder / name))
        ]

    def _meets_both_axes(self) -> bool:
        lower, upper = (f(self._info.sheet.blank.material_coordinates, axis=0) for f in (np.min, np.max))
        return bool(np.all(lower <= 0.0) and np.all(upper >= 0.0))

    def _report(
        self, summary: Mapping[str, Any], setup: Mapping[str, Any], shown_pictures: Sequence[tuple[Path, str]]
    ) -> Report:
        info, sheet = self._info, self._info.sheet
        title = info.name.replace("_", " ").capitalize()
        share = {1.0: "whole blank", 0.5: "half of the blank", 0.25: "quarter of the blank"}[sheet.symmetry.share]
        headline = [
            (label, f"{shown(float(summary[name]))}{unit}")
            for name, label, unit in (
                ("max_shear_angle_deg", "largest shear angle", "°"),
                ("draw_in_long_axis_mm", "draw-in, long axis", " mm"),
                ("draw_in_short_axis_mm", "draw-in, short axis", " mm"),
                ("min_stretch", "smallest yarn stretch", ""),
                ("max_stretch", "largest yarn stretch", ""),
                ("wall_time_s", "wall time", " s"),
            )
            if isinstance(summary.get(name), int | float)
        ]
        tools = {
            tool.name: ", ".join(str(part) for part in (tool.shape, tool.motion, f"friction {tool.friction:g}"))
            for tool in info.tools
        }
        fabric = sheet.fabric.model_dump()
        fabric |= {"areal density [kg/m²]": sheet.fabric.areal_density}
        fabric |= {"thickness [mm]": 1.0e3 * sheet.fabric.thickness}
        fabric = {name: value for name, value in fabric.items() if name not in ("areal_density", "thickness")}
        left_out = {"warnings", "energies_j"} | {name for name in ("notes",) if not summary.get(name)}
        numbers = {name: value for name, value in summary.items() if name not in left_out}
        tables: dict[str, Mapping[str, Any]] = {"Summary": numbers}
        if setup:
            tables["Set-up"] = dict(setup)
        supports = {
            support.name: f"{len(support.nodes)} nodes with {len(support.drives)} drives, holds displacements "
            f"{support.displacements or 'none'} and rotations {support.rotations or 'none'}"
            for support in info.supports
        }
        tables |= {"Fabric": fabric, "Tools": tools, "Supports": supports}
        if isinstance(summary.get("energies_j"), Mapping):
            tables["Energies at the end"] = {f"{name}_j": value for name, value in summary["energies_j"].items()}
        outcome = summary.get("outcome")
        subtitle = (
            f"{sheet.fabric.name} · {share} · {info.element_count} elements · "
            f"{info.precision} on {info.device} · run {outcome}"
        )
        warnings = list(summary["warnings"])
        if outcome != Outcome.FINISHED.value:
            warnings.insert(0, f"The run did not reach its end ({outcome}): what follows is its last good frame.")
        return Report(title, subtitle, headline, warnings, shown_pictures, {k: v for k, v in tables.items() if v})


def _draw_and_write(draw: Callable[[], Any], path: Path) -> None:
    pictures.write_picture(draw(), path)
