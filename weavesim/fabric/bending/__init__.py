"""Bending of the sheet: one module per law, and the curves of single yarn families."""

from ..families import define_kinds
from .curve import BendingCurve, FamilyBending
from .isotropic import IsotropicBending
from .law import BendingLaw
from .yarns import YarnBending

define_kinds(__name__, __path__)

__all__ = ["BendingCurve", "BendingLaw", "FamilyBending", "IsotropicBending", "YarnBending"]
