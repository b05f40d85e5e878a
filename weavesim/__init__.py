"""weavesim: draping and forming of woven fabrics with an explicit shell that carries a plain-weave unit cell.

The names below are loaded on first use, so that ``import weavesim`` and ``weavesim --help`` stay fast.
"""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

# In a checkout, kernels/ and scenes/ are next to this package; when installed, they are inside it. Searching both lets
# the checkout work even when it hides an installed copy, as it does for a script started in its root.
_checkout = Path(__file__).resolve().parent.parent
if (_checkout / "pyproject.toml").is_file():
    __path__.append(str(_checkout))

if TYPE_CHECKING:
    from .checks import NotNegative, Positive, json_schema  # noqa: F401
    from .device import Precision  # noqa: F401
    from .engine.setup import Rest, Setup, Solver, World  # noqa: F401
    from .errors import InputError, RunError  # noqa: F401
    from .fabric.fabric import Fabric  # noqa: F401
    from .fabric.file import load_fabric  # noqa: F401
    from .fabric.presets import assumed_fabric, glass_polypropylene  # noqa: F401
    from .fabric.response import respond  # noqa: F401
    from .process.dynamics import Dynamics  # noqa: F401
    from .process.loads import NodalLoads  # noqa: F401
    from .process.strokes import Fixed, ForceDriven, SmoothStroke, Stroke  # noqa: F401
    from .process.supports import Drive, Support  # noqa: F401
    from .run.frame import Frame, Observer, Outcome  # noqa: F401
    from .run.simulation import Simulation  # noqa: F401
    from .sheet.blank import Blank  # noqa: F401
    from .sheet.sheet import Sheet  # noqa: F401
    from .sheet.symmetry import Symmetry  # noqa: F401
    from .tools.mesh_tool import MeshShape  # noqa: F401
    from .tools.shapes import (  # noqa: F401
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
    from .tools.tool import Tool  # noqa: F401

# The modules of the public names; the imports above are the same list for type checkers.
_names_in = {
    "checks": ("NotNegative", "Positive", "json_schema"),
    "device": ("Precision",),
    "engine.setup": ("Rest", "Setup", "Solver", "World"),
    "errors": ("InputError", "RunError"),
    "fabric.fabric": ("Fabric",),
    "fabric.file": ("load_fabric",),
    "fabric.presets": ("assumed_fabric", "glass_polypropylene"),
    "fabric.response": ("respond",),
    "process.dynamics": ("Dynamics",),
    "process.loads": ("NodalLoads",),
    "process.strokes": ("Fixed", "ForceDriven", "SmoothStroke", "Stroke"),
    "process.supports": ("Drive", "Support"),
    "run.frame": ("Frame", "Observer", "Outcome"),
    "run.simulation": ("Simulation",),
    "sheet.blank": ("Blank",),
    "sheet.sheet": ("Sheet",),
    "sheet.symmetry": ("Symmetry",),
    "tools.mesh_tool": ("MeshShape",),
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
