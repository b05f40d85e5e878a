"""What verification tests write down: one record per case, of which ``scripts/verification.py`` makes the manual.

Without ``--manual DIRECTORY`` nothing is written, and the observed orders are computed all the same.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CHAPTERS = (
    "Element",
    "Shell",
    "Unit cell",
    "Shear",
    "Bending",
    "Fabric tests",
    "Mesh angle",
    "Draping",
    "Contact",
    "Process",
    "Energy and time step",
)


def observed_orders(sizes: Sequence[float], errors: Sequence[float]) -> np.ndarray:
    """Exponent of the error between successive meshes, (n - 1,); an error of zero gives infinity."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.diff(np.log(np.abs(errors))) / np.diff(np.log(sizes))


def text_of(value: object) -> str:
    """A cell of a table: four digits for floats, markdown for all else."""
    return f"{value:.4g}" if isinstance(value, float | np.floating) else str(value)


class Case:
    """One case of the verification manual.

    Args:
        directory: where its record goes; None writes nothing.
        chapter: one of ``CHAPTERS``.
        title: of the case, unique.
        known: what is known and from where, in markdown.
        test: id of the test that holds it.
    """

    def __init__(self, directory: Path | None, chapter: str, title: str, known: str, test: str) -> None:
        if chapter not in CHAPTERS:
            raise ValueError(f"chapter {chapter!r}: one of {CHAPTERS} is needed")
        self._directory = directory
        self._name = re.sub(r"[^a-z0-9]+", "_", title.lower()).strip("_")
        self._record = {"chapter": chapter, "title": title, "known": known, "test": test, "parts": []}
        self._write()

    def _add(self, **part: object) -> None:
        self._record["parts"].append(part)
        self._write()

    def _write(self) -> None:
        if self._directory is None:
            return
        self._directory.mkdir(parents=True, exist_ok=True)
        path = self._directory / f"{self._name}.json"
        partial = path.with_suffix(".partial")
        partial.write_text(json.dumps(self._record, indent=1))
        partial.replace(path)

    def text(self, markdown: str) -> None:
        """A remark."""
        self._add(kind="text", text=markdown)

    def table(self, columns: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
        """Facts, one row each."""
        self._add(kind="table", columns=list(columns), rows=[[text_of(value) for value in row] for row in rows])

    def convergence(
        self, quantity: str, unit: str, sizes: Sequence[float], values: Sequence[float], exact: float
    ) -> np.ndarray:
        """Values on finer and finer meshes against the exact one.

        Args:
            quantity, unit: what the values are.
            sizes: element sizes, coarse to fine [m], three or more.
            values: results, in the same order.
            exact: the known answer, not zero.

        Returns:
            Observed orders between successive meshes, (n - 1,).
        """
        sizes, values = np.asarray(sizes, dtype=float), np.asarray(values, dtype=float)
        errors = values / exact - 1.0
        orders = observed_orders(sizes, errors)
        rows = [
            [f"{1e3 * size:.4g}", f"{value:.6g}", f"{100 * error:+.3g} %", "" if k == 0 else f"{orders[k - 1]:.2f}"]
            for k, (size, value, error) in enumerate(zip(sizes, values, errors, strict=True))
        ]
        header = ["element size [mm]", f"{quantity} [{unit}]" if unit else quantity, "deviation", "observed order"]
        self._add(kind="table", columns=header, rows=[["exact", f"{exact:.6g}", "", ""], *rows])
        if self._directory is not None:
            self.figure(_error_plot(quantity, 1e3 * sizes, np.abs(errors)))
        return orders

    def figure(self, figure: Figure) -> None:
        """A picture, next to the record."""
        if self._directory is None:
            return
        count = sum(part["kind"] == "figure" for part in self._record["parts"])
        file = f"{self._name}_{count + 1}.png"
        self._directory.mkdir(parents=True, exist_ok=True)
        figure.savefig(self._directory / file, dpi=100, bbox_inches="tight", metadata={"Software": None})
        self._add(kind="figure", file=file)


def _error_plot(quantity: str, sizes_mm: np.ndarray, errors: np.ndarray) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.2, 2.8))
    axes = figure.add_subplot()
    axes.loglog(sizes_mm, errors, "o-", color="tab:blue", label=quantity)
    if np.all(errors > 0.0):
        for order, style in ((1, ":"), (2, "--")):
            axes.loglog(
                sizes_mm, errors[-1] * (sizes_mm / sizes_mm[-1]) ** order, f"k{style}", lw=0.8, label=f"order {order}"
            )
    axes.set_xlabel("element size [mm]")
    axes.set_ylabel("relative error")
    axes.legend(fontsize=7)
    axes.grid(True, which="both", lw=0.3)
    return figure
