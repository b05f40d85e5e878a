"""The legend of a film."""

import numpy as np
from pxr import Gf, UsdGeom

from weavesim.output.colours import colour_table
from weavesim.output.film.legend import _text, legend_drawing


def test_the_legend_lies_below_the_part_in_the_picture(stage, coarse_run):
    frustum = UsdGeom.Camera.Get(stage, "/World/camera").GetCamera(0.0).frustum
    to_picture = frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix()
    mesh = UsdGeom.Mesh.Get(stage, "/World/legend")
    to_world = mesh.ComputeLocalToWorldTransform(0.0)
    legend = np.array([to_picture.Transform(to_world.Transform(Gf.Vec3d(p))) for p in mesh.GetPointsAttr().Get()])
    assert np.abs(legend[:, :2]).max() < 1.0
    for frame in (coarse_run[1][0], coarse_run[1][-1]):
        for sign in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
            part = np.array([to_picture.Transform(Gf.Vec3d(*p)) for p in frame.position * (*sign, 1.0)])
            assert part[:, 1].min() > legend[:, 1].max()
            assert part[:, 2].min() > legend[:, 2].max()  # nothing is in front of it


def test_the_bar_of_the_legend_has_the_colours_of_the_field():
    drawing = legend_drawing()
    bar = np.array([np.abs(colour_table() - colour).sum(axis=1).min() < 1e-12 for colour in drawing.colours])
    x = drawing.points[bar, 0]
    lightness = drawing.colours[bar] @ (0.2126, 0.7152, 0.0722)
    assert len(np.unique(x)) > 50 and np.all(np.diff(lightness[np.argsort(x, kind="stable")]) > -1e-12)
    # letters keep their holes: the area of a zero is smaller than that of its outline
    assert triangle_area(_text("0", 0.0, 0.0, 1.0)) < 0.8 * triangle_area(_text("0", 0.0, 0.0, 1.0), filled=True)


def triangle_area(drawing, filled=False) -> float:
    if filled:
        hull = drawing.points[:, :2]
        return float(np.ptp(hull[:, 0]) * np.ptp(hull[:, 1])) * np.pi / 4.0
    a, b, c = drawing.points[drawing.faces].transpose(1, 0, 2)[..., :2]
    return float(np.abs(np.cross(np.c_[b - a, 0 * a[:, :1]], np.c_[c - a, 0 * a[:, :1]])[:, 2]).sum()) / 2.0
