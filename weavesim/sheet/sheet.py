"""A sheet: a blank of one fabric, with its constraints and loads."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import Annotated, Self

import numpy as np
from pydantic import model_validator

from ..arrays import BoolArray, FloatArray
from ..checks import Finite, Parameters
from ..fabric.fabric import Fabric, Stabilisation
from ..fabric.proportions import families_alike
from ..names import Label
from ..process.grippers import Gripper
from ..process.loads import NodalLoads
from ..process.pressure import Pressure
from ..process.self_contact import SelfContact
from ..process.supports import Support, check_held_once, prescribe_start
from ..ranges import Quantity
from .blank import Blank
from .symmetry import AXES, Symmetry

# Longest side of a blank [m], from a few elements to a wind turbine's shell in parts.
USUAL_BLANK_SIZE = (2.0e-3, 8.0)
# Thickness over the blank's longest side.
LARGEST_USUAL_THICKNESS = 0.25
# Area of an element on the flat blank over its own, for self-contact; the largest is the inverse.
SMALLEST_FLAT_AREA = 0.5
# Angle of the yarns to a plane of symmetry or to its normal [degrees]: of straight ones, and of ones that curve.
LARGEST_LEAN = 0.1
LARGEST_CURVED_LEAN = 6.0
# Least share of the exact stiffness of the director modes in a sheet that may touch itself, which folds: with a tenth,
# directors swing against each other where elements turn by 15 to 21 degrees (docs/decisions/0081).
DIRECTOR_SHARE_OF_FOLDS = 1.0


class Sheet(Parameters):
    """One sheet of a run.

    Attributes:
        blank: its mesh and yarn directions.
        fabric: its laws.
        name: used in outputs, unique in a run.
        orientation: rotates the yarn directions of the blank about its normal, counter-clockwise [degrees].
        free: (node_count, 6) bool, False where a displacement (x, y, z) or a director's rotation about x, y, z is held;
            None leaves everything free.
        initial_velocity: (node_count, 3) [m/s]; None for rest.
        supports: nodes that are held and possibly driven; they need not be marked in ``free``, and components that
            they hold have their velocity from the start. Their names are unique in a run.
        loads: forces and couples prescribed at nodes.
        pressures: on its faces; those on the same face add up.
        self_contact: contact of the sheet with itself; without it, it passes through itself.
        grippers: springs that pull at its nodes.
    """

    positional = ("blank", "fabric", "name")

    blank: Blank
    fabric: Fabric
    name: Label = "sheet"
    orientation: Annotated[Finite, Quantity("angle")] = 0.0
    free: BoolArray | None = None
    initial_velocity: Annotated[FloatArray, Quantity("speed")] | None = None
    supports: tuple[Support, ...] = ()
    loads: NodalLoads | None = None
    pressures: tuple[Pressure, ...] = ()
    self_contact: SelfContact | None = None
    grippers: tuple[Gripper, ...] = ()

    @model_validator(mode="after")
    def _fits_the_blank(self) -> Self:
        count = self.blank.node_count
        if self.free is not None and self.free.shape != (count, 6):
            raise ValueError(f"free: shape {self.free.shape}, but ({count}, 6) is needed")
        velocity = self.initial_velocity
        if velocity is not None and (velocity.shape != (count, 3) or not np.isfinite(velocity).all()):
            raise ValueError(
                f"initial_velocity: shape {velocity.shape}; finite values of shape ({count}, 3) are needed"
            )
        if self.loads is not None:
            self.loads.arrays(count)
        if self.self_contact is not None:
            self._check_flat_coordinates()
        for pressure in self.pressures:
            pressure.check_elements(self.blank.element_count)
        check_held_once("gripper", self.grippers, count, "a node can have one gripper")
        check_held_once("support", self.supports, count, "a node can have one support (which may have several drives)")
        return self

    @property
    def stabilisation(self) -> Stabilisation:
        """Shares of the hourglass modes: of the fabric; where the sheet may touch itself, all of the directors'."""
        own = self.fabric.stabilisation
        if self.self_contact is None or own.director >= DIRECTOR_SHARE_OF_FOLDS:
            return own
        return own.model_copy(update={"director": DIRECTOR_SHARE_OF_FOLDS})

    def _check_flat_coordinates(self) -> None:
        """Self-contact tells neighbours by their distance on the flat blank."""
        flat = self.blank.material_coordinates[self.blank.quads]
        across = (flat[:, 2] - flat[:, 0])[:, :, None] * (flat[:, 3] - flat[:, 1])[:, None, :]
        # signed: elements that lie upside down on the flat blank lie on others
        area = 0.5 * (across[:, 0, 1] - across[:, 1, 0])
        area *= np.sign(area.sum())
        corner = self.blank.node_position[self.blank.quads]
        formed = 0.5 * np.linalg.norm(np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]), axis=1)
        ratio = area / formed
        if not ((ratio > SMALLEST_FLAT_AREA) & (ratio < 1.0 / SMALLEST_FLAT_AREA)).all():
            element = int(np.argmax(np.abs(np.log(np.maximum(ratio, 1e-12)))))
            name = self.blank.names.element(element)
            raise ValueError(
                f"self_contact: element {name} has {ratio[element]:.3g} times its area in material_coordinates, the "
                "flat blank, on which neighbours are told from contacts; allowed are "
                f"{SMALLEST_FLAT_AREA:g} to {1.0 / SMALLEST_FLAT_AREA:g}: give the blank flat coordinates of its own"
            )

    def check_symmetry(self, symmetry: Symmetry) -> None:
        """Check the sheet against the symmetry of its world.

        Raises:
            InputError: a plane that no node lies on, yarns that are not their own mirror image there, or a node that a
                support drives off its plane.
        """
        for plane in symmetry.planes:
            on_plane = symmetry.held_nodes(self.blank, plane)
            self._check_yarns(plane, on_plane)
            for support in self.supports:
                for k in range(len(support.drives)):
                    if support.directions(k)[on_plane[support.nodes], AXES[plane]].any():
                        raise ValueError(
                            f"support {support.name}: drive {k} moves a node off the symmetry plane {plane} = 0; its "
                            f"{plane} must stay 0 there"
                        )

    def _check_yarns(self, plane: str, on_plane: np.ndarray) -> None:
        """Check that the yarns at a plane of symmetry go on in their mirror image."""
        quads, yarns = self.blank.quads, self.oriented_blank
        element, corner = np.nonzero(on_plane[quads] & on_plane[np.roll(quads, -1, axis=1)])
        if not len(element):
            return
        # within the sheet: across a sharp bend at the plane, the yarns of the elements beside it lean by themselves
        along = self.blank.node_position[quads[element, (corner + 1) % 4]]
        along = along - self.blank.node_position[quads[element, corner]]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        warp, weft = (
            90.0 - np.degrees(np.arcsin(np.minimum(np.abs(np.einsum("ei,ei->e", yarn[element], along)), 1.0)))
            for yarn in (yarns.warp_direction, yarns.weft_direction)
        )
        # yarns that curve are at another angle half an element beside the plane: of eight elements in a quadrant 5.6
        limit = LARGEST_LEAN if np.ptp(yarns.warp_direction, axis=0).max() < 1e-9 else LARGEST_CURVED_LEAN
        leans = np.maximum(np.minimum(warp, 90.0 - warp), np.minimum(weft, 90.0 - weft))
        lean = float(leans.max())
        if lean <= limit:
            return
        # the mirror image of each family is then the other one
        diagonal = float(np.abs(warp - weft).max()) <= limit
        if diagonal and families_alike(self.fabric):
            return
        problem = f"a yarn family lies at {lean:.4g} degrees to the plane of symmetry {plane} = 0 or to its normal"
        if diagonal:
            problem += ", where its mirror image is the other one, which is not like it"
        raise ValueError(
            f"sheet {self.name}: {problem}; a plane needs yarns along it or across it, or at 45 degrees if warp and "
            f"weft are alike: leave {plane!r} out of symmetry, and give the whole sheet"
        )

    def disproportions(self) -> Iterator[str]:
        size, thickness = self.blank.size, self.fabric.thickness
        low, high = USUAL_BLANK_SIZE
        if not low <= size <= high:
            yield f"the blank is {size:.4g} m across; usual are {low:g} to {high:g} m: check its unit (mm, inch)"
        if thickness > LARGEST_USUAL_THICKNESS * size:
            yield f"the fabric is {thickness:.4g} m thick, and the blank only {size:.4g} m across: check both units"

    @cached_property
    def oriented_blank(self) -> Blank:
        """The blank with its yarn directions rotated by ``orientation``."""
        if self.orientation == 0.0:
            return self.blank
        cosine, sine = np.cos(np.radians(self.orientation)), np.sin(np.radians(self.orientation))
        warp, weft = self.blank.warp_direction, self.blank.weft_direction
        turned = {"warp_direction": cosine * warp + sine * weft, "weft_direction": cosine * weft - sine * warp}
        return self.blank.model_copy(update=turned)

    @property
    def start_velocity(self) -> np.ndarray | None:
        """``initial_velocity``, with that of supports in the components that they hold, (node_count, 3) [m/s]."""
        return prescribe_start(self.supports, self.initial_velocity, self.blank.node_count)

    def freedom(self, symmetry: Symmetry) -> np.ndarray:
        """``free`` minus the components held by supports and the planes of ``symmetry``, (node_count, 6) bool."""
        free = np.ones((self.blank.node_count, 6), dtype=bool) if self.free is None else self.free
        free = symmetry.hold(self.blank, free)
        for support in self.supports:
            free[np.ix_(support.nodes, support.held)] = False
        return free
