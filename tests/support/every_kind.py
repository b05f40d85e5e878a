"""Set-ups that together have every law, unit cell, shape, motion, support and load that exists."""

from __future__ import annotations

import math

import numpy as np
import trimesh

from tests.support.folded_strips import fold_blank
from tests.support.registered_cells import CELLS
from tests.support.registered_laws import TERMS
from tests.support.sheet import plain_fabric
from weavesim import (
    Drive,
    Dynamics,
    Fabric,
    NodalLoads,
    SelfContact,
    Setup,
    Sheet,
    SmoothStroke,
    Solver,
    Support,
    Tool,
    World,
)
from weavesim.checks import Kinded
from weavesim.fabric import ShearFriction, YarnBending, glass_polypropylene
from weavesim.fabric.bending import BendingCurve
from weavesim.process import (
    AtForce,
    AtRest,
    AtStroke,
    Coulomb,
    Fixed,
    ForceDriven,
    Gripper,
    Interface,
    PathMotion,
    Pressure,
    PressureFriction,
    Rotation,
    SheetLoads,
    SheetPressure,
    Stage,
    StribeckFriction,
    Stroke,
    Trim,
    ViscousFilm,
    YarnAngleFriction,
)
from weavesim.sheet.blank import Blank
from weavesim.tools import (
    Capsule,
    DomeCavity,
    DomeOpening,
    DomeOpeningSector,
    DomePunch,
    MeshShape,
    Plane,
    Shape,
    Sphere,
    Torus,
    Union,
    rotation_matrix,
)

ONE_LANE = Solver(precision="float64", lane_count=1, threads=1)
IN_LANES = Solver(precision="float32", lane_count=16, threads=2)


def saddle() -> Blank:
    """A distorted mesh on a saddle, yarns at 20 degrees to the edges."""
    flat = Blank.rectangle((0.0, 0.0), (0.02, 0.015), 0.005, yarn_angle=20.0, distortion=0.25)
    position = flat.node_position.copy()
    position[:, 2] = 3.0 * position[:, 0] ** 2 - 2.0 * position[:, 0] * position[:, 1]
    return Blank.from_mesh(position, flat.quads, yarn_angle=20.0)


def thrown(fabric: Fabric, blank: Blank, solver: Solver = ONE_LANE) -> Setup:
    """A free sheet that starts with velocities of all directions."""
    velocity = 0.5 * np.random.default_rng(3).normal(size=(blank.node_count, 3))
    sheet = Sheet(blank, fabric, initial_velocity=velocity)
    return Setup(name="thrown", sheets=(sheet,), duration=1.0, dynamics=Dynamics(damping=20.0), solver=solver,
                 accept_unusual=True)  # fmt: skip


def rubbing() -> Fabric:
    """Friction in shear, raised by tension, and in bending."""
    curve = BendingCurve.from_kawabata(rigidity=3e-3, hysteresis=5e-3, slip_curvature=2.0)
    friction = ShearFriction(stiffness=300.0, limit=(0.5,), crossover_friction_length=1e-4)
    bending = YarnBending(warp=curve, weft=curve, twist=1e-3)
    return glass_polypropylene().model_copy(update={"shear_friction": friction, "bending": bending})


def shapes(height: float) -> list[Shape]:
    """One of every kind, side by side along x, each with its uppermost point at ``height`` [m]."""
    turned = rotation_matrix((1.0, 0.0, 0.0), math.pi)
    block = trimesh.creation.box(extents=(0.03, 0.03, 0.01))
    small = (Sphere(0.01, origin=(x, 0.0, height - 0.01)) for x in (-0.055, -0.045))
    return [
        Plane(origin=(0.0, 0.0, height)),
        Sphere(0.02, origin=(0.1, 0.0, height - 0.02)),
        Capsule(0.01, 0.02, origin=(0.05, 0.0, height - 0.01)),
        Torus(0.005, 0.015, origin=(0.0, 0.0, height - 0.005)),
        DomePunch(0.02, 0.01, origin=(-0.1, 0.0, height - 0.02), rotation=turned),
        DomeOpening(0.012, 0.005, 0.004, origin=(0.0, 0.0, height)),
        DomeOpeningSector(0.012, 0.005, 0.004, 10.0, 80.0, origin=(0.15, 0.0, height)),
        DomeCavity(0.03, 0.005, origin=(0.05, 0.0, height)),
        MeshShape.from_triangles(block.vertices, block.faces, spacing=2e-3, origin=(-0.15, 0.0, height - 0.005)),
        Union(tuple(small)),
    ]


