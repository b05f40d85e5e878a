"""Static equilibrium by dynamic relaxation: the sheet moves until damping brings it to rest."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..device import exclusive
from ..engine.sheet_model import SheetModel
from ..engine.state import SheetState, State
from ..errors import InputError, RunError
from ..kernels.rows import VELOCITY_REMAINDER, ClockEntry, LoadRow, MotionRow, NodeWorkRow
from .simulation import Simulation

# Number of stops from which the lowest frequency is determined, before viscous damping takes over.
STOP_COUNT = 3
# With critical damping every vibration decays as exp(-w t): after this w t the frequency is determined again.
LONGEST_DECAY = 30.0


@dataclass(frozen=True)
class Equilibrium:
    """How a relaxation ended.

    Attributes:
        residual: sum of the unbalanced nodal forces over that of the applied ones.
        step_count: time steps of the relaxation.
        frequency: lowest angular frequency found [rad/s].
    """

    residual: float
    step_count: int
    frequency: float


@exclusive()
def relax(simulation: Simulation, *, tolerance: float = 1.0e-3, largest_step_count: int = 500_000) -> Equilibrium:
    """Bring a simulation to rest under the current loads, supports and tools.

    The residual counts the nodes; the imbalance of a tool that is moved by a force is not part of it.

    First by kinetic damping: the sheet moves freely until its kinetic energy passes a peak, where it is stopped. The
    time from rest to the peak is a quarter of a period, which gives the lowest frequency w. Then mass-proportional
    damping at the rate 2 w, critical for that frequency, removes all vibrations at the same rate. Neither changes the
    static solution (except for friction, which is path-dependent); the energy removed is booked as ``damping_loss``.

    It may follow ``simulation.run()``, which brings loads and tools to their final values, or replace it. At the end a
    frame is taken: ``simulation.frame``, and the last entry of ``simulation.history``.

    Args:
        simulation: on any device.
        tolerance: for ``Equilibrium.residual``. The applied forces are the larger of loads plus weight, and the
            reactions of supports and tools; couples are divided by the largest extent of the blank.
        largest_step_count: limit after which to give up.

    Raises:
        InputError: a tolerance or a number of steps that is not positive.
        RunError: no rest within ``largest_step_count`` steps, or the state became non-finite.
    """
    if not tolerance > 0.0 or largest_step_count < 1:
        raise InputError(
            f"relax: tolerance = {tolerance} and largest_step_count = {largest_step_count}; both must be positive"
        )
    relaxation = _Relaxation(simulation, tolerance, largest_step_count)
    try:
        while relaxation.residual > tolerance:
            relaxation.find_frequency()
            relaxation.damp()
    finally:
        simulation.stepper.set_damping(None)
    simulation.take_frame()
    return Equilibrium(relaxation.residual, relaxation.step_count, relaxation.frequency)


class _Relaxation:
    def __init__(self, simulation: Simulation, tolerance: float, largest_step_count: int) -> None:
        self.simulation, self.tolerance, self.largest_step_count = simulation, tolerance, largest_step_count
        self.first_step, self.residual, self.frequency = simulation.stepper.step_count, math.inf, 0.0
        self.damping = 0.0
        tools = simulation.setup.tools
        self.driven = np.array([tool.motion.by_force for tool in tools], dtype=bool)
        self.tool_mass = np.array([tool.motion.driven_mass for tool in tools])

    @property
    def step_count(self) -> int:
        return self.simulation.stepper.step_count - self.first_step

    def set_damping(self, rate: float) -> None:
        self.damping = rate
        self.simulation.stepper.set_damping(rate)

    def advance(self) -> None:
        if self.step_count >= self.largest_step_count:
            raise RunError(
                f"relax: after {self.step_count} steps the residual is {self.residual:.3g} of the applied forces, "
                f"above {self.tolerance:g}: allow more steps or a larger tolerance; a sheet that can move freely never "
                "comes to rest, and for stiff sheets under small loads rounding may limit the residual (use float64)"
            )
        self.simulation.stepper.advance(1)

    def find_frequency(self) -> None:
        """Kinetic damping, until the motion has been stopped a few times or the sheet is at rest."""
        self.set_damping(0.0)
        longest = 0.0
        for _ in range(STOP_COUNT):
            start, previous = self.simulation.state.time, -1.0
            while (kinetic := self.kinetic()) > previous:
                previous = kinetic
                self.advance()
            if not math.isfinite(kinetic):
                raise RunError(f"relax: the state became non-finite after {self.step_count} steps")
            longest = max(longest, self.simulation.state.time - start)
            self.stop()
            if self.residual <= self.tolerance:
                break
        # near rest the motion is only fast rounding noise: the frequency found in motion is kept
        found = 0.5 * math.pi / longest
        self.frequency = min(self.frequency, found) if self.frequency else found

    def damp(self) -> None:
        """Critical damping of the lowest frequency, until the sheet is at rest or that frequency is doubtful."""
        if self.residual <= self.tolerance:
            return
        self.set_damping(2.0 * self.frequency)
        end = self.simulation.state.time + LONGEST_DECAY / self.frequency
        block = 1
        while self.residual > self.tolerance and self.simulation.state.time < end:
            for _ in range(block):
                self.advance()
            self.evaluate()
            block = min(block + 1, 20)
        self.stop()

    def kinetic(self) -> float:
        """Kinetic energy of the free components half a step ago [J]."""
        total = 0.0
        for sheet, own in zip(self.simulation.model.sheets, self.simulation.state.sheets, strict=True):
            velocity, spin = rates(sheet, own)
            total += 0.5 * float(
                sheet.node_mass @ np.square(velocity * sheet.free[:, :3]).sum(axis=1)
                + sheet.node_inertia @ np.square(spin).sum(axis=1)
            )
        return total

    def evaluate(self) -> tuple[State, list[_Change]]:
        """Compute the residual. Returns the state after the next step, and its changes in every sheet."""
        model, stepper, state = self.simulation.model, self.simulation.stepper, self.simulation.state
        mean_step = float(state.clock.numpy()[ClockEntry.mean_step])
        ahead = stepper.look_ahead()
        changes = []
        unbalanced = applied = borne = 0.0
        for index, sheet in enumerate(model.sheets):
            free, extent = sheet.free[:, :3], np.ptp(sheet.blank.node_position, axis=0).max()
            velocity, spin = rates(sheet, state.sheets[index])
            next_velocity, next_spin = rates(sheet, ahead.sheets[index])
            change, turn = next_velocity - velocity, next_spin - spin
            changes.append(_Change(velocity, change, spin, turn))
            # without the damping force, which vanishes with the motion
            acceleration = change / mean_step + self.damping * np.where(free, velocity + 0.5 * change, 0.0)
            turning = turn / mean_step + self.damping * (spin + 0.5 * turn)
            unbalanced += size(sheet.node_mass[:, None] * acceleration, sheet.node_inertia[:, None] * turning, extent)
            loads = applied_loads(sheet, state.time)
            applied += size(loads[LoadRow.force], loads[LoadRow.couple], extent)
            # reactions of supports
            forces = sheet.nodal_forces(ahead.sheets[index].corner_force) + loads[LoadRow.force]
            borne += float(np.linalg.norm(np.where(free, 0.0, forces), axis=1).sum())
        borne += float(np.linalg.norm(state.tool_force.numpy(), axis=1).sum()) if len(self.driven) else 0.0
        self.residual = unbalanced / max(applied, borne, 1.0e-300)
        if not math.isfinite(self.residual):
            raise RunError(f"relax: the state became non-finite after {self.step_count} steps")
        return ahead, changes

    def stop(self) -> None:
        """Stop the motion and book its energy as damped.

        The velocities become those half a step before a start from rest. With zeros the next half step would be a whole
        one, and vibrations near the stable limit would grow from stop to stop.
        """
        ahead, changes = self.evaluate()
        state, of_tools = self.simulation.state, self.stop_tools(ahead)
        for sheet, own, later, change in zip(
            self.simulation.model.sheets, state.sheets, ahead.sheets, changes, strict=True
        ):
            book(own, later, change.energy(sheet), of_tools)
            of_tools = 0.0
            count, free = sheet.blank.node_count, sheet.free[:, :3]
            motion = sheet.read_motion(own.motion)
            motion[MotionRow.velocity.vector, :count][free] = -0.5 * change.velocity_change[free]
            motion[VELOCITY_REMAINDER] = 0.0
            motion[MotionRow.spin.vector, :count] = -0.5 * change.spin_change
            sheet.write_motion(own.motion, motion)

    def stop_tools(self, ahead: State) -> float:
        """The same for force-driven tools; returns the energy that they lose [J]."""
        if not self.driven.any():
            return 0.0
        state = self.simulation.state
        speed, next_speed = state.tool_velocity.numpy(), ahead.tool_velocity.numpy()
        state.tool_velocity.assign(np.where(self.driven, 0.5 * (speed - next_speed), speed))
        return 0.125 * float(self.tool_mass @ np.square(speed + next_speed))


@dataclass(frozen=True)
class _Change:
    """Rates of the nodes of a sheet half a step ago, and their change in the next step."""

    velocity: np.ndarray
    velocity_change: np.ndarray
    spin: np.ndarray
    spin_change: np.ndarray

    def energy(self, sheet: SheetModel) -> np.ndarray:
        """Kinetic energy of every node at the instant of the positions, (node_count,) [J]."""
        velocity, change, spin, turn = self.velocity, self.velocity_change, self.spin, self.spin_change
        return 0.5 * (
            sheet.node_mass * ((velocity * (velocity + change) + 0.25 * change**2) * sheet.free[:, :3]).sum(axis=1)
            + sheet.node_inertia * (spin * (spin + turn) + 0.25 * turn**2).sum(axis=1)
        )


def rates(sheet: SheetModel, state: SheetState) -> tuple[np.ndarray, np.ndarray]:
    """Velocities [m/s] and spins [rad/s] of the nodes, (node_count, 3) each."""
    vectors = sheet.read_motion(state.motion)[:, : sheet.blank.node_count].astype(np.float64)
    return vectors[MotionRow.velocity.vector], vectors[MotionRow.spin.vector]


def size(forces: np.ndarray, couples: np.ndarray, extent: float) -> float:
    """Sum of the magnitudes of forces [N], and of couples over a length [m]."""
    return float(np.linalg.norm(forces, axis=1).sum() + np.linalg.norm(couples, axis=1).sum() / extent)


def applied_loads(sheet: SheetModel, time: float) -> np.ndarray:
    """Loads and weight of the nodes, rows LoadRow, (rows, node_count, 3) [N], [N m]."""
    loads = np.zeros((LoadRow.row_count(), sheet.blank.node_count, 3))
    if sheet.loads is not None:
        loads += sheet.loads.share(time) * sheet.loads.arrays(sheet.blank.node_count)
    loads[LoadRow.force] += sheet.node_mass[:, None] * np.array(sheet.dynamics.gravity)
    return loads


def book(state: SheetState, ahead: SheetState, damped: np.ndarray, of_tools: float) -> None:
    """Update the work entries of the nodes to this instant, as the ledger reads them, and add the damped energy [J]."""
    # the next step starts from rest
    works = 0.5 * (state.works() + ahead.works())
    works[NodeWorkRow.damping_loss] += damped.sum() + of_tools
    state.set_works(works)
