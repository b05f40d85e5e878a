"""Pictures of any field, as notebooks ask for them."""

import dataclasses

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from PIL import Image

from weavesim.errors import InputError
from weavesim.output.pictures.surface import picture_of
from weavesim.sheet.topology import area_percentile, flat_areas


def test_a_field_is_drawn_with_its_unit_and_its_ends(coarse_run):
    info, frames = coarse_run
    frame = frames[-1]
    figure = picture_of(info, frame, "thickness")
    oblique, plan, bar = figure.axes
    (elements,) = [artist for artist in plan.collections if isinstance(artist, PolyCollection)]
    assert len(elements.get_paths()) == 4 * info.sheet.blank.element_count
    values = 1e3 * frame.fields["thickness"]
    text = bar.get_xlabel()
    assert text.startswith("thickness [mm]") and f"largest {values.max():.4g}" in text
    areas = flat_areas(info.sheet.blank)
    assert bar.get_xlim() == pytest.approx([area_percentile(values, areas, share) for share in (1.0, 99.0)])
    ring = next(line for line in plan.lines if line.get_marker() == "o")
    middle = 1e3 * frame.position[info.sheet.blank.quads[values.argmax()]].mean(axis=0)
    assert ring.get_xydata()[0] == pytest.approx(middle[:2])


@pytest.mark.parametrize("name", ["shear_angle", "shear_angle_deg"])
def test_the_shear_angle_has_its_own_picture(coarse_run, name):
    figure = picture_of(coarse_run[0], coarse_run[1][-1], name)
    assert "99 % of the area below" in figure.axes[-1].get_xlabel()


def test_a_constant_field_and_one_that_is_unknown_in_parts_can_be_drawn(coarse_run):
    info, frames = coarse_run
    fields = dict(frames[0].fields, warp_stretch=np.ones(info.sheet.blank.element_count))
    fields["thickness"] = np.where(np.arange(len(fields["thickness"])) % 2, np.nan, fields["thickness"])
    frame = dataclasses.replace(frames[0], sheets=(dataclasses.replace(frames[0].sheet, fields=fields),))
    for name in ("warp_stretch", "thickness"):
        picture = picture_of(info, frame, name)._repr_png_()
        assert picture.startswith(b"\x89PNG")
    fields["thickness"][:] = np.nan
    assert picture_of(info, frame, "thickness")._repr_png_()


def test_what_there_is_not_is_refused_with_what_there_is(coarse_run, stack):
    with pytest.raises(InputError, match="field 'colour': choose one of shear_angle, .*thickness"):
        picture_of(coarse_run[0], coarse_run[1][0], "colour")
    with pytest.raises(InputError, match="2 sheets: choose one of upper, lower"):
        picture_of(stack[0], stack[1][0])
    with pytest.raises(InputError, match="sheet 'middle': choose one of upper, lower"):
        picture_of(stack[0], stack[1][0], sheet="middle")
    assert picture_of(stack[0], stack[1][0], sheet="lower")


def test_a_simulation_plots_itself_and_tells_its_numbers(tmp_path):
    from tests.support.runs import small_run

    run = small_run()
    assert "it has not been run" in run._repr_html_()
    run.run()
    (tmp_path / "picture.png").write_bytes(run.plot("warp_stretch")._repr_png_())
    assert Image.open(tmp_path / "picture.png").size[0] == 1300
    text = run._repr_html_()
    assert "verdict" in text and "max_shear_angle" in text and run.verdict in text
    assert "<td" in run.summary()._repr_html_()
