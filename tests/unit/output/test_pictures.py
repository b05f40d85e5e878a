"""Pictures show what the run holds: read back from the drawn artists."""

import dataclasses

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.image import imread

from tests.support.made_run import formed
from weavesim.measures.angles import shear_angle_at, ten_points
from weavesim.measures.border import draw_in
from weavesim.measures.findings import FormedSheet
from weavesim.output import History, pictures
from weavesim.output.colours import LARGEST_SHOWN_ANGLE, colour_table, encoded, shear_colours
from weavesim.output.pictures.sheet import yarn_lines
from weavesim.sheet.blank import Blank
from weavesim.sheet.symmetry import WHOLE


def placed_tools(info, frame):
    return [(t.name, t, distance) for t, distance in zip(info.tools, frame.tool_displacement, strict=True)]


@pytest.fixture
def history(coarse_run):
    result = History()
    result.start(coarse_run[0])
    for frame in coarse_run[1]:
        result.frame(frame)
    return result


def test_colours_rise_in_lightness_and_ignore_the_sign():
    luminance = colour_table() @ (0.2126, 0.7152, 0.0722)
    assert np.all(np.diff(luminance) > 0.0)
    table = encoded(colour_table())
    assert table.min() >= 0.0 and table.max() <= 1.0
    step = np.linalg.norm(np.diff(table, axis=0), axis=1)
    assert step.max() < 0.02  # no jumps
    angles = np.array([0.0, 13.0, LARGEST_SHOWN_ANGLE, 200.0])
    assert np.array_equal(shear_colours(angles), shear_colours(-angles))
    assert np.array_equal(shear_colours(angles)[2], shear_colours(angles)[3])


def test_formed_sheet_shows_every_element_of_the_whole_part(coarse_run):
    info, frames = coarse_run
    figure = pictures.formed_sheet(formed(info, frames[-1]))
    plan = next(axes for axes in figure.axes if axes.get_title(loc="left") == "From above")
    (collection,) = [artist for artist in plan.collections if isinstance(artist, PolyCollection)]
    filled = np.asarray(collection.get_facecolor())[:, 3] > 0.0
    assert filled.sum() == 4 * info.sheet.blank.element_count
    drawn = np.concatenate([path.vertices for path in collection.get_paths()])
    reach = 1e3 * np.abs(frames[-1].position[:, :2]).max(axis=0)
    assert drawn.max(axis=0) == pytest.approx(reach) and drawn.min(axis=0) == pytest.approx(-reach)
    assert "turned over" in figure.axes[0].get_title(loc="left")


@pytest.mark.parametrize("yarn_angle", [0.0, 30.0])
def test_yarn_lines_lie_at_even_distances_along_the_yarns(yarn_angle):
    blank = Blank.rectangle((-0.2, -0.1), (0.2, 0.1), 0.011, yarn_angle=yarn_angle, distortion=0.2)
    spacing, lines = yarn_lines(blank, WHOLE)
    ends = lines.of(blank.material_coordinates).reshape(-1, 2, 2)
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    warp, weft = blank.warp_direction[0, :2], blank.weft_direction[0, :2]
    on_warp = np.abs(along @ warp) > np.abs(along @ weft)
    across = np.where(on_warp, np.abs(along @ weft), np.abs(along @ warp))
    assert across.max() < 1e-12
    place = np.where(on_warp, ends[:, 0] @ weft, ends[:, 0] @ warp) / spacing
    assert np.abs(place - 0.5 - np.round(place - 0.5)).max() < 1e-9
    # Together they are as long as lines at that distance must be on this area.
    assert length.sum() == pytest.approx(2 * 0.4 * 0.2 / spacing, rel=0.05)


def test_yarns_that_turn_get_strokes():
    blank = Blank.rectangle((0.0, 0.0), (0.2, 0.2), 0.02)
    x, y = blank.element_centres()[:, 0], blank.element_centres()[:, 1]
    direction = np.stack([np.cos(3 * x + y), np.sin(3 * x + y), 0 * x], axis=1)
    blank = Blank.from_mesh(blank.node_position, blank.quads, warp_direction=direction)
    spacing, lines = yarn_lines(blank, WHOLE)
    ends = lines.of(blank.material_coordinates).reshape(-1, 2, 2)
    assert spacing == 0.0 and len(ends) == 2 * blank.element_count
    along = ends[: blank.element_count, 1] - ends[: blank.element_count, 0]
    cross = along[:, 0] * direction[:, 1] - along[:, 1] * direction[:, 0]
    assert np.abs(cross).max() < 1e-12


