"""A run that never was: a quarter of a double dome, formed by a formula instead of by mechanics."""

import dataclasses

import numpy as np

from weavesim.fabric.presets import glass_polypropylene
from weavesim.measures.angles import yarn_vectors
from weavesim.measures.findings import FormedSheet
from weavesim.run.frame import Frame, RunInfo, SheetFrame, SheetInfo
from weavesim.sheet.blank import Blank
from weavesim.sheet.symmetry import Symmetry
from weavesim.tools.shapes import Plane
from weavesim.tools.tool import Tool

HALF_LENGTH, HALF_WIDTH, DEPTH, THICKNESS = 0.235, 0.135, 0.06, 0.0012


class DrawnTool(Tool):
    """A tool that only its picture has a shape of."""

    def display_triangles(self):
        import trimesh

        if self.name == "punch":
            mesh = trimesh.creation.capsule(height=0.17, radius=0.06, count=[24, 24])
            mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0]))
            mesh.apply_translation([0.0, 0.0, 0.06 + THICKNESS / 2])
            return np.asarray(mesh.vertices), np.asarray(mesh.faces)
        height = -0.02 if self.name == "die" else 0.006
        outer = trimesh.creation.box(extents=[0.6, 0.4, 0.01])
        outer.apply_translation([0.0, 0.0, height])
        return np.asarray(outer.vertices), np.asarray(outer.faces)


def drawn_tools():
    return (
        DrawnTool("punch", Plane(), axis=(0.0, 0.0, -1.0), friction=0.2, colour=(0.55, 0.6, 0.68)),
        DrawnTool("die", Plane(), axis=(0.0, 0.0, 1.0), friction=0.2, colour=(0.4, 0.42, 0.48)),
        DrawnTool("blank_holder", Plane(), axis=(0.0, 0.0, -1.0), friction=0.2, colour=(0.7, 0.7, 0.72)),
    )


def dome_positions(blank: Blank, progress: float) -> np.ndarray:
    """Pressed down by ``progress`` times the depth, drawn in towards the middle."""
    x, y = blank.material_coordinates.T
    beside = np.stack([x - np.clip(x, -0.085, 0.085), y], axis=1)
    distance = np.hypot(*beside.T)
    pull = 0.030 * progress * (1.0 - np.exp(-((distance / 0.06) ** 2)))
    plan = np.stack([x, y], axis=1) - beside / np.maximum(distance, 1e-12)[:, None] * pull[:, None]
    beside_now = np.stack([plan[:, 0] - np.clip(plan[:, 0], -0.085, 0.085), plan[:, 1]], axis=1)
    height = -DEPTH * progress / (1.0 + np.exp((np.hypot(*beside_now.T) - 0.05) / 0.008))
    return np.column_stack([plan, height])


def made_frame(blank: Blank, index: int, progress: float, tool_count: int = 3) -> Frame:
    position = dome_positions(blank, progress)
    warp, weft = yarn_vectors(blank, position)
    angle = np.arcsin(np.einsum("ei,ei->e", warp, weft))
    ones = np.ones(blank.element_count)
    displacement = np.array([DEPTH * progress, 0.0, 0.0])[:tool_count]
    reaction = np.array([[3.0, 2.0, 220.0 * progress**2], [0.0, 0.0, -220.0 * progress**2 - 160.0], [0.0, 0.0, 160.0]])
    work = 4.0 * progress**3
    return Frame(
        index=index,
        step_count=500 * index,
        time=DEPTH * progress,
        stroke=DEPTH * progress,
        sheets=(SheetFrame(
            name="sheet",
            position=position,
            director=np.tile([0.0, 0.0, 1.0], (blank.node_count, 1)),
            fields={
                "shear_angle": angle,
                "warp_stretch": 1.0 + 0.004 * progress * np.cos(angle),
                "weft_stretch": ones + 0.002 * progress,
                "unit_cell_iterations": 2.0 * ones,
                "thickness": THICKNESS / np.cos(angle),
                "fibre_volume_fraction": 0.25 + 0.1 * progress * np.abs(angle),
            },
            energies={},
        ),),
        tool_displacement=displacement,
        tool_reaction=reaction[:tool_count],
        energies={
            "kinetic": 0.03 * progress, "warp_axial": 0.3 * work, "shear": 0.44 * work, "bending": 0.05 * work,
            "hourglass": 0.004 * work, "internal": 0.794 * work, "contact": 0.006 * work, "friction_loss": 0.19 * work,
            "damping_loss": 0.01 * work, "snap_loss": 0.0, "tool_work": work, "supplied": work,
            "used": work + 0.03 * progress, "balance_error": -0.03 * progress,
        },
    )  # fmt: skip


def made_info(blank: Blank, symmetry: Symmetry | None = None, **given) -> RunInfo:
    """The double dome's, with one sheet; ``given`` goes before it."""
    tools = drawn_tools()
    sheet = SheetInfo("sheet", blank, glass_polypropylene(), symmetry or Symmetry(), tuple(range(len(tools))))
    settings = {"sheets": (sheet,), "tools": tools, "supports": (), "duration": DEPTH, "frame_count": 11}
    return RunInfo(name="double_dome", **(settings | given))


def formed(info: RunInfo, frame: Frame, points: np.ndarray | None = None) -> FormedSheet:
    """The only sheet of a frame."""
    sheet, state = info.sheet, frame.sheet
    return FormedSheet(sheet.blank, state.position, state.fields, sheet.fabric.thickness, sheet.symmetry, points)


def made_run(element_size: float = 0.005, frame_count: int = 12, quarter: bool = True):
    lower = (0.0, 0.0) if quarter else (-HALF_LENGTH, -HALF_WIDTH)
    blank = Blank.rectangle(lower, (HALF_LENGTH, HALF_WIDTH), element_size)
    info = made_info(blank, Symmetry(("x", "y") if quarter else ()))
    frames = [made_frame(blank, i, i / (frame_count - 1)) for i in range(frame_count)]
    return info, frames


def made_stack(frame_count: int = 4):
    """A run of two sheets that do not touch: "upper", a quarter, and "lower", whole, each under its own tools."""
    upper, lower = (made_run(size, frame_count, quarter) for size, quarter in ((0.015, True), (0.02, False)))
    tools = upper[0].tools + lower[0].tools
    places = tuple(range(len(tools)))
    sheets = tuple(
        dataclasses.replace(info.sheet, name=name, tools=own, world=name)
        for info, name, own in ((upper[0], "upper", places[:3]), (lower[0], "lower", places[3:]))
    )
    info = dataclasses.replace(upper[0], name="stack", sheets=sheets, tools=tools)
    frames = [
        dataclasses.replace(
            frame,
            sheets=(dataclasses.replace(frame.sheet, name="upper"), dataclasses.replace(other.sheet, name="lower")),
            tool_displacement=np.concatenate([frame.tool_displacement, 0.5 * other.tool_displacement]),
            tool_reaction=np.concatenate([frame.tool_reaction, other.tool_reaction]),
        )
        for frame, other in zip(upper[1], lower[1], strict=True)
    ]
    return info, frames
