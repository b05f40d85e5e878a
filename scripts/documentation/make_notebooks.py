"""Run the notebooks of docs/notebooks/ as they are, and store what comes out in them. Takes some minutes.

    python scripts/documentation/make_notebooks.py               all of them
    python scripts/documentation/make_notebooks.py own_part      one of them

Needed: the extra ``docs``. A test runs the same cells on coarse meshes.
"""

from __future__ import annotations

import base64
import io
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import Annotated, Any

import typer

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "docs" / "notebooks"
# Of a cell; a run on a slow machine included.
LONGEST = 1800


def run(path: Path) -> None:
    """Run a notebook in a copy of its folder, and write its outputs to ``path``.

    Raises:
        nbclient.exceptions.CellExecutionError: a cell failed; the notebook stays as it was.
    """
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory(prefix="weavesim-notebook-") as folder:
        for file in FOLDER.iterdir():
            if file.suffix != ".ipynb":
                shutil.copy(file, folder)
        client = NotebookClient(notebook, timeout=LONGEST, resources={"metadata": {"path": folder}})
        client.execute(env={**os.environ, "PYTHONPATH": str(ROOT)})
    for cell in notebook.cells:
        tidy(cell)
    nbformat.write(notebook, path)


def tidy(cell: Any) -> None:
    """Drop what changes with every run or shows nothing, and store pictures with few colours."""
    cell.metadata.pop("execution", None)
    if cell.cell_type == "code":
        cell.outputs = [one for one in cell.outputs if says_something(one)]
        for one in cell.outputs:
            data = one.get("data", {})
            if "image/png" in data:
                data["image/png"] = smaller(data["image/png"])


def says_something(output: Any) -> bool:
    """Whether a reader sees anything of an output; progress that was shown meanwhile leaves empty ones."""
    if output.output_type == "stream":
        return output.name == "stdout" and bool(output.text.strip())
    return output.output_type == "error" or any(str(value).strip() for value in output.get("data", {}).values())


def smaller(picture: str) -> str:
    """A PNG in base64, with a palette."""
    from PIL import Image

    ground = Image.open(io.BytesIO(base64.b64decode(picture))).convert("RGB")
    written = io.BytesIO()
    ground.quantize(256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(written, "png", optimize=True)
    return base64.b64encode(written.getvalue()).decode()


def main(names: Annotated[list[str] | None, typer.Argument(help="without their ending [default: all]")] = None) -> None:
    """Run notebooks."""
    known = {path.stem: path for path in sorted(FOLDER.glob("*.ipynb"))}
    if unknown := set(names or ()) - set(known):
        raise typer.BadParameter(f"{', '.join(sorted(unknown))}: choose from {', '.join(known)}")
    try:
        import nbclient  # noqa: F401
    except ImportError:
        raise SystemExit("nbclient is missing: pip install 'weavesim[docs]'") from None
    for name in names or known:
        started = time.monotonic()
        run(known[name])
        print(f"{known[name].relative_to(ROOT)}: {time.monotonic() - started:.0f} s", flush=True)


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    typer.run(main)
