"""Contact of a sheet with itself: in folds, and where its ends slide over each other."""

from __future__ import annotations

from typing import Annotated

from pydantic import SerializeAsAny

from ..checks import NotNegative, Parameters, Positive
from ..ranges import Quantity
from .friction import Coulomb, Friction

# Nearer on the flat blank than this many thicknesses, points of one sheet are neighbours, and do not touch.
EXCLUDED_THICKNESSES = 2.0


class SelfContact(Parameters):
    """Contact of a sheet with itself, at its initial thickness.

    Points nearer to each other on the flat blank than twice the thickness are neighbours, and do not touch. A sheet
    with it folds: its directors have the whole stiffness of their hourglass mode, whatever its fabric says.

    Attributes:
        friction: of the sheet's faces on each other.
        stiffness_share: share of the largest stiffness that a step allows, as in ``Interface``.
        damping_ratio: normal dashpot as a share of critical; None for that of the world's contact.
    """

    positional = ("friction",)

    friction: SerializeAsAny[Friction] = Coulomb(0.2)
    stiffness_share: Annotated[Positive, Quantity("stiffness share")] = 0.05
    damping_ratio: Annotated[NotNegative, Quantity("damping ratio")] | None = None
