"""Named fabrics, and examples of every kind of unit cell."""

from .examples import UNIT_CELLS, assumed_fabric
from .glass import glass_polypropylene, glass_polypropylene_consensus, glass_polypropylene_hkust
from .registry import PRESETS

__all__ = [
    "PRESETS",
    "UNIT_CELLS",
    "assumed_fabric",
    "glass_polypropylene",
    "glass_polypropylene_consensus",
    "glass_polypropylene_hkust",
]
