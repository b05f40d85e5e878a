"""Cameras and lights of a film."""

import dataclasses

from pxr import Gf, Usd, UsdGeom, UsdLux, UsdShade

from tests.support.films import SHEETS_OF_STACK, chosen, moved, write_film


def test_lights_give_what_they_say_whatever_their_size(stage):
    key = UsdLux.DistantLight.Get(stage, "/World/lights/key")
    assert key.GetNormalizeAttr().Get() is True
    sky = UsdLux.DomeLight.Get(stage, "/World/lights/sky")
    assert 1.0 < key.GetIntensityAttr().Get() + sky.GetIntensityAttr().Get() < 2.0
    # it shines onto the side that the camera sees
    shines = UsdGeom.Xformable(key.GetPrim()).ComputeLocalToWorldTransform(0.0).TransformDir(Gf.Vec3d(0, 0, -1))
    looks = UsdGeom.Xformable.Get(stage, "/World/camera").ComputeLocalToWorldTransform(0.0)
    assert shines * looks.TransformDir(Gf.Vec3d(0, 0, -1)) > 0.5


def test_the_camera_is_on_the_formed_side_and_tools_there_are_transparent(tmp_path, stage, coarse_run):
    def eye(stage, name="camera"):
        return moved(stage, f"/World/{name}")[2]

    def opacity(stage, tool):
        material = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(f"/World/tools/{tool}")).ComputeBoundMaterial()[0]
        return material.ComputeSurfaceSource()[0].GetInput("opacity").Get()

    # the punch has pressed the sheet down
    assert eye(stage) < 0.0 < eye(stage, "camera_back")
    assert opacity(stage, "die") < 0.5 and opacity(stage, "punch") == opacity(stage, "blank_holder") == 1.0
    info, frames = coarse_run
    turned = [
        dataclasses.replace(
            frame, sheets=(dataclasses.replace(frame.sheet, position=frame.position * (1.0, 1.0, -1.0)),)
        )
        for frame in frames
    ]
    other = Usd.Stage.Open(str(write_film(tmp_path / "turned.usdc", (info, turned))))
    assert eye(other, "camera_back") < 0.0 < eye(other)
    assert opacity(other, "die") == 1.0 > opacity(other, "punch")


def test_camera_sees_the_whole_part_in_every_frame(stage, coarse_run):
    camera = UsdGeom.Camera.Get(stage, "/World/camera")
    frustum = camera.GetCamera(0.0).frustum
    for frame in (coarse_run[1][0], coarse_run[1][-1]):
        for sign in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
            for point in frame.position * (*sign, 1.0):
                assert frustum.Intersects(Gf.Vec3d(*point))


def test_the_camera_sees_all_sheets(stack_film, stack):
    frustum = UsdGeom.Camera.Get(stack_film, "/World/camera").GetCamera(0.0).frustum
    for state in stack[1][-1].sheets:
        assert all(frustum.Intersects(Gf.Vec3d(*point)) for point in state.position)


def test_a_camera_sees_the_sheets_that_are_moved_apart(stack_path, stack):
    stage = chosen(stack_path, view="exploded")
    frustum = UsdGeom.Camera.Get(stage, "/World/camera_exploded").GetCamera(0.0).frustum
    for frame in (stack[1][0], stack[1][-1]):
        for path, sheet in zip(SHEETS_OF_STACK, frame.sheets, strict=True):
            for point in sheet.position + moved(stage, path):
                assert frustum.Intersects(Gf.Vec3d(*point))