def pressed(solver: Solver, under: list[Shape], length: float = 0.04, contact_thickness: str = "initial") -> Setup:
    """A strip that falls on shapes that rise, under a weight that a force moves."""
    fabric = rubbing()
    blank = Blank.rectangle((-0.5 * length, -0.02), (0.5 * length, 0.02), 0.01, yarn_angle=30.0)
    weight = Plane(origin=(0.0, 0.0, 0.499 * fabric.thickness), rotation=rotation_matrix((1.0, 0.0, 0.0), math.pi))
    tools = (
        *(Tool(f"rising {k}", shape, Stroke((0.0, 1.0), (0.0, 0.5))) for k, shape in enumerate(under)),
        Tool("weight", weight, ForceDriven.constant(2.0, 0.01), axis=(0.0, 0.0, -1.0)),
        Tool("far", Plane(origin=(0.0, 0.0, -1.0)), Fixed()),
    )
    dynamics = Dynamics(gravity=(0.0, 0.0, -9.81), damping=10.0, contact_thickness=contact_thickness)
    sheets = (Sheet(blank, fabric),)
    return Setup(
        name="pressed", sheets=sheets, tools=tools, duration=1.0, dynamics=dynamics, solver=solver, accept_unusual=True
    )


def carried(solver: Solver) -> Setup:
    """A strip on a drum that turns and wanders, under a weight that rocks: met between nodes too, then in a stage."""
    fabric = rubbing()
    blank = Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.01, yarn_angle=30.0)
    half = 0.499 * fabric.thickness
    face_down = rotation_matrix((1.0, 0.0, 0.0), math.pi)
    wander = PathMotion(
        (0.0, 0.5, 1.0), ((0.0, 0.0, 0.0), (0.01, 0.0, 0.02), (0.02, 0.01, 0.0)),
        Rotation((0.0, 1.0, 0.0), (0.0, 0.0, -0.01), (0.0, 1.0), (0.0, 7200.0), at_rest=False),
        Stroke((0.0, 1.0), (0.0, 0.1)), at_rest=False,
    )  # fmt: skip
    rocks = Rotation((0.0, 1.0, 0.0), (0.0, 0.0, half), (0.0, 1.0), (0.0, 90.0), at_rest=False)
    tools = (
        Tool("drum", Capsule(0.01, 0.03, origin=(0.0, 0.0, -0.01 - half)), wander, ViscousFilm(5.0, 1e-3, 0.1)),
        Tool("weight", Plane(origin=(0.0, 0.0, half), rotation=face_down),
             PathMotion(rotation=rocks, along=ForceDriven.constant(2.0, 0.01)), axis=(0.0, 0.0, -1.0)),
    )  # fmt: skip
    world = World((Sheet(blank, fabric),), tools, dynamics=Dynamics(damping=10.0, contact_samples="surface"))
    back = PathMotion((0.0, 1e-3), ((0.0, 0.0, 0.0), (0.0, 0.0, 1e-4)))
    stages = (Stage("on", 4.0e-4, frame_count=2), Stage("back", 4.0e-4, moves={"drum": back}, frame_count=2))
    return Setup(name="carried", worlds=(world,), stages=stages, solver=solver, accept_unusual=True)


