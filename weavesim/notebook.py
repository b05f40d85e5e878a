"""What notebooks show: values as tables in HTML, and a progress bar, for Jupyter, VS Code and Colab alike."""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Iterable, Mapping
from enum import Enum
from html import escape
from typing import Any

# Of lists and texts that are shown in full.
LONGEST_LIST, LONGEST_TEXT = 8, 300
_CELL = "text-align:left;vertical-align:top;padding:2px 12px 2px 0;border:0"
# Entries of the section "Attributes" of a docstring: names, and lines that are indented further.
_ENTRY = re.compile(r"^    (\w[\w, ]*): (.*(?:\n        .*)*)", re.MULTILINE)


def table_of(value: Any) -> str:
    """A table of the fields of ``Parameters``: name, value, and what it is, in its unit."""
    name = getattr(value, "name", "")
    title = type(value).__name__ + (f" {name}" if isinstance(name, str) and name else "")
    meanings = meanings_of(type(value))
    rows = ((key, shown(getattr(value, key)), meanings.get(key, "")) for key in type(value).model_fields)
    return table(title, rows)


def table(title: str, rows: Iterable[tuple[str, str, str]], note: str = "") -> str:
    """A table.

    Args:
        title: plain text.
        rows: name and meaning as plain text, between them the value as HTML.
        note: below the title, plain text.
    """
    lines = "".join(
        f'<tr><td style="{_CELL}"><code>{escape(name)}</code></td><td style="{_CELL}">{value}</td>'
        f'<td style="{_CELL};opacity:0.7">{escape(meaning)}</td></tr>'
        for name, value, meaning in rows
    )
    below = f"<div>{escape(note)}</div>" if note else ""
    return f"<div><strong>{escape(title)}</strong>{below}<table>{lines}</table></div>"


def shown(value: Any) -> str:
    """A value as HTML: arrays by their shape, lists up to a length, ``Parameters`` to be unfolded."""
    if value is None:
        return "&ndash;"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Enum):
        return shown(value.value)
    if isinstance(value, float):
        return f"{value:.6g}"
    if hasattr(value, "shape") and hasattr(value, "dtype"):
        return f"array of {' &times; '.join(map(str, value.shape))}" if value.shape else shown(value.item())
    if hasattr(type(value), "model_fields"):
        name = getattr(value, "name", "")
        rows = "".join(
            f'<tr><td style="{_CELL}"><code>{escape(key)}</code></td>'
            f'<td style="{_CELL}">{shown(getattr(value, key))}</td></tr>'
            for key in type(value).model_fields
        )
        title = escape(type(value).__name__ + (f" {name}" if isinstance(name, str) and name else ""))
        return f"<details><summary>{title}</summary><table>{rows}</table></details>" if rows else title
    if isinstance(value, Mapping):
        return "<br>".join(f"{escape(str(key))}: {shown(entry)}" for key, entry in value.items()) or "none"
    if isinstance(value, list | tuple):
        nested = any(hasattr(type(entry), "model_fields") for entry in value)
        if len(value) > LONGEST_LIST:
            many = f"{len(value)} values"
            if nested:
                return f"<details><summary>{many}</summary>{''.join(map(shown, value))}</details>"
            return f"{many}, {shown(value[0])} to {shown(value[-1])}"
        return ("" if nested else ", ").join(map(shown, value)) or "none"
    text = str(value)
    return escape(text if len(text) <= LONGEST_TEXT else f"{text[: LONGEST_TEXT - 1]}…")


def meanings_of(kind: type) -> dict[str, str]:
    """What the fields of a class of ``Parameters`` mean, from their descriptions or its docstrings."""
    meanings: dict[str, str] = {}
    for one in reversed(kind.__mro__):
        section = (inspect.getdoc(one) or "").partition("Attributes:\n")[2] if "__doc__" in one.__dict__ else ""
        for names, text in _ENTRY.findall(section):
            meanings |= dict.fromkeys(names.split(", "), " ".join(text.split()))
    fields: Mapping[str, Any] = getattr(kind, "model_fields", {})
    return {name: field.description or meanings.get(name, "") for name, field in fields.items()}


def in_notebook() -> bool:
    """Whether the process is the kernel of a notebook."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    return shell is not None and getattr(shell, "kernel", None) is not None


class NotebookBar:
    """A bar with its state, and lines of text below it: one output that is replaced.

    Args:
        title: before the bar.
    """

    def __init__(self, title: str) -> None:
        self._title, self._share, self._state = title, 0.0, "preparing"
        self._lines: list[str] = []
        self._output: Any = None

    def update(self, share: float, state: str) -> None:
        """Show how much is done, from 0 to 1, and how it is."""
        self._share, self._state = share, state
        self._show()

    def line(self, text: str) -> None:
        """Add a line, which stays."""
        self._lines.append(text)
        self._show()

    def html(self) -> str:
        """What is shown."""
        percent = f"{min(max(self._share, 0.0), 1.0):.0%}"
        bar = f'<progress max="1" value="{self._share:.4f}" style="width:18em;vertical-align:middle"></progress>'
        lines = "".join(f"<div>{escape(line)}</div>" for line in self._lines)
        return f"<div>{escape(self._title)} {bar} {percent} {escape(self._state)}</div>{lines}"

    def _show(self) -> None:
        from IPython.display import HTML, display

        if self._output is None:
            self._output = display(HTML(self.html()), display_id=True)
        else:
            self._output.update(HTML(self.html()))
