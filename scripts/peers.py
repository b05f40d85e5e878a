"""weavesim beside Newton's cloth solvers on one drape: a square of fabric falls on a ball.

    python scripts/benchmark.py peers --newton-python newton-environment/bin/python

Each contestant runs alone in a process of its own on one CPU thread, or on the device that is asked for. All get the
same nodes, masses, initial velocity, gravity, drag of the air, ball and simulated time. A quadrilateral of weavesim is
two triangles in Newton. Self-contact is off, since weavesim has none; XPBD, which cannot do without, has contact among
beads on the nodes, as thick as the fabric.

What Newton's solvers are given follows its example ``cloth_hanging``, which runs VBD, XPBD and SemiImplicit, and for
Style3D ``cloth_style3d``, whose garment has the mass of a real one: iterations, time step (ten steps per sixtieth of a
second), collision detection in every step (``cloth_style3d`` looks once in ten), steps recorded as a graph wherever the
example does so. Where that does not carry over:

- Explicit SemiImplicit takes 0.9 of its stable step, as weavesim does, instead of the example's fixed 1/1920 s.
- XPBD diverges with the example's step, as nodes weigh less than a thousandth of the example's. It runs once more with
  the explicit step and the solver's default of two iterations. VBD runs once more with five times the iterations.
- Contact stiffness is Newton's default, 1 kN/m. Damping and friction slope of SemiImplicit's contact follow from it,
  the nodal mass and the step, as the defaults are made for heavier particles.
- No internal damping, as in weavesim; what a solver's time integration loses, it loses.

Materials: Style3D and XPBD (springs along the yarns and both diagonals) take the fabric's stiffness along the yarns and
in shear. The triangles of VBD and SemiImplicit are isotropic: they get the yarns' stiffness with a Poisson ratio of 0,
and so half of it in shear, far too much for a weave. Bending is set hinge by hinge so that a cylinder along
either yarn has the fabric's bending stiffness; in a right-angled grid this is one third of Style3D's own scale.
"""

from __future__ import annotations

import dataclasses
import json
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

CONTACT_STIFFNESS = 1.0e3  # of Newton's soft contact [N/m]
FRAME = 1.0 / 60.0  # of Newton's examples [s]
# Explicit step over that of a wave along an edge: 0.9 (as in weavesim) of 0.694, where a grid of right-angled triangles
# with lumped masses, isotropic with a Poisson ratio of 0, loses its stability (largest eigenvalue, found numerically).
EXPLICIT_STEP = 0.9 * 0.694
BLOCK = 10  # steps between two looks at the clock; even, as recorded steps swap two states
FABRICS = {
    "cloth": "the cloth of the scene hemisphere, in the range of Newton's own examples",
    "glass": "glass/polypropylene weave, crimped",
    "glass-straight": "the same with straight yarns",
}


@dataclasses.dataclass(frozen=True)
class Problem:
    """The drape, in SI units: arrays and numbers only, so that another interpreter can read it.

    Attributes:
        position: flat nodes over the ball, whose centre is the origin, (node_count, 3) [m].
        velocity: initial, (node_count, 3) [m/s].
        quads: corners, (quad_count, 4); the first two lie along the warp.
        membrane, shear, bending: stiffness of the sheet at rest along a yarn, in shear [N/m] and in bending [N m].
        damping: mass-proportional drag [1/s].
    """

    fabric: str
    position: np.ndarray
    velocity: np.ndarray
    quads: np.ndarray
    areal_density: float
    thickness: float
    membrane: float
    shear: float
    bending: float
    radius: float
    friction: float
    gravity: float
    damping: float
    duration: float

    def save(self, path: Path) -> None:
        """Write it as ``.npz``."""
        np.savez(path, **dataclasses.asdict(self))

    @classmethod
    def load(cls, path: Path) -> Problem:
        """Read what ``save`` wrote."""
        with np.load(path) as data:
            return cls(**{name: value if value.ndim else value.item() for name, value in data.items()})

    @property
    def triangles(self) -> np.ndarray:
        """Two for each quadrilateral, (2 quad_count, 3)."""
        return self.quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)

    @property
    def cell_area(self) -> float:
        """Of a quadrilateral [m^2]; all are alike."""
        first, second, _, last = self.position[self.quads[0]]
        return float(np.linalg.norm(np.cross(second - first, last - first)))


