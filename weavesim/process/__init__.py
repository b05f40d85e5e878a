"""What happens to the sheet: strokes, supports, loads, pressure, gravity and damping."""

from .dynamics import Dynamics
from .loads import NodalLoads
from .pressure import Pressure
from .strokes import Fixed, ForceDriven, Motion, SmoothStroke, Stroke
from .supports import Drive, Support

__all__ = [
    "Drive",
    "Dynamics",
    "Fixed",
    "ForceDriven",
    "Motion",
    "NodalLoads",
    "Pressure",
    "SmoothStroke",
    "Stroke",
    "Support",
]
