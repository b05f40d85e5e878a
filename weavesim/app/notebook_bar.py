"""A progress bar in a notebook: one output that is replaced, for Jupyter, VS Code and Colab alike."""

from __future__ import annotations

import sys
from html import escape
from typing import Any


def in_notebook() -> bool:
    """Whether the process is the kernel of a notebook."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    return shell is not None and getattr(shell, "kernel", None) is not None


class NotebookBar:
    """A bar with its state, and lines of text below it.

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
