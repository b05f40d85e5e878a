"""Recipes of CONTRIBUTING, as files that can be imported."""

import re
from pathlib import Path

from tests.support.paths import ROOT


def written_recipe(name: str, folder: Path, page: str = "CONTRIBUTING.md") -> Path:
    """The code block of a page that begins with ``# name``, as a file in ``folder``."""
    text = (ROOT / page).read_text(encoding="utf-8")
    (code,) = re.findall(rf"```python\n# {name}\n(.*?)```", text, flags=re.DOTALL)
    (folder / name).write_text(code, encoding="utf-8")
    return folder / name