def test_draw_in_names_both_numbers_and_the_measured_outline(coarse_run):
    info, frames = coarse_run
    measured = np.array([[0.2, 0.0], [0.19, 0.05]])
    blank, frame = info.sheet.blank, frames[-1]
    figure = pictures.draw_in_picture(formed(info, frame), measured)
    texts = [text.get_text() for text in figure.axes[0].texts]
    for along in "xy":
        assert f"{1e3 * draw_in(blank, frame.position, along):.1f} mm" in texts
    labels = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert labels == ["flat", "formed", "measured"]
    without = pictures.draw_in_picture(formed(info, frame))
    assert "measured" not in [text.get_text() for text in without.axes[0].get_legend().get_texts()]


def test_the_draw_in_of_a_closed_outline_is_interrupted_at_all_corners():
    """Also at the one that it starts at, where it ends too."""
    blank = Blank.rectangle((-0.1, -0.1), (0.1, 0.1), 0.02)
    sheet = FormedSheet(blank, blank.node_position * (0.9, 0.8, 1.0), {}, 0.001, WHOLE)
    assert sheet.border.closed
    chart = pictures.draw_in_picture(sheet).axes[1]
    curve, zero, *corners = chart.lines
    assert [line.get_xdata()[0] for line in corners] == pytest.approx([0.0, 200.0, 400.0, 600.0, 800.0])
    length, values = curve.get_data()
    broken = np.isnan(values)
    assert length[broken] == pytest.approx([0.0, 200.0, 400.0, 600.0, 800.0])
    sides = [side for side in np.split(values, np.flatnonzero(broken)) if len(side) > 1]
    assert [np.nanmax(side) - np.nanmin(side) for side in sides] == pytest.approx([0.0] * 4, abs=1e-9)
    assert sorted({round(float(np.nanmax(side))) for side in sides}) == [10, 20]


def test_the_legend_of_the_draw_in_lies_on_no_line(coarse_run, tmp_path):
    info, frames = coarse_run
    figure = pictures.draw_in_picture(formed(info, frames[-1]))
    pictures.write_picture(figure, tmp_path / "draw_in.png")
    chart = figure.axes[1]
    renderer = figure.canvas.get_renderer()
    assert chart.get_legend().get_window_extent(renderer).y1 < chart.get_window_extent(renderer).y0


def test_point_angles_are_the_sampled_ones(coarse_run):
    info, frames = coarse_run
    points = ten_points(0.235, 0.135)
    blank, frame = info.sheet.blank, frames[-1]
    figure = pictures.point_angles(formed(info, frame, points), (np.array([2, 4]), np.array([5.0, 33.0])))
    heights = [bar.get_height() for bar in figure.axes[0].patches]
    expected = shear_angle_at(blank, frame.fields["shear_angle"], points, info.sheet.symmetry)
    assert heights == pytest.approx(expected)
    (measured,) = [line for line in figure.axes[0].lines if line.get_label() == "measured"]
    assert measured.get_xydata().tolist() == [[2.0, 5.0], [4.0, 33.0]]
    assert figure.axes[0].get_ylim()[1] > 33.0
    assert not [line for line in pictures.point_angles(formed(info, frame, points)).axes[0].lines]
    scale = figure.axes[2]
    assert scale.get_xlim() == (0.0, LARGEST_SHOWN_ANGLE) and "degrees" in scale.get_xlabel()


def test_tool_forces_are_along_the_axes_and_of_the_whole_part(history, coarse_run):
    info, frames = coarse_run
    figure = pictures.tool_forces(history, info)
    (axes,) = figure.axes
    assert "whole part" in axes.get_title(loc="left")
    assert [line.get_label() for line in axes.lines] == ["punch", "die", "blank holder"]
    assert axes.lines[0].get_ydata() == pytest.approx([4.0 * abs(frame.tool_reaction[0, 2]) for frame in frames])
    assert axes.lines[0].get_xdata()[-1] == pytest.approx(60.0)


