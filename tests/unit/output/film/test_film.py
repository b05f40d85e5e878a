"""The USD film: what it holds, that USD's own validators accept it, and that it survives a run cut short."""

import dataclasses
import shutil

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdLux, UsdShade, UsdValidation

from weavesim.errors import InputError
from weavesim.output import Film
from weavesim.output.colours import colour_table
from weavesim.output.film.film import prim_names
from weavesim.output.film.legend import _text, legend_drawing
from weavesim.run.fields import FIELDS
from weavesim.run.frame import Outcome
from weavesim.sheet.symmetry import Symmetry


def write_film(path, run, frame_count=None):
    info, frames = run
    film = Film(path)
    film.start(info)
    for frame in frames[:frame_count]:
        film.frame(frame)
    film.finish(Outcome.FINISHED if frame_count is None else Outcome.INTERRUPTED)
    return path


@pytest.fixture(scope="module")
def film_path(tmp_path_factory, coarse_run):
    return write_film(tmp_path_factory.mktemp("film") / "double_dome.usdc", coarse_run)


@pytest.fixture
def stage(film_path):
    return Usd.Stage.Open(str(film_path))


def complaints(stage):
    registry = UsdValidation.ValidationRegistry()
    context = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators())
    return [f"{error.GetName()}: {error.GetMessage()}" for error in context.Validate(stage)]


def test_validators_accept_the_film(stage):
    assert complaints(stage) == []


def test_validators_do_complain(stage):
    stage.ClearDefaultPrim()
    stage.GetPrimAtPath("/World/sheets/sheet").RemoveAPI(UsdShade.MaterialBindingAPI)
    assert len(complaints(stage)) >= 2


def test_stage_metrics_and_time(stage, coarse_run):
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert stage.GetDefaultPrim().GetPath() == "/World"
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0.0, len(coarse_run[1]) - 1.0)
    assert stage.GetTimeCodesPerSecond() == 24.0


def test_every_frame_holds_the_points_of_the_run(stage, coarse_run):
    info, frames = coarse_run
    mesh = UsdGeom.Mesh.Get(stage, "/World/sheets/sheet")
    assert mesh.GetSubdivisionSchemeAttr().Get() == "none"
    assert mesh.GetDoubleSidedAttr().Get() is True
    assert np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 4).tolist() == info.sheet.blank.quads.tolist()
    assert mesh.GetPointsAttr().GetTimeSamples() == [float(frame.index) for frame in frames]
    for frame in frames:
        points = np.array(mesh.GetPointsAttr().Get(frame.index))
        assert np.array_equal(points, frame.position.astype(np.float32))
        extent = np.array(mesh.GetExtentAttr().Get(frame.index))
        assert np.array_equal(extent, [points.min(axis=0), points.max(axis=0)])


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


def test_the_clock_of_the_run_is_in_the_film(stage, coarse_run):
    world = stage.GetPrimAtPath("/World")
    for frame in coarse_run[1]:
        assert world.GetAttribute("weavesim:time").Get(frame.index) == frame.time
        assert world.GetAttribute("weavesim:stroke").Get(frame.index) == frame.stroke


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


def test_camera_sees_the_whole_part_in_every_frame(stage, coarse_run):
    camera = UsdGeom.Camera.Get(stage, "/World/camera")
    frustum = camera.GetCamera(0.0).frustum
    for frame in (coarse_run[1][0], coarse_run[1][-1]):
        for sign in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
            for point in frame.position * (*sign, 1.0):
                assert frustum.Intersects(Gf.Vec3d(*point))


def test_an_interrupted_film_ends_where_the_run_did(tmp_path, coarse_run):
    path = write_film(tmp_path / "cut.usdc", coarse_run, frame_count=4)
    stage = Usd.Stage.Open(str(path))
    assert stage.GetEndTimeCode() == 3.0
    assert complaints(stage) == []
    assert [file.name for file in tmp_path.iterdir()] == ["cut.usdc"]


