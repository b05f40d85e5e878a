"""Tools of a film, and the variants of several sheets."""

import numpy as np
import pytest
from pxr import UsdGeom, UsdShade


def test_tools_move_along_their_axes_with_their_own_materials(stage, coarse_run):
    info, frames = coarse_run
    materials = set()
    for k, tool in enumerate(info.tools):
        transform = UsdGeom.Xformable.Get(stage, f"/World/tools/{tool.name}")
        for frame in (frames[0], frames[5], frames[-1]):
            moved = transform.ComputeLocalToWorldTransform(frame.index).ExtractTranslation()
            assert np.array(moved) == pytest.approx(frame.tool_displacement[k] * np.array(tool.axis))
        surface = stage.GetPrimAtPath(f"/World/tools/{tool.name}")
        assert len(UsdGeom.Mesh(surface).GetPointsAttr().Get()) == len(tool.display_triangles()[0])
        materials.add(UsdShade.MaterialBindingAPI(surface).ComputeBoundMaterial()[0].GetPath())
    assert len(materials) == len(info.tools)


def test_tool_corners_are_smooth_on_the_ball_and_sharp_on_the_box(stage):
    for name, rule in (("punch", lambda angle: angle.max() > 1.0), ("die", lambda angle: angle.max() < 1e-3)):
        mesh = UsdGeom.Mesh.Get(stage, f"/World/tools/{name}")
        points = np.array(mesh.GetPointsAttr().Get())[np.array(mesh.GetFaceVertexIndicesAttr().Get())].reshape(-1, 3, 3)
        normals = np.array(mesh.GetNormalsAttr().Get()).reshape(-1, 3, 3)
        face = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
        face /= np.linalg.norm(face, axis=1, keepdims=True)
        angle = np.rad2deg(np.arccos(np.clip(np.einsum("fci,fi->fc", normals, face), -1.0, 1.0)))
        assert rule(angle) and angle.max() < 36.0


def test_tools_of_two_worlds_that_share_a_name_are_two_prims(stack_film, stack):
    info, frames = stack
    for k, name in enumerate(("punch", "die", "blank_holder", "punch_2", "die_2", "blank_holder_2")):
        transform = UsdGeom.Xformable.Get(stack_film, f"/World/tools/{name}")
        moved = transform.ComputeLocalToWorldTransform(frames[-1].index).ExtractTranslation()
        assert np.array(moved) == pytest.approx(frames[-1].tool_displacement[k] * np.array(info.tools[k].axis))
