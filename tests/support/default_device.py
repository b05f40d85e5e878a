"""Runs the tests on another device: whatever does not ask for one uses it."""

from weavesim.app.options import RunOptions
from weavesim.checks import Parameters
from weavesim.engine.setup import Setup, Solver


def use_by_default(device: str) -> None:
    """Make a device the default of every set-up and of every scene's options that are defined from now on."""
    for parameters in (Solver, RunOptions):
        _set_default(parameters, "device", device)
    _set_default(Setup, "solver", Solver())


def _set_default(parameters: type[Parameters], name: str, value: object) -> None:
    parameters.model_fields[name].default = value
    parameters.model_rebuild(force=True)