def test_flushing_while_it_runs_loses_nothing(tmp_path, coarse_run, monkeypatch, film_path):
    monkeypatch.setattr("weavesim.output.film.film._FRAMES_PER_FLUSH", 3)
    stage = Usd.Stage.Open(str(write_film(tmp_path / "flushed.usdc", coarse_run)))
    flushed = UsdGeom.Mesh.Get(stage, "/World/sheets/sheet").GetPointsAttr()
    for frame in coarse_run[1]:
        assert np.array_equal(np.array(flushed.Get(frame.index)), frame.position.astype(np.float32))


def test_an_older_film_stays_until_the_new_one_has_a_frame(tmp_path, coarse_run):
    path = tmp_path / "film.usda"
    path.write_text("older")
    film = Film(path)
    film.start(coarse_run[0])
    assert path.read_text() == "older"
    film.frame(coarse_run[1][0])
    assert path.read_text().startswith("#usda")
    film.finish(Outcome.INTERRUPTED)
    assert path.read_text().startswith("#usda")


def test_a_film_does_not_depend_on_when_it_was_saved(tmp_path, coarse_run, monkeypatch):
    one = write_film(tmp_path / "one.usdc", coarse_run)
    monkeypatch.setattr("weavesim.output.film.film.Pace.due", lambda pace: True)
    other = write_film(tmp_path / "other.usdc", coarse_run)
    assert one.read_bytes() == other.read_bytes()
    assert {path.name for path in tmp_path.iterdir()} == {"one.usdc", "other.usdc"}


def test_a_save_without_room_costs_no_film(tmp_path, coarse_run, monkeypatch):
    def full(*arguments):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("shutil.copyfile", full)
    monkeypatch.setattr("weavesim.output.film.film.Film._publish", full)
    path = write_film(tmp_path / "film.usdc", coarse_run)
    assert Usd.Stage.Open(str(path)).GetEndTimeCode() == len(coarse_run[1]) - 1


def test_a_killed_run_leaves_a_film(tmp_path, coarse_run):
    """Every save is a whole film under its own name, with camera and light, in the middle of the run."""
    info, frames = coarse_run
    film = Film(tmp_path / "film.usdc")
    film.start(info)
    for index, frame in enumerate(frames[:6]):
        film.frame(frame)
        stage = Usd.Stage.Open(str(shutil.copy(film.path, tmp_path / f"copy_{index}.usdc")))
        assert stage.GetEndTimeCode() == {3: 2, 5: 4}.get(index, index)
        assert stage.GetPrimAtPath("/World/camera") and stage.GetPrimAtPath("/World/lights/key")
        assert stage.GetRootLayer().customLayerData["weavesim"]["run_id"] == info.run_id


def test_a_full_blank_has_no_copies(tmp_path, coarse_run):
    info, frames = coarse_run
    whole = dataclasses.replace(info, sheets=(dataclasses.replace(info.sheet, symmetry=Symmetry()),))
    stage = Usd.Stage.Open(str(write_film(tmp_path / "full.usdc", (whole, frames))))
    assert not [prim for prim in stage.Traverse() if "mirrored" in prim.GetName()]


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


def test_unknown_endings_are_refused():
    with pytest.raises(InputError, match="must end in .usdc"):
        Film("film.mp4")


@pytest.fixture(scope="module")
def stack_path(tmp_path_factory, stack):
    return write_film(tmp_path_factory.mktemp("film") / "stack.usdc", stack)


@pytest.fixture(scope="module")
def stack_film(stack_path):
    return Usd.Stage.Open(str(stack_path))


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


def test_tools_of_two_worlds_that_share_a_name_are_two_prims(stack_film, stack):
    info, frames = stack
    for k, name in enumerate(("punch", "die", "blank_holder", "punch_2", "die_2", "blank_holder_2")):
        transform = UsdGeom.Xformable.Get(stack_film, f"/World/tools/{name}")
        moved = transform.ComputeLocalToWorldTransform(frames[-1].index).ExtractTranslation()
        assert np.array(moved) == pytest.approx(frames[-1].tool_displacement[k] * np.array(info.tools[k].axis))


