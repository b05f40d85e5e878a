"""Unit cells: the contract, and the cells themselves."""

from ..families import define_kinds
from .contract import ENERGY_CELL_TOLERANCE, UNIT_CELL_TOLERANCE, EnergyCell, UnitCell
from .membrane import LinearMembrane
from .tape import UnidirectionalTape
from .weaves import FloatWeave, PlainWeave, SatinWeave, TwillWeave

define_kinds(__name__, __path__)

__all__ = [
    "ENERGY_CELL_TOLERANCE",
    "UNIT_CELL_TOLERANCE",
    "EnergyCell",
    "FloatWeave",
    "LinearMembrane",
    "PlainWeave",
    "SatinWeave",
    "TwillWeave",
    "UnidirectionalTape",
    "UnitCell",
]
