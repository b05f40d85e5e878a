"""Fabrics: laws, unit cells, presets, files."""

from .bending import BendingCurve, BendingLaw, FamilyBending, IsotropicBending, YarnBending
from .cell import (
    EnergyCell,
    FloatWeave,
    LinearMembrane,
    PlainWeave,
    SatinWeave,
    TwillWeave,
    UnidirectionalTape,
    UnitCell,
)
from .compaction import Compaction
from .device_form import DeviceForm, Tabulated
from .fabric import Fabric, Stabilisation
from .file import load_fabric, resolve_fabric
from .presets import (
    PRESETS,
    UNIT_CELLS,
    assumed_fabric,
    glass_polypropylene,
    glass_polypropylene_consensus,
    glass_polypropylene_hkust,
)
from .provenance import Origin
from .shear import (
    CrossoverFriction,
    LinearShear,
    LoopSplit,
    MomentCurve,
    ShearFriction,
    ShearLaw,
    split_jump,
    split_loop,
)

__all__ = [
    "BendingCurve",
    "BendingLaw",
    "Compaction",
    "CrossoverFriction",
    "DeviceForm",
    "EnergyCell",
    "Fabric",
    "FamilyBending",
    "FloatWeave",
    "IsotropicBending",
    "LinearMembrane",
    "LinearShear",
    "LoopSplit",
    "MomentCurve",
    "Origin",
    "PRESETS",
    "PlainWeave",
    "SatinWeave",
    "ShearFriction",
    "ShearLaw",
    "Stabilisation",
    "Tabulated",
    "TwillWeave",
    "UNIT_CELLS",
    "UnidirectionalTape",
    "UnitCell",
    "YarnBending",
    "assumed_fabric",
    "glass_polypropylene",
    "glass_polypropylene_consensus",
    "glass_polypropylene_hkust",
    "load_fabric",
    "resolve_fabric",
    "split_jump",
    "split_loop",
]