def test_energies_stack_up_to_the_supplied_work(history, coarse_run):
    figure = pictures.energies(history, coarse_run[0])
    stack, every, ratios = figure.axes
    assert "whole part" in stack.get_title(loc="left") and "ratio" in ratios.get_ylabel()
    top = max(path.vertices[:, 1].max() for area in stack.collections for path in area.get_paths())
    last = coarse_run[1][-1].energies
    assert top == pytest.approx(4.0 * last["used"], rel=0.01)
    names = [text.get_text() for text in every.get_legend().get_texts()]
    assert "hourglass" in names and "internal" not in names and "snap loss" not in names
    by_name = {line.get_label(): line.get_ydata()[-1] for line in ratios.lines}
    assert by_name["kinetic over internal energy"] == pytest.approx(100 * last["kinetic"] / last["internal"])
    assert by_name["balance error over supplied work"] == pytest.approx(100 * 0.03 / last["supplied"])
    drawn = np.concatenate([line.get_ydata() for line in ratios.lines])
    low, high = ratios.get_ylim()
    assert low <= np.nanmin(drawn) and np.nanmax(drawn) <= high < 10.0 * np.nanmax(drawn)


def test_energies_of_sheets_cut_differently_are_of_what_was_computed(history, coarse_run):
    info, frames = coarse_run
    other = dataclasses.replace(info.sheet, name="other", symmetry=WHOLE)
    both = dataclasses.replace(info, sheets=(info.sheet, other))
    stack = pictures.energies(history, both).axes[0]
    assert "computed parts" in stack.get_title(loc="left")
    top = max(path.vertices[:, 1].max() for area in stack.collections for path in area.get_paths())
    assert top == pytest.approx(frames[-1].energies["used"], rel=0.01)


def test_sections_follow_the_sheet_and_move_the_tools(coarse_run):
    info, frames = coarse_run
    frame = frames[-1]
    figure = pictures.sections(formed(info, frame), placed_tools(info, frame))
    long, short = figure.axes
    sheet = next(patch for patch in long.patches if patch.get_label() == "sheet").get_xy()
    assert sheet[:, 1].min() == pytest.approx(1e3 * frame.position[:, 2].min() - 0.6, abs=0.01)
    punch = next(artist for artist in short.collections if artist.get_label() == "punch")
    lowest = min(path.vertices[:, 1].min() for path in punch.get_paths())
    assert lowest == pytest.approx(-60.0 + 0.6, abs=0.5)


def test_sections_show_all_of_a_sheet_that_outgrew_its_blank(coarse_run):
    info, frames = coarse_run
    sheet = formed(info, frames[-1])
    pulled = dataclasses.replace(sheet, position=sheet.position * (1.3, 1.3, 1.0))
    for axes in pictures.sections(pulled, ()).axes:
        drawn = np.concatenate([patch.get_xy() for patch in axes.patches])[:, 0]
        low, high = axes.get_xlim()
        assert low < drawn.min() and drawn.max() < high


def test_sections_of_several_sheets_are_drawn_in_their_colours(coarse_run):
    info, frames = coarse_run
    lower = formed(info, frames[-1])
    upper = dataclasses.replace(lower, position=lower.position + (0.0, 0.0, 0.002))
    figure = pictures.sections([("ply_1", lower), ("ply_2", upper)], placed_tools(info, frames[-1]))
    for chart in figure.axes:
        own = {patch.get_label(): patch for patch in chart.patches if "ply" in str(patch.get_label())}
        assert list(own) == ["ply 1", "ply 2"]
        assert own["ply 1"].get_facecolor() != own["ply 2"].get_facecolor()
        heights = [patch.get_xy()[:, 1].max() for patch in own.values()]
        assert np.diff(heights) == pytest.approx(2.0)


def test_a_stack_is_drawn_apart_and_as_it_lies(coarse_run):
    info, frames = coarse_run
    lower = formed(info, frames[-1])
    upper = dataclasses.replace(lower, position=lower.position + (0.0, 0.0, 0.002))
    figure = pictures.stack_picture([("ply_1", lower), ("ply_2", upper)])
    apart, together = figure.axes[:2]
    count = 4 * lower.blank.element_count
    assert len(together.collections[0].get_paths()) == 2 * count < len(apart.collections[0].get_paths())
    assert [text.get_text() for text in together.get_legend().get_texts()] == ["ply 2", "ply 1"]
    gap = 0.25 * 470.0 * np.cos(np.radians(30.0))  # seen from 30 degrees above
    assert np.ptp(apart.get_ylim()) > np.ptp(together.get_ylim()) + 0.8 * gap
    shades = np.unique(np.round(together.collections[0].get_facecolors(), 6), axis=0)
    assert len(shades) > 10  # two colours, each lit


