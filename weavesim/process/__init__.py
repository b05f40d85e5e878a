"""What happens to the sheet: strokes, supports, loads, gravity and damping."""

from .dynamics import Dynamics
from .loads import NodalLoads
from .strokes import Fixed, ForceDriven, SmoothStroke, Stroke
from .supports import Drive, Support

__all__ = [
    "Drive",
    "Dynamics",
    "Fixed",
    "ForceDriven",
    "NodalLoads",
    "SmoothStroke",
    "Stroke",
    "Support",
]
