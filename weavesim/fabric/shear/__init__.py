"""In-plane shear of the sheet: the elastic laws, one module each, and the friction between the yarns."""

from ..families import define_kinds
from .friction import CrossoverFriction, ShearFriction
from .law import LARGEST_SHEAR_ANGLE, ShearLaw
from .linear import LinearShear
from .loop import LoopSplit, split_jump, split_loop, unloading_doubt
from .moment_curve import MomentCurve

define_kinds(__name__, __path__)

__all__ = [
    "LARGEST_SHEAR_ANGLE",
    "CrossoverFriction",
    "LinearShear",
    "LoopSplit",
    "MomentCurve",
    "ShearFriction",
    "ShearLaw",
    "split_jump",
    "split_loop",
    "unloading_doubt",
]
