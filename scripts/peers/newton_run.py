"""One of Newton's solvers on the drape; imported in the interpreter that has Newton."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .contestants import Peer
from .problem import Problem

CONTACT_STIFFNESS = 1.0e3  # of Newton's soft contact [N/m]
FRAME = 1.0 / 60.0  # of Newton's examples [s]
# Explicit step over that of a wave along an edge: 0.9 (as in weavesim) of 0.694, where a grid of right-angled triangles
# with lumped masses, isotropic with a Poisson ratio of 0, loses its stability (largest eigenvalue, found numerically).
EXPLICIT_STEP = 0.9 * 0.694
BLOCK = 10  # steps between two checks of the clock; even, as recorded steps swap two states


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
        # Style3D needs the host in every step: its examples record it on a GPU only
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
            # Lame's constants; VBD itself adds the first to the second
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
            model.particle_grid = None  # no contact between particles; XPBD requires it
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
        """Simulated time [s]."""
        return self.step_count * self._step

    def advance(self) -> None:
        """Do a block of steps; the first compiles, the second is recorded where possible."""
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
    """Air drag of weavesim's scene: a force against each node's velocity."""

    def drag(velocity, mass, rate, force):
        i = wp.tid()
        force[i] = -rate * mass[i] * velocity[i]

    drag.__annotations__ = {
        "velocity": wp.array(dtype=wp.vec3), "mass": wp.array(dtype=wp.float32), "rate": wp.float32,
        "force": wp.array(dtype=wp.vec3),
    }  # fmt: skip
    return wp.Kernel(drag, module=wp.get_module("peers_drag"))
