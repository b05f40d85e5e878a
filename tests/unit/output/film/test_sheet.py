"""Sheets of a film: fields, colours, mirrored copies."""

import dataclasses

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdShade

from tests.support.films import SHEETS_OF_STACK, chosen, complaints, write_film
from weavesim.run.fields import FIELDS


def test_fields_are_element_values(stage, coarse_run):
    frame = coarse_run[1][-1]
    primvars = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/sheets/sheet"))
    for name, expected in (
        ("shear_angle_deg", np.rad2deg(frame.fields["shear_angle"])),
        ("warp_stretch", frame.fields["warp_stretch"]),
        ("weft_stretch", frame.fields["weft_stretch"]),
        ("thickness", frame.fields["thickness"]),
        ("fibre_volume_fraction", frame.fields["fibre_volume_fraction"]),
    ):
        primvar = primvars.GetPrimvar(name)
        assert primvar.GetInterpolation() == "uniform"
        assert np.array(primvar.Get(frame.index)) == pytest.approx(expected, rel=1e-6)


def test_every_field_tells_what_it_is_in_which_unit(stage, coarse_run):
    prim = stage.GetPrimAtPath("/World/sheets/sheet")
    primvars = {primvar.GetPrimvarName(): primvar.GetAttr() for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvars()}
    fields = [field for field in FIELDS if field.name in coarse_run[1][0].fields and not field.diagnostic]
    assert (
        set(primvars) - {"displayColor", "displayOpacity"} == {field.file_name for field in fields} and len(fields) >= 5
    )
    for field in fields:
        attribute = primvars[field.file_name]
        assert attribute.GetDocumentation() == f"{field.description} [{field.file_unit}]"
        assert attribute.GetCustomDataByKey("unit") == field.file_unit
        assert len(attribute.GetTimeSamples()) == len(coarse_run[1])
    assert "degrees" in primvars["displayColor"].GetDocumentation()
    assert "metres" in prim.GetDocumentation()


def test_display_colour_reaches_the_material_and_brightens_with_the_angle(stage, coarse_run):
    info, frames = coarse_run
    mesh = UsdGeom.Mesh.Get(stage, "/World/sheets/sheet")
    colour = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("displayColor")
    assert colour.GetInterpolation() == "vertex"
    material = UsdShade.MaterialBindingAPI(mesh.GetPrim()).ComputeBoundMaterial()[0]
    shader = material.ComputeSurfaceSource()[0]
    source = shader.GetInput("diffuseColor").GetConnectedSources()[0][0].source
    assert source.GetPrim().GetAttribute("info:id").Get() == "UsdPrimvarReader_float3"
    assert source.GetInput("varname").Get() == "displayColor"

    luminance = np.array(colour.Get(frames[-1].index)) @ (0.2126, 0.7152, 0.0722)
    angle = np.abs(frames[-1].fields["shear_angle"])
    sheared, calm = info.sheet.blank.quads[angle.argmax()], info.sheet.blank.quads[angle.argmin()]
    assert luminance[sheared].mean() > 3.0 * luminance[calm].mean()
    first = np.array(colour.Get(0.0))
    assert np.ptp(first, axis=0).max() == 0.0


def test_mirrored_copies_complete_the_part_without_storing_it_again(stage, coarse_run):
    frame = coarse_run[1][-1]
    copies = {"_mirrored_x": (-1, 1), "_mirrored_y": (1, -1), "_mirrored_x_y": (-1, -1)}
    for name, sign in copies.items():
        prim = stage.GetPrimAtPath(f"/World/sheets/sheet{name}")
        spec = stage.GetRootLayer().GetPrimAtPath(prim.GetPath())
        assert set(spec.attributes.keys()) == {"xformOp:scale", "xformOpOrder"}
        to_world = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(frame.index)
        points = UsdGeom.Mesh(prim).GetPointsAttr().Get(frame.index)
        world = np.array([to_world.Transform(Gf.Vec3d(point)) for point in points])
        assert world == pytest.approx(frame.position * (*sign, 1.0), abs=1e-7)
        material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
        assert material.GetPath() == "/World/materials/sheet"


def test_a_fabric_without_known_fibres_has_no_fibre_volume_fraction(tmp_path, coarse_run):
    info, frames = coarse_run
    bare = [
        dataclasses.replace(
            frame,
            sheets=(
                dataclasses.replace(
                    frame.sheet, fields={k: v for k, v in frame.fields.items() if k != "fibre_volume_fraction"}
                ),
            ),
        )
        for frame in frames[:2]
    ]
    stage = Usd.Stage.Open(str(write_film(tmp_path / "bare.usdc", (info, bare))))
    primvars = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/sheets/sheet"))
    assert primvars.HasPrimvar("thickness") and not primvars.HasPrimvar("fibre_volume_fraction")


def test_every_sheet_of_a_run_is_a_mesh_with_its_own_copies(stack_film, stack):
    info, frames = stack
    for sheet, state in zip(info.sheets, frames[-1].sheets, strict=True):
        mesh = UsdGeom.Mesh.Get(stack_film, f"/World/sheets/{sheet.name}")
        points = np.array(mesh.GetPointsAttr().Get(frames[-1].index))
        assert np.array_equal(points, state.position.astype(np.float32))
        angles = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("shear_angle_deg").Get(frames[-1].index))
        assert angles == pytest.approx(np.rad2deg(state.fields["shear_angle"]), rel=1e-6)
    copies = [prim.GetName() for prim in stack_film.Traverse() if "mirrored" in prim.GetName()]
    assert sorted(copies) == [f"upper_mirrored_{axes}" for axes in ("x", "x_y", "y")]
    assert not stack_film.GetPrimAtPath("/World/sheets/sheet")
    assert complaints(stack_film) == []


def test_sheets_have_colours_of_their_own_where_these_are_chosen(stack_path):
    def materials(**variants):
        stage = chosen(stack_path, **variants)
        paths = (*SHEETS_OF_STACK, "/World/sheets/upper_mirrored_x_y")
        bound = [UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(path)).ComputeBoundMaterial()[0] for path in paths]
        colours = [material.ComputeSurfaceSource()[0].GetInput("diffuseColor").Get() for material in bound]
        return [(str(material.GetPath()), colour) for material, colour in zip(bound, colours, strict=True)]

    assert {path for path, _ in materials()} == {"/World/materials/sheet"}
    upper, lower, mirrored = materials(colours="sheets")
    assert upper[0] == mirrored[0] == "/World/materials/upper" and lower[0] == "/World/materials/lower"
    assert upper[1] == mirrored[1] != lower[1]
