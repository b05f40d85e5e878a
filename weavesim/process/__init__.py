"""What happens to the sheet: strokes, supports, loads, pressure, grippers, gravity and damping."""

from .dynamics import Dynamics
from .grippers import Gripper
from .loads import NodalLoads
from .pressure import Pressure
from .strokes import Fixed, ForceDriven, Motion, SmoothStroke, Stroke
from .supports import Drive, Support

__all__ = [
    "Drive",
    "Dynamics",
    "Fixed",
    "ForceDriven",
    "Gripper",
    "Motion",
    "NodalLoads",
    "Pressure",
    "SmoothStroke",
    "Stroke",
    "Support",
]
