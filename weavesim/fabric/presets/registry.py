"""The presets by name."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from ..cell import PlainWeave
from ..fabric import Fabric
from .examples import UNIT_CELLS, assumed_fabric
from .glass import glass_polypropylene, glass_polypropylene_consensus, glass_polypropylene_hkust

# "glass-polypropylene" is the fabric with the polynomial: files and runs that name it keep their results.
PRESETS: dict[str, Callable[[], Fabric]] = {
    "glass-polypropylene": glass_polypropylene,
    "glass-polypropylene-polynomial": glass_polypropylene,
    "glass-polypropylene-hkust": glass_polypropylene_hkust,
    "glass-polypropylene-consensus": glass_polypropylene_consensus,
    **{f"assumed-{name}": partial(assumed_fabric, name) for name in UNIT_CELLS if name not in PlainWeave.examples()},
}
