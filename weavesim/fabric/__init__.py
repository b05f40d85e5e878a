"""Fabrics: laws, unit cells, presets, files."""

from .bending import BendingCurve, IsotropicBending, YarnBending
from .cell import EnergyCell, UnitCell
from .compaction import Compaction
from .fabric import Fabric, Stabilisation
from .file import load_fabric, resolve_fabric
from .membrane import LinearMembrane
from .presets import PRESETS, UNIT_CELLS, assumed_fabric, glass_polypropylene
from .shear import LinearShear, MomentCurve, ShearFriction
from .tape import UnidirectionalTape
from .weaves import PlainWeave, SatinWeave, TwillWeave

__all__ = [
    "BendingCurve",
    "Compaction",
    "EnergyCell",
    "Fabric",
    "IsotropicBending",
    "LinearMembrane",
    "LinearShear",
    "MomentCurve",
    "PRESETS",
    "PlainWeave",
    "SatinWeave",
    "ShearFriction",
    "Stabilisation",
    "TwillWeave",
    "UNIT_CELLS",
    "UnidirectionalTape",
    "UnitCell",
    "YarnBending",
    "assumed_fabric",
    "glass_polypropylene",
    "load_fabric",
    "resolve_fabric",
]
