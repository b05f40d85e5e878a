"""weavesim: draping and forming of woven fabrics with an explicit shell that carries a plain-weave unit cell.

The names below are loaded when they are first used, so that ``import weavesim`` and ``weavesim --help`` stay quick.
"""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

# In a checkout, kernels/ and scenes/ lie beside this package and are installed inside it. Looking there too lets
# the checkout work even when it hides an installed copy, as it does for a script started in its root.
_checkout = Path(__file__).resolve().parent.parent
if (_checkout / "pyproject.toml").is_file():
    __path__.append(str(_checkout))

if TYPE_CHECKING:
    from .device import Precision
    from .errors import InputError, RunError
    from .fabric.fabric import Fabric
    from .process.loads import NodalLoads
    from .process.supports import Drive, Support
    from .run.frame import Frame, Observer, Outcome
    from .run.simulation import Simulation
    from .sheet.blank import Blank
    from .tools.tool import Tool

_module_of = {
    "Blank": "sheet.blank",
    "Drive": "process.supports",
    "Fabric": "fabric.fabric",
    "Frame": "run.frame",
    "InputError": "errors",
    "NodalLoads": "process.loads",
    "Observer": "run.frame",
    "Outcome": "run.frame",
    "Precision": "device",
    "RunError": "errors",
    "Simulation": "run.simulation",
    "Support": "process.supports",
    "Tool": "tools.tool",
}

__all__ = [
    "Blank",
    "Drive",
    "Fabric",
    "Frame",
    "InputError",
    "NodalLoads",
    "Observer",
    "Outcome",
    "Precision",
    "RunError",
    "Simulation",
    "Support",
    "Tool",
    "__version__",
]


def __getattr__(name: str) -> Any:
    if name not in _module_of:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_module_of[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(set(globals()) | set(__all__))