def pulled(solver: Solver) -> Setup:
    """A sheet with edges that are held, driven smoothly and driven along knots, and with loads."""
    blank = Blank.rectangle((0.0, 0.0), (0.04, 0.02), 0.005)
    x, y = blank.node_position[:, :2].T
    sideways = np.column_stack([np.zeros(3), np.linspace(0.0, 1.0, 3), np.zeros(3)])
    supports = (
        Support("held", np.flatnonzero(x < 1e-9)),
        Support("pulled", np.flatnonzero(x > 0.04 - 1e-9), (
            Drive(SmoothStroke.ramped(0.004, 1.0, 0.001), (1.0, 0.0, 0.0)),
            Drive(Stroke((0.0, 1e-3), (0.0, 1e-3)), (0.0, 0.0, 1.0)),
        )),
        Support("guided", np.flatnonzero(np.abs(x - 0.02) < 1e-9)[:3],
                (Drive(Stroke((0.0, 1e-3), (0.0, 2e-4)), sideways),), displacements="y", rotations=""),
    )  # fmt: skip
    force = 0.01 * np.column_stack([np.zeros_like(x), np.zeros_like(x), y])
    loads = NodalLoads(force=force, couple=1e-4 * force[:, ::-1], times=(0.0, 1e-3), shares=(0.2, 1.0))
    pressures = (
        Pressure.ramped("top", 2e3, 1e-3),
        Pressure("bottom", (1e3, -5e2), (0.0, 1e-3), elements=np.array([1, 4, 7])),
    )
    pulling = Stroke((0.0, 1e-3), (0.0, 2e-3))
    grippers = (
        Gripper(
            "slipping", np.flatnonzero(y > 0.02 - 1e-9)[2:5], (0.0, 1.0, 0.5), 2e4, largest_force=3.0, motion=pulling
        ),
        Gripper("tight", np.array([30]), (0.0, 0.0, 1.0), 1e3, pretension=1.0, ramp_time=1e-3, release_time=2e-3),
    )
    sheet = Sheet(blank, glass_polypropylene(), supports=supports, loads=loads, pressures=pressures, grippers=grippers)
    return Setup(name="pulled", sheets=(sheet,), duration=1.0, symmetry=("y",), solver=solver)


def two_worlds(solver: Solver) -> Setup:
    """Two sheets of different fabrics under separate tools, and two under the same ones."""
    first, second = pressed(solver, [Sphere(0.02, origin=(0.0, 0.0, -0.0206))]), pulled(solver)
    sheet = first.sheet
    lower = sheet.blank.node_position - (0.0, 0.0, 0.002)
    below = Sheet(Blank.from_mesh(lower, sheet.blank.quads), glass_polypropylene(), name="below", orientation=45.0)
    return Setup(
        name="worlds",
        worlds=(
            World((sheet.model_copy(update={"name": "above"}), below), first.tools[1:], name="stack"),
            second.worlds[0].model_copy(update={"name": "alone"}),
        ),
        duration=1.0,
        solver=solver,
    )


def in_stages(solver: Solver) -> Setup:
    """Two worlds whose process has stages that end in every way, and change all that a stage can change."""
    setup = two_worlds(solver)
    half = Stroke((0.0, 1.0e-3), (0.0, 2.0e-4))
    stages = (
        Stage("close", 4.0e-4, AtForce("weight", 1.0e-3), tools=("weight",), frame_count=2),
        Stage(
            "hold", 4.0e-4, AtStroke("far", 5.0e-5),
            tools=("weight", "far"), supports=("held", "guided"), grippers=("slipping",),
            moves={"far": half, "weight": ForceDriven.constant(1.0, 0.01), "slipping": half, "held": half},
            pressures=(SheetPressure(Pressure.ramped("bottom", 1.0e3, 1.0e-4), "sheet"),),
            gravity=(0.0, 0.0, -5.0), damping=50.0, director_damping=1.0, frame_count=1,
        ),
        Stage(
            "release", 5.0e-4, AtRest(10.0, 100.0),
            tools=(), supports=("held", "pulled"), grippers=(), target_step=2.0e-6, frame_count=2,
            friction={"far": PressureFriction((0.0, 1.0e4), (0.3, 0.1))},
            loads=(SheetLoads(NodalLoads(np.full((45, 3), 1e-3), times=(1e-4,)), "sheet"),),
            trims=(
                Trim([(-1.0, -1.0), (0.008, -1.0), (0.008, 1.0), (-1.0, 1.0)], "above"),
                Trim([(0.031, -1.0), (1.0, -1.0), (1.0, 1.0), (0.031, 1.0)], "sheet", "blank", "outside"),
            ),
        ),
        Stage("carry on", 2.0e-4, tools=("far",), moves={"far": Fixed()}, frame_count=1),
    )  # fmt: skip
    held = Drive(SmoothStroke.ramped(1.0e-4, 1.0, 1.0e-5), (-1.0, 0.0, 0.0))
    worlds = []
    for world in setup.worlds:
        sheets = []
        for sheet in world.sheets:
            supports = [
                support.model_copy(update={"drives": (held,)}) if support.name == "held" else support
                for support in sheet.supports
            ]
            sheets.append(sheet.model_copy(update={"supports": tuple(supports)}))
        worlds.append(world.model_copy(update={"sheets": tuple(sheets)}))
    return Setup(name="stages", worlds=tuple(worlds), stages=stages, solver=solver, accept_unusual=True)


