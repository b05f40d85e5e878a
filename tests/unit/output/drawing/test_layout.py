"""Places of everything in a figure: as Matplotlib would find them, whatever the axes have."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from weavesim.output.drawing.layout import _room, lay_out
from weavesim.output.pictures.style import new_axes, new_figure, styled

# Labels that are not measured may be somewhat wider than the longest one [pixels].
NEAR = 4.0


def plain(axes):
    axes.plot([0.0, 60.0], [0.0, 1500.0])
    axes.set(xlabel="stroke [mm]", ylabel="force [N]")


def logarithmic(axes):
    axes.plot([1.0, 2.0, 3.0], [1.0e-4, 1.0, 20.0], label="friction loss")
    axes.set(yscale="log", ylabel="energy [J]")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def equal(axes):
    axes.plot([-200.0, 200.0], [-100.0, 100.0])
    axes.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]")


def powers(axes):
    axes.plot([0.0, 1.0], [0.0, 3.0e9])


def bare(axes):
    axes.set_axis_off()


def text_beside(axes):
    axes.text(1.2, 0.5, "beside", transform=axes.transAxes)


EVERY = (plain, logarithmic, equal, powers, bare, text_beside)


@pytest.mark.parametrize("draw", EVERY)
def test_axes_take_the_room_that_matplotlib_says(draw):
    with styled():
        figure = new_figure(9.0, 4.4)
        axes = new_axes(figure, 1, 1, 1, title="What this shows")
        draw(axes)
        renderer = FigureCanvasAgg(figure).get_renderer()
        expected = axes.get_tightbbox(renderer, for_layout_only=True)
        assert np.abs(_room(axes, renderer).extents - expected.extents).max() < NEAR


def test_nothing_lies_on_anything_else_or_beyond_the_figure():
    with styled():
        figure = new_figure(16.0, 9.0)
        every = [new_axes(figure, 2, 3, k + 1, title=draw.__name__) for k, draw in enumerate(EVERY)]
        for axes, draw in zip(every, EVERY, strict=True):
            draw(axes)
        lay_out(figure, 100.0)
    assert not any("get_tightbbox" in vars(axes) for axes in every)
    assert figure.get_layout_engine() is None
    figure.canvas.draw()
    boxes = [axes.get_tightbbox(figure.canvas.get_renderer()) for axes in every]
    for k, box in enumerate(boxes):
        assert min(box.x0, box.y0, figure.bbox.width - box.x1, figure.bbox.height - box.y1) >= 0.0
        assert not any(box.overlaps(other) for other in boxes[k + 1 :])


@pytest.mark.parametrize("largest", [3.0, 3.0e9])
def test_a_title_keeps_off_the_power_of_an_axis(largest):
    with styled():
        figure = new_figure(6.0, 4.0)
        axes = new_axes(figure, 1, 1, 1, title="A title")
        axes.plot([0.0, 1.0], [0.0, largest])
        lay_out(figure, 100.0)
        figure.canvas.draw()
    power, title = axes.yaxis.get_offset_text(), axes._left_title
    assert bool(power.get_text()) is (largest > 1.0e6)
    renderer = figure.canvas.get_renderer()
    if power.get_text():
        assert not power.get_window_extent(renderer).overlaps(title.get_window_extent(renderer))
    else:
        assert title.get_position()[1] == 1.0
