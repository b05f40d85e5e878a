"""weavesim: draping and forming of woven fabrics with an explicit shell that carries a plain-weave unit cell.

The names below are loaded on first use, so that ``import weavesim`` and ``weavesim --help`` stay fast.
"""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .version import __version__

# In a checkout, kernels/ and scenes/ are next to this package; when installed, they are inside it. Searching both lets
# the checkout work even when it hides an installed copy, as it does for a script started in its root.
_checkout = Path(__file__).resolve().parent.parent
if (_checkout / "pyproject.toml").is_file():
    __path__.append(str(_checkout))

# ruff: noqa: F401, the imports are for type checkers
if TYPE_CHECKING:
    from .app.progress import ProgressBar
    from .calibration.calibration import calibrate
    from .calibration.options import CalibrationOptions
    from .calibration.record import write_calibration
    from .calibration.result import Calibration
    from .checks import NotNegative, Positive, json_schema
    from .device import Precision
    from .engine.model import Model
    from .engine.setup import Rest, Setup, Solver, World
    from .engine.state import State
    from .engine.stepper import Stepper
    from .errors import InputError, RunError
    from .fabric.bending.curve import BendingCurve, FamilyBending
    from .fabric.bending.isotropic import IsotropicBending
    from .fabric.bending.law import BendingLaw
    from .fabric.bending.yarns import YarnBending
    from .fabric.cell.contract import EnergyCell, UnitCell
    from .fabric.cell.membrane import LinearMembrane
    from .fabric.cell.tape import UnidirectionalTape
    from .fabric.cell.weaves import FloatWeave, PlainWeave, SatinWeave, TwillWeave
    from .fabric.compaction import Compaction
    from .fabric.device_form import DeviceForm, Tabulated
    from .fabric.fabric import Fabric, Stabilisation
    from .fabric.file import load_fabric, resolve_fabric
    from .fabric.presets import (
        PRESETS,
        UNIT_CELLS,
        assumed_fabric,
        glass_polypropylene,
        glass_polypropylene_consensus,
        glass_polypropylene_hkust,
    )
    from .fabric.provenance import Origin
    from .fabric.response import respond
    from .fabric.shear.friction import CrossoverFriction, ShearFriction
    from .fabric.shear.law import ShearLaw
    from .fabric.shear.linear import LinearShear
    from .fabric.shear.loop import LoopSplit, split_jump, split_loop
    from .fabric.shear.moment_curve import MomentCurve
    from .output.folder import ResultFolder
    from .output.writer import Writer
    from .process.dynamics import Dynamics
    from .process.friction import (
        Coulomb,
        Friction,
        PressureFriction,
        StribeckFriction,
        ViscousFilm,
        YarnAngleFriction,
    )
    from .process.grippers import Gripper
    from .process.interfaces import Interface
    from .process.loads import NodalLoads
    from .process.motions.paths import PathMotion, Rotation
    from .process.pressure import Pressure
    from .process.scaling.mass import MassScaling
    from .process.self_contact import SelfContact
    from .process.stages import AtForce, AtRest, AtStroke, FrictionOf, Move, SheetLoads, SheetPressure, Stage, StageEnd
    from .process.strokes import Fixed, ForceDriven, Motion, SmoothStroke, Stroke
    from .process.supports import Drive, Support
    from .process.trims import Trim
    from .run.batch.batch import run_batch
    from .run.batch.batch_run import BatchRun
    from .run.frame import Frame, Observer, Outcome, RunInfo, SheetFrame
    from .run.relaxation import relax
    from .run.scaling.mass import choose_mass_scaling, with_mass_scaling
    from .run.simulation import Simulation
    from .sheet.blank import Blank
    from .sheet.sheet import Sheet
    from .sheet.stack import LayUp, Ply
    from .sheet.symmetry import Symmetry
    from .tools.mesh_tool import MeshShape
    from .tools.segments.opening import DomeOpeningSector
    from .tools.shapes import (
        Capsule,
        DomeCavity,
        DomeOpening,
        DomePunch,
        Plane,
        Shape,
        Sphere,
        Torus,
        Union,
        rotation_matrix,
    )
    from .tools.tool import Tool

