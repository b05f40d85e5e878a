"""Kinds that a test defines, forgotten afterwards."""

import importlib.util
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

import pytest

from weavesim import checks
from weavesim.checks import Kinded


@contextmanager
def kinds_forgotten() -> Iterator[None]:
    """What is registered within it is unknown afterwards."""
    registries = [checks._kinds_by_name, *(family._family for family in Kinded.__subclasses__())]
    before = [dict(registry) for registry in registries]
    try:
        yield
    finally:
        for registry, known in zip(registries, before, strict=True):
            registry.clear()
            registry.update(known)


def imported(path: Path, patch: pytest.MonkeyPatch) -> ModuleType:
    """The module of a file, known by the file's name until ``patch`` ends."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    patch.setitem(sys.modules, path.stem, module)
    spec.loader.exec_module(module)
    return module
