"""What a law passes to the kernels: plain numbers and curves, from which the engine fills the device structs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Tabulated:
    """A function of x >= 0 that the kernels read from a table between 0 and ``end``; linear beyond."""

    function: Callable[[np.ndarray], np.ndarray]
    end: float


@dataclass(frozen=True)
class DeviceForm:
    """One law on the device.

    Attributes:
        module: full name of the module with the law's device functions, see ``kernels/laws/contract.py``.
        constants: fields of the law's struct, numbers and tuples of numbers.
        curves: fields of the law's struct that are tables.
    """

    module: str
    constants: Mapping[str, float | tuple[float, ...]] = field(default_factory=dict)
    curves: Mapping[str, Tabulated] = field(default_factory=dict)
