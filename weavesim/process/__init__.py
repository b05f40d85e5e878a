"""What happens to the sheet: strokes, supports, loads, pressure, grippers, gravity and damping."""

from .dynamics import Dynamics
from .friction import Coulomb, Friction, PressureFriction, StribeckFriction, ViscousFilm, YarnAngleFriction
from .grippers import Gripper
from .interfaces import Interface
from .loads import NodalLoads
from .pressure import Pressure
from .self_contact import SelfContact
from .strokes import Fixed, ForceDriven, Motion, SmoothStroke, Stroke
from .supports import Drive, Support

__all__ = [
    "Coulomb",
    "Drive",
    "Dynamics",
    "Fixed",
    "ForceDriven",
    "Friction",
    "Gripper",
    "Interface",
    "Motion",
    "NodalLoads",
    "Pressure",
    "PressureFriction",
    "SelfContact",
    "SmoothStroke",
    "StribeckFriction",
    "Stroke",
    "Support",
    "ViscousFilm",
    "YarnAngleFriction",
]
