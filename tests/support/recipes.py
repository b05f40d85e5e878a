"""Recipes of CONTRIBUTING, as files that can be imported."""

import re
from pathlib import Path

from tests.support.paths import ROOT


def written_recipe(name: str, folder: Path) -> Path:
    """The code block of CONTRIBUTING that begins with ``# name``, as a file in ``folder``."""
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    (code,) = re.findall(rf"```python\n# {name}\n(.*?)```", page, flags=re.DOTALL)
    (folder / name).write_text(code, encoding="utf-8")
    return folder / name