def test_the_camera_sees_all_sheets(stack_film, stack):
    frustum = UsdGeom.Camera.Get(stack_film, "/World/camera").GetCamera(0.0).frustum
    for state in stack[1][-1].sheets:
        assert all(frustum.Intersects(Gf.Vec3d(*point)) for point in state.position)


def test_names_of_prims_are_valid_and_differ():
    assert prim_names(["ply 1", "ply-1", "ply_1", "2nd"]) == ["ply_1", "ply_1_2", "ply_1_3", "_nd"]


def chosen(path, **variants: str):
    """The film with these variants of /World, chosen as a viewer does: in its session, not in the file."""
    stage = Usd.Stage.Open(str(path))
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        for name, variant in variants.items():
            assert stage.GetPrimAtPath("/World").GetVariantSet(name).SetVariantSelection(variant)
    return stage


def moved(stage, path: str, time: float = 0.0) -> np.ndarray:
    """Where the origin of a prim is [m]."""
    transform = UsdGeom.Xformable(stage.GetPrimAtPath(path)).ComputeLocalToWorldTransform(time)
    return np.array(transform.ExtractTranslation())


SHEETS_OF_STACK = ("/World/sheets/upper", "/World/sheets/lower")


def test_validators_accept_every_view_of_several_sheets(stack_path):
    for view in ("stacked", "exploded"):
        for colours in ("shear_angle", "sheets"):
            assert complaints(chosen(stack_path, view=view, colours=colours)) == []


def test_several_sheets_are_seen_as_they_are_unless_they_are_moved_apart(stack_path, stack):
    info, frames = stack
    stage = Usd.Stage.Open(str(stack_path))
    for path in (*SHEETS_OF_STACK, "/World/sheets/upper_mirrored_x"):
        assert moved(stage, path) == pytest.approx(0.0)
    apart = chosen(stack_path, view="exploded")
    points = np.concatenate([sheet.position for frame in frames for sheet in frame.sheets])
    gap = moved(apart, SHEETS_OF_STACK[1])[2]  # both are at one height: the first counts as the lower one
    assert gap == pytest.approx(max(0.6 * np.ptp(points[:, 2]), 0.2 * np.abs(points[:, :2]).max()))
    assert moved(apart, SHEETS_OF_STACK[0]) == pytest.approx(0.0)
    # mirrored copies go with their sheet, and are mirrored still
    for name in ("_mirrored_x", "_mirrored_y", "_mirrored_x_y"):
        assert moved(apart, f"{SHEETS_OF_STACK[0]}{name}") == pytest.approx(0.0)
        scale = UsdGeom.Xformable(apart.GetPrimAtPath(f"{SHEETS_OF_STACK[0]}{name}")).ComputeLocalToWorldTransform(0.0)
        assert abs(scale.GetDeterminant()) == pytest.approx(1.0) and scale != Gf.Matrix4d(1.0)
    # tools move out of the way, and still with their strokes
    last = frames[-1]
    for k, (name, away) in enumerate(zip(info.tool_names, (2.0 * gap, -gap, 2.0 * gap) * 2, strict=True)):
        stroke = last.tool_displacement[k] * np.array(info.tools[k].axis)
        assert moved(apart, f"/World/tools/{name}", last.index) == pytest.approx(stroke + (0.0, 0.0, away)), name


def test_a_camera_sees_the_sheets_that_are_moved_apart(stack_path, stack):
    stage = chosen(stack_path, view="exploded")
    frustum = UsdGeom.Camera.Get(stage, "/World/camera_exploded").GetCamera(0.0).frustum
    for frame in (stack[1][0], stack[1][-1]):
        for path, sheet in zip(SHEETS_OF_STACK, frame.sheets, strict=True):
            for point in sheet.position + moved(stage, path):
                assert frustum.Intersects(Gf.Vec3d(*point))


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


def test_one_sheet_has_nothing_to_choose(stage):
    assert stage.GetPrimAtPath("/World").GetVariantSets().GetNames() == []
    assert not stage.GetPrimAtPath("/World/camera_exploded")
