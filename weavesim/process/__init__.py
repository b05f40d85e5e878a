"""What happens to the sheet: strokes, supports, loads, gravity and damping."""

from .dynamics import Dynamics
from .loads import NodalLoads
from .strokes import Fixed, ForceDriven, Motion, SmoothStroke, Stroke
from .supports import Drive, Support

__all__ = [
    "Drive",
    "Dynamics",
    "Fixed",
    "ForceDriven",
    "Motion",
    "NodalLoads",
    "SmoothStroke",
    "Stroke",
    "Support",
]