# The modules of the public names; the imports above are the same list for type checkers.
_names_in = {
    "app.progress": ("ProgressBar",),
    "calibration.calibration": ("calibrate",),
    "calibration.options": ("CalibrationOptions",),
    "calibration.record": ("write_calibration",),
    "calibration.result": ("Calibration",),
    "checks": ("NotNegative", "Positive", "json_schema"),
    "device": ("Precision",),
    "engine.model": ("Model",),
    "engine.setup": ("Rest", "Setup", "Solver", "World"),
    "engine.state": ("State",),
    "engine.stepper": ("Stepper",),
    "errors": ("InputError", "RunError"),
    "fabric.bending.curve": ("BendingCurve", "FamilyBending"),
    "fabric.bending.isotropic": ("IsotropicBending",),
    "fabric.bending.law": ("BendingLaw",),
    "fabric.bending.yarns": ("YarnBending",),
    "fabric.cell.contract": ("EnergyCell", "UnitCell"),
    "fabric.cell.membrane": ("LinearMembrane",),
    "fabric.cell.tape": ("UnidirectionalTape",),
    "fabric.cell.weaves": ("FloatWeave", "PlainWeave", "SatinWeave", "TwillWeave"),
    "fabric.compaction": ("Compaction",),
    "fabric.device_form": ("DeviceForm", "Tabulated"),
    "fabric.fabric": ("Fabric", "Stabilisation"),
    "fabric.file": ("load_fabric", "resolve_fabric"),
    "fabric.presets": (
        "PRESETS",
        "UNIT_CELLS",
        "assumed_fabric",
        "glass_polypropylene",
        "glass_polypropylene_consensus",
        "glass_polypropylene_hkust",
    ),
    "fabric.provenance": ("Origin",),
    "fabric.response": ("respond",),
    "fabric.shear.friction": ("CrossoverFriction", "ShearFriction"),
    "fabric.shear.law": ("ShearLaw",),
    "fabric.shear.linear": ("LinearShear",),
    "fabric.shear.loop": ("LoopSplit", "split_jump", "split_loop"),
    "fabric.shear.moment_curve": ("MomentCurve",),
    "output.folder": ("ResultFolder",),
    "output.writer": ("Writer",),
    "process.dynamics": ("Dynamics",),
    "process.friction": (
        "Coulomb",
        "Friction",
        "PressureFriction",
        "StribeckFriction",
        "ViscousFilm",
        "YarnAngleFriction",
    ),
    "process.grippers": ("Gripper",),
    "process.interfaces": ("Interface",),
    "process.loads": ("NodalLoads",),
    "process.motions.paths": ("PathMotion", "Rotation"),
    "process.pressure": ("Pressure",),
    "process.scaling.mass": ("MassScaling",),
    "process.self_contact": ("SelfContact",),
    "process.stages": (
        "AtForce",
        "AtRest",
        "AtStroke",
        "FrictionOf",
        "Move",
        "SheetLoads",
        "SheetPressure",
        "Stage",
        "StageEnd",
    ),
    "process.strokes": ("Fixed", "ForceDriven", "Motion", "SmoothStroke", "Stroke"),
    "process.supports": ("Drive", "Support"),
    "process.trims": ("Trim",),
    "run.batch.batch": ("run_batch",),
    "run.batch.batch_run": ("BatchRun",),
    "run.frame": ("Frame", "Observer", "Outcome", "RunInfo", "SheetFrame"),
    "run.relaxation": ("relax",),
    "run.scaling.mass": ("choose_mass_scaling", "with_mass_scaling"),
    "run.simulation": ("Simulation",),
    "sheet.blank": ("Blank",),
    "sheet.sheet": ("Sheet",),
    "sheet.stack": ("LayUp", "Ply"),
    "sheet.symmetry": ("Symmetry",),
    "tools.mesh_tool": ("MeshShape",),
    "tools.segments.opening": ("DomeOpeningSector",),
    "tools.shapes": (
        "Capsule",
        "DomeCavity",
        "DomeOpening",
        "DomePunch",
        "Plane",
        "Shape",
        "Sphere",
        "Torus",
        "Union",
        "rotation_matrix",
    ),
    "tools.tool": ("Tool",),
}
_module_of = {name: module for module, names in _names_in.items() for name in names}

__all__ = ["__version__", *_module_of]  # noqa: PLE0604


def __getattr__(name: str) -> Any:
    if name not in _module_of:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_module_of[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(set(globals()) | set(__all__))