def stacked(solver: Solver) -> Setup:
    """Small plies of different meshes, pressed together and sliding, with a friction law of every kind between them."""
    fabric = glass_polypropylene()
    laws = (
        Coulomb(0.3), PressureFriction((0.0, 1e4), (0.5, 0.2)), YarnAngleFriction((0.0, 90.0), (0.1, 0.4)),
        StribeckFriction((0.0, 1e-3, 1.0), (0.3, 0.1, 0.2), 200.0), ViscousFilm(500.0, 1e-4, 0.1),
    )  # fmt: skip
    sheets = []
    for k in range(len(laws) + 1):
        blank = Blank.rectangle(
            (-0.02, -0.02), (0.02, 0.02), (0.01, 0.008)[k % 2], yarn_angle=15.0 * k, height=0.999 * k * fabric.thickness
        )
        velocity = np.tile((0.3 * (-1.0) ** k, 0.1 * k, -0.2 * k), (blank.node_count, 1))
        sheets.append(Sheet(blank, fabric, name=f"ply {k}", initial_velocity=velocity))
    interfaces = tuple(Interface(f"ply {k}", f"ply {k + 1}", law) for k, law in enumerate(laws))
    return Setup(
        name="stacked", sheets=tuple(sheets), interfaces=interfaces, duration=1.0, solver=solver, accept_unusual=True
    )


def folded(solver: Solver) -> Setup:
    """A folded strip whose legs touch, and close farther, with friction."""
    fabric = plain_fabric()
    blank = fold_blank(4.0 * fabric.thickness, 20.0 * fabric.thickness, 0.999 * fabric.thickness)
    velocity = np.where(blank.node_position[:, 2:] > 0.5 * fabric.thickness, (0.2, 0.1, -0.5), 0.0)
    sheet = Sheet(blank, fabric, initial_velocity=velocity, self_contact=SelfContact(Coulomb(0.3)))
    return Setup(name="folded", sheets=(sheet,), duration=1.0, solver=solver, accept_unusual=True)


def every_kind() -> dict[str, Setup]:
    """By name; fails if a registered kind is in none of them."""
    fabric, blank = glass_polypropylene(), saddle()
    half = 0.499 * fabric.thickness
    cases = {f"cell: {name}": thrown(plain_fabric(unit_cell=make()), blank) for name, make in _cells()}
    cases |= {f"law: {name}": thrown(plain_fabric(**given), blank) for name, (given, _) in TERMS.items()}
    cases["every shape and motion"] = pressed(ONE_LANE, shapes(-half), 0.36)
    ball = Sphere(0.02, origin=(0.0, 0.0, -0.02 - half))
    cases["current thickness"] = pressed(ONE_LANE, [ball], contact_thickness="current")
    cases["supports and loads"] = pulled(ONE_LANE)
    cases["carried tools"] = carried(ONE_LANE)
    cases["worlds"] = two_worlds(ONE_LANE)
    cases["worlds in lanes"] = two_worlds(IN_LANES)
    cases["stages"] = in_stages(ONE_LANE)
    cases["plies"] = stacked(ONE_LANE)
    cases["plies in lanes"] = stacked(IN_LANES)
    cases["self-contact"] = folded(ONE_LANE)
    found = {kind for setup in cases.values() for kind in _kinds_in(setup)}
    kinds = {kind for family in Kinded.__subclasses__() for kind in family.kinds().values()}
    own = {kind.__name__ for kind in kinds if kind.__module__.startswith("weavesim.")}
    assert own <= found, f"no set-up has {', '.join(sorted(own - found))}"
    return cases


def _cells():
    return [(name, registered.make) for name, registered in CELLS.items()]


def _kinds_in(value: object) -> set[str]:
    """Names of the kinds of all values within a value."""
    if isinstance(value, tuple | list):
        return set().union(*map(_kinds_in, value)) if value else set()
    if not hasattr(value, "model_fields_set"):
        return set()
    own = {type(value).__name__}
    return own.union(*(_kinds_in(getattr(value, name)) for name in type(value).model_fields))
