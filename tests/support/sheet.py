"""A sheet whose nodes are put anywhere by hand, and that answers with forces and energies."""

import numpy as np

from tests.support.runs import one_sheet_run
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.fabric import Fabric, Stabilisation
from weavesim.fabric.shear import LinearShear
from weavesim.kernels.rows import CornerRow, MotionRow
from weavesim.sheet.blank import Blank

POSITION, DIRECTOR, REMAINDER = MotionRow.position.vector, MotionRow.director.vector, MotionRow.remainder.vector
NO_STABILISATION = Stabilisation(in_plane=0.0, warping=0.0, director=0.0)


def plain_fabric(**given) -> Fabric:
    """A weak linear membrane and nothing else, unless ``given``."""
    values = {
        "name": "test", "areal_density": 0.5, "thickness": 1.0e-3,
        "unit_cell": PlainWeave.straight(stiffness_per_width=1000.0),
        "shear": LinearShear(modulus=0.0), "bending": IsotropicBending(modulus=0.0),
        "transverse_shear_modulus": 0.0, "stabilisation": NO_STABILISATION,
    }  # fmt: skip
    return Fabric(**(values | given))


class Sheet:
    """One element kernel of double precision, driven by hand.

    Attributes:
        simulation: never run by this class.
        node_count: of the blank.
    """

    def __init__(self, blank: Blank, fabric: Fabric, *, precision: str = "float64", lane_count: int = 1) -> None:
        self.simulation = one_sheet_run(
            name="test",
            blank=blank,
            fabric=fabric,
            duration=1.0,
            precision=precision,
            lane_count=lane_count,
            threads=1,
            accept_unusual=True,
        )
        self.node_count = blank.node_count
        self._quads = blank.quads
        self._start = self.simulation.model.sheet.initial_motion()

    def place(self, position: np.ndarray, director: np.ndarray, *, fresh: bool = True) -> None:
        """Set positions (n, 3) [m] and unit directors (n, 3); ``fresh`` unit cells start from rest."""
        motion = self._start.copy()
        motion[POSITION, : self.node_count], motion[DIRECTOR, : self.node_count] = position, director
        held = motion.astype(self.simulation.model.precision.numpy)
        motion[REMAINDER] += motion[POSITION] - held[POSITION]
        model, state = self.simulation.model.sheet, self.simulation.state.sheet
        model.write_motion(state.motion, motion)
        if fresh:
            self.simulation.state.sheet.cell_unknowns.zero_()
            self.simulation.state.sheet.slip.zero_()
        # a run takes the nodes' mean shear angles from the step before; here they belong to these positions
        self.simulation.stepper.evaluate()
        angle = self._corners()[2, 0, 0]
        sharing = np.bincount(self._quads.ravel())
        mean_angle = np.bincount(self._quads.ravel(), weights=np.repeat(angle, 4)) / sharing
        model.write_motion(state.motion, model.read_motion(state.motion), mean_angle)

    def _corners(self) -> np.ndarray:
        """Forces, director gradients and angles, (3, corner, component, element)."""
        rows = self.simulation.model.sheet.corner_rows(self.simulation.state.sheet.corner_force).astype(np.float64)
        # the angle is in all corners
        force, couple, angle = (rows[:, row.span] for row in (CornerRow.force, CornerRow.couple, CornerRow.angle))
        return np.stack([force, couple, np.broadcast_to(angle, force.shape)])

    def forces(
        self, position: np.ndarray, director: np.ndarray, *, fresh: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """Nodal forces [N] and minus the energy's derivative by the directors [J], (n, 3) each."""
        self.place(position, director, fresh=fresh)
        self.simulation.stepper.evaluate()
        result = np.zeros((2, self.node_count, 3))
        for kind, corners in enumerate(self._corners()[:2]):
            for corner in range(4):
                np.add.at(result[kind], self._quads[:, corner], corners[corner].T)
        return result[0], result[1]

    def energies(self, position: np.ndarray, director: np.ndarray) -> dict[str, float]:
        """The ledger's entries [J]."""
        self.place(position, director)
        return self.simulation.ledger.frame(0).energies

    def stiffness(self, position: np.ndarray, director: np.ndarray, change: float) -> np.ndarray:
        """Tangent by central differences, over 3 displacements [m] and 2 director turns [rad] of each node.

        Directors turn about two axes across themselves; rows and columns go node by node.
        """
        across = [np.cross(director, np.eye(3)[np.argmin(np.abs(director), axis=1)])]
        across[0] /= np.linalg.norm(across[0], axis=1)[:, None]
        across.append(np.cross(director, across[0]))

        def gradient(x, d):
            force, conjugate = self.forces(x, d)
            turning = -np.cross(d, conjugate)
            return np.column_stack([-force, *(np.einsum("ij,ij->i", turning, axis)[:, None] for axis in across)])

        columns = []
        for node in range(self.node_count):
            for component in range(5):
                ends = []
                for sign in (1.0, -1.0):
                    x, d = position.copy(), director.copy()
                    if component < 3:
                        x[node, component] += sign * change
                    else:
                        d[node] = turned(d[node], across[component - 3][node], sign * change)
                    ends.append(gradient(x, d).ravel())
                columns.append((ends[0] - ends[1]) / (2.0 * change))
        return np.array(columns).T


def turned(vector: np.ndarray, axis: np.ndarray, angle: float) -> np.ndarray:
    """``vector`` turned about a unit ``axis`` across it."""
    return np.cos(angle) * vector + np.sin(angle) * np.cross(axis, vector)
