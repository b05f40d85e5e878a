"""What happens to the sheet: strokes, supports, loads, pressure, grippers, gravity, damping, and stages of these."""

from .dynamics import Dynamics
from .friction import Coulomb, Friction, PressureFriction, StribeckFriction, ViscousFilm, YarnAngleFriction
from .grippers import Gripper
from .interfaces import Interface
from .loads import NodalLoads
from .motions.paths import PathMotion, Rotation
from .pressure import Pressure
from .self_contact import SelfContact
from .stages import AtForce, AtRest, AtStroke, FrictionOf, Move, SheetLoads, SheetPressure, Stage, StageEnd
from .strokes import Fixed, ForceDriven, Motion, SmoothStroke, Stroke
from .supports import Drive, Support
from .trims import Trim

__all__ = [
    "AtForce",
    "AtRest",
    "AtStroke",
    "Coulomb",
    "Drive",
    "Dynamics",
    "Fixed",
    "ForceDriven",
    "Friction",
    "FrictionOf",
    "Gripper",
    "Interface",
    "Motion",
    "Move",
    "NodalLoads",
    "PathMotion",
    "Pressure",
    "PressureFriction",
    "Rotation",
    "SelfContact",
    "SheetLoads",
    "SheetPressure",
    "SmoothStroke",
    "Stage",
    "StageEnd",
    "StribeckFriction",
    "Stroke",
    "Support",
    "Trim",
    "ViscousFilm",
    "YarnAngleFriction",
]