# --- the problem ------------------------------------------------------------------------------------------------------


def fabric_of(name: str) -> Any:
    """The Fabric of one of ``FABRICS``."""
    from weavesim.fabric.cell.weaves import PlainWeave
    from weavesim.fabric.presets import glass_polypropylene
    from weavesim.scenes.hemisphere import cloth

    if name == "cloth":
        return cloth("low-bending")
    fabric = glass_polypropylene()
    if name == "glass":
        return fabric
    return fabric.model_copy(
        update={"unit_cell": PlainWeave.straight(stiffness_per_width=fabric.unit_cell.yarn_stiffness_per_width[0])}
    )


def make_problem(fabric_name: str, quads_per_side: int, duration: float) -> Problem:
    """The scene hemisphere with one of ``FABRICS``, on a mesh of ``quads_per_side`` squared elements."""
    from weavesim.fabric.response import respond
    from weavesim.scenes.hemisphere import GRAVITY, unevenness

    fabric = fabric_of(fabric_name)
    parameters, blank = _scene(quads_per_side, fabric.thickness)
    stiffness = respond(fabric.unit_cell, np.array([[1.0 + 1.0e-7, 1.0]])).tangent[0]
    return Problem(
        fabric=fabric_name,
        position=blank.node_position,
        velocity=unevenness(blank, parameters.seed),
        quads=blank.quads,
        areal_density=fabric.areal_density,
        thickness=fabric.thickness,
        # one yarn is pulled and the other one is free
        membrane=float(stiffness[0, 0] - stiffness[0, 1] * stiffness[1, 0] / stiffness[1, 1]),
        shear=fabric.shear.moment_values[1] / fabric.shear.angle[1],
        bending=fabric.bending.stiffness(fabric.thickness),
        radius=parameters.radius,
        friction=parameters.friction,
        gravity=GRAVITY,
        damping=parameters.damping,
        duration=duration,
    )


def _scene(quads_per_side: int, thickness: float) -> tuple[Any, Any]:
    from weavesim.scenes.hemisphere import HemisphereParameters
    from weavesim.sheet.blank import Blank

    parameters = HemisphereParameters()
    half = 0.5 * parameters.side
    size = parameters.side / quads_per_side
    return parameters, Blank.rectangle((-half, -half), (half, half), size, height=parameters.radius + 0.5 * thickness)


# --- accuracy ---------------------------------------------------------------------------------------------------------


def measures(problem: Problem, position: np.ndarray, velocity: np.ndarray) -> dict[str, Any]:
    """What a final state says about accuracy, from its nodes alone.

    Args:
        position, velocity: (node_count, 3) [m], [m/s].

    Returns:
        ``finite``, and if it is: ``largest_edge_stretch`` and ``mean_edge_stretch`` (elongation over rest length of
        the edges along the yarns; the mean is of absolute values), ``largest_yarn_stretch`` (of whole rows of edges
        from rim to rim), ``penetration`` of the lower face into the ball at the deepest node [m], ``corner_drop``, mean
        height that the corners lost [m], ``kinetic_energy`` [J].
    """
    if not (np.isfinite(position).all() and np.isfinite(velocity).all()):
        return {"finite": False}
    side = math.isqrt(len(problem.quads)) + 1
    now, rest = (nodes.astype(np.float64).reshape(side, side, 3) for nodes in (position, problem.position))
    # rows of edges: (edge, yarn) of one family beside the other
    length, rest_length = (
        np.hstack([np.linalg.norm(np.diff(nodes, axis=0), axis=2), np.linalg.norm(np.diff(nodes, axis=1), axis=2).T])
        for nodes in (now, rest)
    )
    edge_stretch = length / rest_length - 1.0
    share = np.bincount(problem.quads.ravel(), minlength=len(position))
    mass = 0.25 * problem.areal_density * problem.cell_area * share
    gap = np.linalg.norm(now, axis=2).min() - problem.radius - 0.5 * problem.thickness
    return {
        "finite": True,
        "largest_edge_stretch": float(edge_stretch.max()),
        "mean_edge_stretch": float(np.abs(edge_stretch).mean()),
        "largest_yarn_stretch": float((length.sum(axis=0) / rest_length.sum(axis=0)).max() - 1.0),
        "penetration": max(0.0, -float(gap)),
        "corner_drop": float((rest - now)[[0, 0, -1, -1], [0, -1, 0, -1], 2].mean()),
        "kinetic_energy": float(0.5 * (mass * (velocity.astype(np.float64) ** 2).sum(axis=1)).sum()),
    }


