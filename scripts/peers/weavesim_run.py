"""weavesim on the drape."""

from __future__ import annotations

import math

import numpy as np

from .problem import Problem, fabric_of, hemisphere_scene


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

        _, blank = hemisphere_scene(math.isqrt(len(problem.quads)), problem.thickness)
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
        """Simulated time [s]."""
        return float(self._simulation.state.time)

    @property
    def step_count(self) -> int:
        """Steps done."""
        return self._simulation.stepper.step_count

    def advance(self) -> None:
        """Do some blocks of steps, more each time; only the last may pass the end."""
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
