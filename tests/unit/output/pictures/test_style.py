"""Texts stay within pictures, whatever the shape of a part."""

import dataclasses

import numpy as np
import pytest
from matplotlib.image import imread
from matplotlib.patheffects import Stroke

from tests.support.bowls import bowl
from weavesim.output import pictures
from weavesim.output.pictures.style import fitting_height, new_axes, new_figure, write_picture
from weavesim.sheet.blank import Blank

SHAPES = {"long": (0.72, 0.048), "tall": (0.048, 0.72), "square": (0.12, 0.12)}


@pytest.mark.parametrize("shape", SHAPES)
def test_titles_and_labels_are_whole_and_do_not_meet(tmp_path, shape):
    sheet = bowl(*SHAPES[shape])
    every = {
        "formed": pictures.formed_sheet(sheet), "draw-in": pictures.draw_in_picture(sheet),
        "points": pictures.point_angles(sheet), "sections": pictures.sections(sheet, []),
        "stack": pictures.stack_picture([("ply_1", sheet), ("ply_2", sheet)]),
    }  # fmt: skip
    for name, figure in every.items():
        write_picture(figure, tmp_path / "picture.png")
        renderer = figure.canvas.get_renderer()
        width, height = figure.bbox.size
        titles = []
        for axes in figure.axes:
            title = axes._left_title.get_window_extent(renderer) if axes.get_title(loc="left") else None
            texts = [label for label in axes.get_xticklabels() if label.get_text()]
            boxes = sorted((text.get_window_extent(renderer) for text in texts), key=lambda box: box.x0)
            boxes = [box for box in boxes if axes.bbox.x0 - 2.0 < 0.5 * (box.x0 + box.x1) < axes.bbox.x1 + 2.0]
            assert all(a.x1 < b.x0 for a, b in zip(boxes[:-1], boxes[1:], strict=True)), name
            if title is not None:
                titles.append(title)
        for box in titles:
            assert box.x0 >= 0.0 and box.x1 <= width and box.y0 >= 0.0 and box.y1 <= height, name
        for k, one in enumerate(titles):
            assert not any(one.overlaps(other) for other in titles[k + 1 :]), name


def test_a_title_that_is_too_long_is_wrapped(tmp_path):
    figure = new_figure(4.0, 3.0)
    axes = [new_axes(figure, 1, 2, k + 1, title="A very long title about what this chart shows to all") for k in (0, 1)]
    write_picture(figure, tmp_path / "wrapped.png")
    renderer = figure.canvas.get_renderer()
    boxes = [one._left_title.get_window_extent(renderer) for one in axes]
    assert all("\n" in one.get_title(loc="left") for one in axes)
    assert boxes[0].x1 < boxes[1].x0 and boxes[1].x1 <= figure.bbox.width
    assert all(box.y1 <= figure.bbox.height for box in boxes)


def test_rows_are_as_high_as_what_they_show():
    assert fitting_height(12.0, [1.0, 1.0]) > fitting_height(12.0, [0.5, 0.5]) > fitting_height(12.0, [0.25, 0.25])
    assert fitting_height(12.0, [9.0]) < 7.0 and fitting_height(12.0, [0.01]) > 1.0


def test_the_largest_angle_is_marked_with_its_place_and_what_most_of_the_area_has(tmp_path):
    sheet = bowl(0.12, 0.12)
    figure = pictures.formed_sheet(sheet)
    largest = sheet.shear_angle_deg.max()
    marks = [text.get_text() for axes in figure.axes[:2] for text in axes.texts]
    assert marks == [f"{largest:.1f}°"] * 2
    plan = figure.axes[1]
    ring = next(line for line in plan.lines if line.get_marker() == "o")
    element = sheet.shear_angle_deg.argmax()
    middle = 1e3 * sheet.position[sheet.blank.quads[element]].mean(axis=0)
    assert ring.get_xydata()[0] == pytest.approx(middle[:2])
    text = figure.axes[2].get_xlabel()
    flat = 1e3 * sheet.blank.material_coordinates[sheet.blank.quads[element]].mean(axis=0)
    assert f"largest {largest:.1f}° at ({flat[0]:.0f}, {flat[1]:.0f}) mm of the flat blank" in text
    assert f"99 % of the area below {sheet.usual_shear_angle_deg:.1f}°" in text
    assert sheet.usual_shear_angle_deg == pytest.approx(np.percentile(sheet.shear_angle_deg, 99.0), abs=0.6)
    assert isinstance(plan.texts[0].get_path_effects()[0], Stroke)


def test_what_is_usual_is_a_share_of_the_area_not_of_the_elements():
    blank = Blank.rectangle((0.0, 0.0), (1.0, 1.0), 0.25)
    points = blank.node_position.copy()
    points[:, 0] = points[:, 0] ** 4  # the first column is a 256th of the area
    blank = Blank.from_mesh(points, blank.quads)
    angle = np.where(blank.element_centres()[:, 0] < 0.004, 0.9, 0.1)
    sheet = dataclasses.replace(bowl(0.12, 0.12), blank=blank, position=points, fields={"shear_angle": angle})
    assert np.rad2deg(0.1) == pytest.approx(sheet.usual_shear_angle_deg)


def test_pictures_can_be_read(tmp_path):
    path = tmp_path / "formed.png"
    write_picture(pictures.formed_sheet(bowl(0.12, 0.12)), path, "run")
    assert imread(path).shape[1] == 1950