# --- contestants ------------------------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True)
class Peer:
    """One of Newton's solvers: steps per sixtieth of a second (None: from stability) and iterations per step."""

    solver: str
    steps_per_frame: int | None
    iterations: int | None


PEERS = {
    "Newton VBD": Peer("SolverVBD", 10, 10),
    "Newton VBD, 5 times the iterations": Peer("SolverVBD", 10, 50),
    "Newton Style3D": Peer("SolverStyle3D", 10, 4),
    "Newton XPBD": Peer("SolverXPBD", 10, 10),
    "Newton XPBD, explicit step": Peer("SolverXPBD", None, 2),
    "Newton SemiImplicit": Peer("SolverSemiImplicit", None, None),
}
OURS = {"weavesim float32": "float32", "weavesim float64": "float64"}
CONTESTANTS = (*OURS, *PEERS)


class WeavesimRun:
    """weavesim on one thread; ``state`` is positions and velocities of the nodes."""

    def __init__(self, problem: Problem, precision: str, device: str) -> None:
        from weavesim.engine.setup import Setup, Solver
        from weavesim.process.dynamics import Dynamics
        from weavesim.run.simulation import Simulation
        from weavesim.scenes.hemisphere import DIRECTOR_DAMPING
        from weavesim.sheet.sheet import Sheet
        from weavesim.tools.shapes import Sphere
        from weavesim.tools.tool import Tool

        _, blank = _scene(math.isqrt(len(problem.quads)), problem.thickness)
        setup = Setup(
            "peers",
            sheets=(Sheet(blank, fabric_of(problem.fabric), initial_velocity=problem.velocity),),
            tools=(Tool("ball", Sphere(problem.radius), friction=problem.friction),),
            dynamics=Dynamics(
                gravity=(0.0, 0.0, -problem.gravity), damping=problem.damping, director_damping=DIRECTOR_DAMPING
            ),
            duration=problem.duration,
            solver=Solver(device=device, precision=precision, threads=1),
        )
        self._simulation = Simulation(setup)
        self.element_count, self.element, self.iterations = len(problem.quads), "quadrilaterals", None
        self._duration, self._block_count = problem.duration, 1

    @property
    def time(self) -> float:
        """Simulated [s]."""
        return float(self._simulation.state.time)

    @property
    def step_count(self) -> int:
        """Steps done."""
        return self._simulation.stepper.step_count

    def advance(self) -> None:
        """Some blocks of steps, more of them each time, and none beyond the end but the last."""
        from weavesim.engine.stepper import REFRESH_INTERVAL

        stepper, remaining = self._simulation.stepper, self._duration - self.time
        left = math.ceil(remaining / (REFRESH_INTERVAL * float(self._simulation.state.step)))
        stepper.advance(max(1, min(self._block_count, left)))
        self._block_count = min(2 * self._block_count, 50)

    def state(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions and velocities, (node_count, 3)."""
        from weavesim.kernels.rows import MotionRow

        rows = self._simulation.model.sheet.read_motion(self._simulation.state.sheet.motion)
        count = self._simulation.setup.sheet.blank.node_count
        return rows[MotionRow.position.vector, :count], rows[MotionRow.velocity.vector, :count]


class NewtonRun:
    """One of Newton's solvers on the drape."""

    def __init__(self, problem: Problem, peer: Peer, device: str) -> None:
        import newton
        import warp as wp

        wp.config.quiet = True
        wp.set_device(device)
        self._warp = wp
        self.element_count, self.element, self.iterations = len(problem.triangles), "triangles", peer.iterations
        cell = problem.cell_area
        if peer.steps_per_frame is None:
            step = EXPLICIT_STEP * math.sqrt(cell * problem.areal_density / problem.membrane)
        else:
            step = FRAME / peer.steps_per_frame
        self.planned_count = BLOCK * math.ceil(problem.duration / (step * BLOCK) - 1.0e-9)
        self._step = problem.duration / self.planned_count
        self.step_count = 0
        nodal_mass = problem.areal_density * cell
        if peer.solver == "SolverSemiImplicit":
            contact_damping, friction_slope = math.sqrt(CONTACT_STIFFNESS * nodal_mass), 0.5 * nodal_mass / self._step
        else:
            contact_damping, friction_slope = 0.0, 0.0
        self.model = self._build(newton, problem, peer.solver, contact_damping, friction_slope)
        self._solver = self._make_solver(newton, peer)
        self._states = [self.model.state(), self.model.state()]
        self._states[0].particle_qd.assign(problem.velocity.astype(np.float32))
        self._control = self.model.control()
        self._pipeline = newton.CollisionPipeline(self.model)
        self._contacts = self._pipeline.contacts()
        self._drag = drag_kernel(wp)
        self._drag_rate = problem.damping
        # Style3D asks the host in every step: its examples record it on a GPU only
        self._may_record = peer.solver != "SolverStyle3D" or self.model.device.is_cuda
        self._graph = None

    def _build(self, newton: Any, problem: Problem, solver: str, contact_damping: float, friction_slope: float) -> Any:
        wp = self._warp
        builder = newton.ModelBuilder()
        common = {
            "pos": wp.vec3(0.0), "rot": wp.quat_identity(), "scale": 1.0, "vel": wp.vec3(0.0),
            "vertices": problem.position.tolist(), "indices": problem.triangles.ravel().tolist(),
            "density": problem.areal_density, "particle_radius": 0.5 * problem.thickness,
        }  # fmt: skip
        membrane, shear, bending = problem.membrane, problem.shear, problem.bending
        if solver == "SolverStyle3D":
            newton.solvers.SolverStyle3D.register_custom_attributes(builder)
            newton.solvers.style3d.add_cloth_mesh(
                builder,
                tri_aniso_ke=wp.vec3(membrane, membrane, shear),
                edge_aniso_ke=wp.vec3(bending / 3.0),
                **common,
            )
        else:
            # Lame's constants; VBD adds the first one to the second one itself
            second = 0.0 if solver == "SolverVBD" else 0.5 * membrane
            builder.add_cloth_mesh(tri_ke=0.5 * membrane, tri_ka=second, tri_kd=0.0, edge_ke=1.0, edge_kd=0.0, **common)
        if solver == "SolverXPBD":
            self._add_springs(builder, problem)
        if solver == "SolverVBD":
            builder.color(include_bending=True)
        surface = builder.default_shape_cfg.copy()
        surface.ke, surface.kd, surface.kf, surface.mu = (
            CONTACT_STIFFNESS, contact_damping, friction_slope, problem.friction,
        )  # fmt: skip
        builder.add_shape_sphere(-1, radius=problem.radius, cfg=surface)
        model = builder.finalize()
        model.set_gravity((0.0, 0.0, -problem.gravity))
        model.soft_contact_ke, model.soft_contact_kd = CONTACT_STIFFNESS, contact_damping
        model.soft_contact_kf, model.soft_contact_mu = friction_slope, problem.friction
        if solver == "SolverSemiImplicit":
            model.particle_grid = None  # no contact among particles; XPBD insists on it
        if solver != "SolverStyle3D":
            # Energy k L angle^2 / 2 of a hinge of length L. XPBD and SemiImplicit take the angle's derivative without
            # the height of the triangles, SemiImplicit with a factor L.
            hinge = bending * model.edge_rest_length.numpy() / problem.cell_area
            if solver == "SolverXPBD":
                hinge *= model.edge_rest_length.numpy() / problem.cell_area
            elif solver == "SolverSemiImplicit":
                hinge /= problem.cell_area
            model.edge_bending_properties.assign(np.column_stack([hinge, np.zeros_like(hinge)]).astype(np.float32))
        return model

    @staticmethod
    def _add_springs(builder: Any, problem: Problem) -> None:
        quads = problem.quads
        sides = np.unique(np.sort(quads[:, [0, 1, 1, 2, 2, 3, 3, 0]].reshape(-1, 2), axis=1), axis=0)
        for pairs, stiffness in ((sides, problem.membrane), (quads[:, [0, 2, 1, 3]].reshape(-1, 2), problem.shear)):
            for first, second in pairs.tolist():
                builder.add_spring(first, second, stiffness, 0.0, control=0.0)

    def _make_solver(self, newton: Any, peer: Peer) -> Any:
        kind = getattr(newton.solvers, peer.solver)
        if peer.solver == "SolverStyle3D":
            solver = kind(model=self.model, config=kind.Config(iterations=peer.iterations))
            solver.collision.stiff_vf = solver.collision.stiff_ee = solver.collision.stiff_ef = 0.0
            return solver
        if peer.solver == "SolverSemiImplicit":
            return kind(model=self.model, enable_tri_contact=False)
        return kind(model=self.model, iterations=peer.iterations)

    def _block(self) -> None:
        for _ in range(BLOCK):
            now, after = self._states
            now.clear_forces()
            self._warp.launch(
                self._drag,
                dim=self.model.particle_count,
                inputs=[now.particle_qd, self.model.particle_mass, self._drag_rate],
                outputs=[now.particle_f],
            )
            self._pipeline.collide(now, self._contacts)
            self._solver.step(now, after, self._control, self._contacts, self._step)
            self._states.reverse()

    @property
    def time(self) -> float:
        """Simulated [s]."""
        return self.step_count * self._step

    def advance(self) -> None:
        """A block of steps; the first one compiles, the second one is recorded where that is possible."""
        wp = self._warp
        if self._graph is not None:
            wp.capture_launch(self._graph)
        else:
            self._block()
            if self._may_record:
                with wp.ScopedCapture() as capture:
                    self._block()
                self._graph = capture.graph
        self.step_count += BLOCK
        wp.synchronize()

    def state(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions and velocities, (node_count, 3)."""
        return self._states[0].particle_q.numpy(), self._states[0].particle_qd.numpy()


def drag_kernel(wp: Any) -> Any:
    """The air of weavesim's scene: a force against each node's velocity."""

    def drag(velocity, mass, rate, force):
        i = wp.tid()
        force[i] = -rate * mass[i] * velocity[i]

    drag.__annotations__ = {
        "velocity": wp.array(dtype=wp.vec3), "mass": wp.array(dtype=wp.float32), "rate": wp.float32,
        "force": wp.array(dtype=wp.vec3),
    }  # fmt: skip
    return wp.Kernel(drag, module=wp.get_module("peers_drag"))


# --- all contestants, one after the other -----------------------------------------------------------------------------


def newton_versions(python: str) -> dict[str, str] | None:
    """Versions of Newton and its Warp in an interpreter, None if it has no Newton; imports neither."""
    code = (
        "import json; from importlib.metadata import version; "
        "print(json.dumps({'newton': version('newton'), 'warp of newton': version('warp-lang')}))"
    )
    try:
        done = subprocess.run([python, "-c", code], capture_output=True, text=True, check=False)
    except OSError:
        return None
    return json.loads(done.stdout) if done.returncode == 0 else None


def compete(
    problem: Problem, contestants: Sequence[str], device: str, limit: float, newton_python: str
) -> Iterator[dict[str, Any]]:
    """Every contestant in a process of its own: what it took and its ``measures``, or the error that stopped it."""
    with tempfile.TemporaryDirectory() as folder:
        problem_file, result_file = Path(folder) / "problem.npz", Path(folder) / "result.npz"
        problem.save(problem_file)
        for name in contestants:
            python = sys.executable if name in OURS else newton_python
            command = [python, __file__, name, str(problem_file), str(result_file), device, str(limit)]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode:
                error = (done.stderr.strip() or f"ended with {done.returncode}").splitlines()[-1]
                yield {"contestant": name, "fabric": problem.fabric, "device": device, "error": error}
                continue
            row = json.loads(done.stdout.splitlines()[-1])
            with np.load(result_file) as result:
                yield row | measures(problem, result["position"], result["velocity"])


def _named(row: dict[str, Any]) -> list[str]:
    return [row["contestant"], row["fabric"]]


def _cost(row: dict[str, Any]) -> list[str]:
    return _named(row) + [
        f"{row['membrane']:.2g}", f"{row['shear']:.2g}", f"{row['bending']:.2g}", f"{row['step_us']:.3g}",
        str(row["iterations"] or ""), f"{row['elements']} {row['element']}", f"{1e-6 * row['rate']:.3g}",
        f"{row['seconds_per_simulated']:.3g}",
    ]  # fmt: skip


def _accuracy(row: dict[str, Any]) -> list[str]:
    if not row["finite"]:
        return [*_named(row), f"{row['simulated_s']:.3g}", "not finite"]
    percents = [row[name] for name in ("largest_yarn_stretch", "largest_edge_stretch", "mean_edge_stretch")]
    thousandths = [row[name] for name in ("penetration", "corner_drop", "kinetic_energy")]
    values = [*(100.0 * value for value in percents), *(1e3 * value for value in thousandths)]
    return [*_named(row), f"{row['simulated_s']:.3g}", *(f"{value:.2g}" for value in values)]


def report(rows: list[dict[str, Any]]) -> str:
    """Two Markdown tables, what each contestant was given and took, and how accurate it was; then the errors."""
    done = [row for row in rows if "error" not in row]
    cost = ["contestant", "fabric", "along the yarns [N/m]", "shear [N/m]", "bending [N m]", "step [us]", "iterations"]
    cost += ["elements", "M element-steps/s", "s per simulated s"]
    accuracy = ["contestant", "fabric", "simulated [s]", "largest stretch of a yarn [%]", "of an edge [%]", "mean [%]"]
    accuracy += ["penetration [mm]", "corners fell [mm]", "kinetic energy [mJ]"]
    lines = _table(cost, [_cost(row) for row in done]) + [""] + _table(accuracy, [_accuracy(row) for row in done])
    lines += [f"\n{row['contestant']}, {row['fabric']}: {row['error']}" for row in rows if "error" in row]
    return "\n".join(lines)


def _table(head: list[str], rows: list[list[str]]) -> list[str]:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return lines + ["| " + " | ".join([*row, *[""] * (len(head) - len(row))]) + " |" for row in rows]


# --- one contestant in its own process --------------------------------------------------------------------------------


def race(problem: Problem, contestant: str, device: str, limit: float) -> tuple[dict[str, Any], np.ndarray, np.ndarray]:
    """Run one contestant to the end, to ``limit`` seconds of stepping, or until it is no longer finite.

    On the CPU the clock is that of the process, which leaves out what other programs take: all run on one thread.

    Returns:
        what was measured, and the last positions and velocities. The first block of steps compiles: it is not timed.
    """
    clock = time.process_time if device == "cpu" else time.perf_counter
    started = clock()
    if contestant in OURS:
        run: WeavesimRun | NewtonRun = WeavesimRun(problem, OURS[contestant], device)
    else:
        run = NewtonRun(problem, PEERS[contestant], device)
    run.advance()
    run.state()
    setup = clock() - started
    first_step, first_time, started = run.step_count, run.time, clock()
    elapsed, looked = 0.0, 0.0
    while True:
        run.advance()
        elapsed = clock() - started
        if run.time >= problem.duration * (1.0 - 1.0e-6) or elapsed >= limit:
            break
        if elapsed - looked > 2.0:
            looked = elapsed
            if not np.isfinite(run.state()[0]).all():
                break
    steps, simulated = run.step_count - first_step, run.time - first_time
    row = {
        "contestant": contestant,
        "device": device,
        "fabric": problem.fabric,
        "elements": run.element_count,
        "element": run.element,
        "membrane": problem.membrane,
        "shear": 0.5 * problem.membrane if _isotropic(contestant) else problem.shear,
        "bending": problem.bending,
        "step_us": 1e6 * simulated / steps,
        "iterations": run.iterations,
        "rate": run.element_count * steps / elapsed,
        "seconds_per_simulated": elapsed / simulated,
        "simulated_s": run.time,
        "setup_s": setup,
    }
    return row, *run.state()


def _isotropic(contestant: str) -> bool:
    return contestant in PEERS and PEERS[contestant].solver in ("SolverVBD", "SolverSemiImplicit")


def main(contestant: str, problem_file: str, result_file: str, device: str, limit: str) -> None:
    """Worker: reads a problem, leaves final positions and velocities in a file, and prints a line of JSON."""
    row, position, velocity = race(Problem.load(Path(problem_file)), contestant, device, float(limit))
    np.savez(result_file, position=position, velocity=velocity)
    print(json.dumps(row), flush=True)


if __name__ == "__main__":
    # The checkout comes first for weavesim, as in the other scripts; Newton's interpreter needs nothing from it.
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
    main(*sys.argv[1:])