def test_the_force_that_a_tool_should_carry_is_drawn_beside_what_it_carries(coarse_run):
    info, frames = coarse_run
    wanted = [160.0 * min(1.0, frame.index / 3.0) for frame in frames]
    history = History()
    history.start(info)
    for frame, force in zip(frames, wanted, strict=True):
        # strokes are wanted no force
        history.frame(dataclasses.replace(frame, tool_wanted=np.array([np.nan, np.nan, force])))
    (chart,) = pictures.tool_forces(history, info).axes
    lines = {line.get_label(): line for line in chart.lines}
    assert set(lines) == {"punch", "die", "blank holder", "blank holder, wanted"}
    carried, dashed = lines["blank holder"], lines["blank holder, wanted"]
    assert dashed.get_ydata() == pytest.approx(4.0 * np.array(wanted))  # of the whole part
    assert carried.get_ydata() == pytest.approx(np.full(len(frames), 4.0 * 160.0))
    assert dashed.get_linestyle() == "--" and carried.get_linestyle() == "-"
    assert dashed.get_color() == carried.get_color()
    legend = {text.get_text() for text in chart.get_legend().get_texts()}
    assert {"blank holder", "blank holder, wanted"} <= legend


def test_a_run_at_rest_can_be_drawn(tmp_path, coarse_run):
    """One flat frame without any energy, as an interrupted run may leave."""
    info, frames = coarse_run
    frame = frames[0]
    history = History()
    history.start(info)
    history.frame(frame)
    for i, figure in enumerate(
        (
            pictures.formed_sheet(formed(info, frame)),
            pictures.draw_in_picture(formed(info, frame)),
            pictures.point_angles(formed(info, frame, ten_points(0.235, 0.135))),
            pictures.tool_forces(history, info),
            pictures.energies(history, info),
            pictures.sections(formed(info, frame), placed_tools(info, frame)),
        )
    ):
        path = tmp_path / f"{i}.png"
        pictures.write_picture(figure, path)
        assert np.ptp(imread(path)[..., :3]) > 0.5


def test_a_run_is_drawn_before_it_starts(tmp_path):
    from tests.support.jobs import write_tray
    from weavesim.job.build import setup_of
    from weavesim.job.read import read_job
    from weavesim.output.pictures.before import before_run

    figure = before_run(setup_of(read_job(write_tray(tmp_path))))
    titles = [axes.get_title(loc="left") or axes.get_title() for axes in figure.axes]
    assert titles[:2] == ["At the start, cut along x (y = 0 mm)", "At the start, cut along y (x = 0 mm)"]
    assert [title.split(":")[0] for title in titles[2:]] == ["die", "punch", "ring"]
    drawn = figure.axes[2].collections[0]
    # the entry radius of the die is too small for elements of 10 mm, its rim is not
    assert len({tuple(colour) for colour in drawn.get_facecolors()}) > 1


def test_faults_of_a_tool_are_drawn_before_a_run(tmp_path, monkeypatch):
    from tests.support.jobs import tray_surface, write_stl, write_tray
    from weavesim.job.build import setup_of
    from weavesim.job.read import read_job
    from weavesim.output.pictures import before

    path = write_tray(tmp_path)
    vertices, faces = tray_surface()
    middle = vertices[faces].mean(axis=1)[:, :2]
    turned = np.linalg.norm(middle - (-69.0, -49.0), axis=1) < 12.0
    faces[turned] = faces[turned][:, ::-1]
    write_stl(tmp_path / "die.stl", vertices, faces[np.linalg.norm(middle - (70.0, 50.0), axis=1) > 2.5])
    setup = setup_of(read_job(path))
    wrong = np.array([[0.01, 0.02, -0.025]])

    class Sampled:
        worst_points, worst_errors = np.concatenate([wrong, wrong + 0.01]), np.array([2e-4, 1e-5])

    monkeypatch.setattr(before, "sampled_distance", lambda *_: Sampled)
    for with_errors in (False, True):
        figure = before.before_run(setup, with_errors=with_errors)
        labels = {text.get_text() for legend in figure.legends for text in legend.get_texts()}
        assert {"faced the other way, turned", "hole in the surface"} <= labels
        assert ("distance is wrong" in labels) == with_errors
    die = figure.axes[2]
    rings = [line.get_xydata()[0] for line in die.lines if line.get_marker() == "o"]
    assert len(rings) == 1 and np.hypot(*(rings[0] - (70.0, 50.0))) < 3.0
    (crosses,) = [line.get_xydata() for line in die.lines if line.get_marker() == "x"]
    # only where the error is more than is trusted
    assert crosses == pytest.approx(np.array([[10.0, 20.0]]))
