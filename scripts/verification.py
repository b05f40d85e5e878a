"""Run the verification studies and rebuild docs/verification.md from their records: make verify."""

from __future__ import annotations

import datetime
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Annotated

import typer

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "verification.md"
PICTURES = ROOT / "docs" / "images" / "verification"
sys.path.insert(0, str(ROOT))

HEAD = """# Verification

Does weavesim solve its equations? Every case states what is known and what weavesim gives; where the result depends
on the mesh, it is given for several meshes with the observed order (the exponent with which the error falls). Each case
is a test that asserts what it shows. The equations are in [theory](theory.md); [validation](validation.md) shows how a
forming simulation depends on mesh, speed and material data.

Written by `make verify` (`scripts/verification.py`) on {date}; {case_count} cases."""


def run_studies(records: Path, workers: int) -> int:
    """Run every test that may record, then those elsewhere that only this runs; returns the exit code of pytest."""
    commands = (
        ["tests/verification", "-m", "verification or not verification", "--manual", str(records)],
        ["tests/unit", "tests/validation", "-m", "verification"],
    )
    parallel = ["--numprocesses", str(workers), "--dist", "loadfile"] if workers > 1 else []
    codes = [
        subprocess.run([sys.executable, "-m", "pytest", "-q", *command, *parallel], cwd=ROOT, check=False).returncode
        for command in commands
    ]
    return next((code for code in codes if code), 0)


def table(columns: list[str], rows: list[list[str]]) -> str:
    """A markdown table."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def write_page(records: Path) -> int:
    """Write docs/verification.md and its pictures from the records; returns the number of cases."""
    from tests.support.manual import CHAPTERS

    cases = [json.loads(path.read_text()) for path in sorted(records.glob("*.json"))]
    parts = [HEAD.format(date=datetime.date.today().isoformat(), case_count=len(cases))]
    chapters = [name for name in CHAPTERS if any(case["chapter"] == name for case in cases)]
    parts.append("\n".join(f"- [{name}](#{name.lower().replace(' ', '-')})" for name in chapters))
    fresh = Path(tempfile.mkdtemp(dir=PICTURES.parent, prefix=".verification"))
    for chapter in chapters:
        parts.append(f"## {chapter}")
        for case in (case for case in cases if case["chapter"] == chapter):
            parts += [f"### {case['title']}", f"Known: {case['known']}"]
            for part in case["parts"]:
                if part["kind"] == "text":
                    parts.append(part["text"])
                elif part["kind"] == "table":
                    parts.append(table(part["columns"], part["rows"]))
                else:
                    shutil.copy(records / part["file"], fresh / part["file"])
                    parts.append(f"![{case['title']}](images/verification/{part['file']})")
            parts.append(f"Test: `{case['test']}`.")
    shutil.rmtree(PICTURES, ignore_errors=True)
    fresh.chmod(0o755)
    fresh.replace(PICTURES)
    partial = PAGE.with_suffix(".partial")
    partial.write_text("\n\n".join(parts) + "\n")
    partial.replace(PAGE)
    return len(cases)


def main(
    workers: Annotated[int, typer.Option(min=1, help="number of parallel processes")] = 1,
    records: Annotated[
        Path | None, typer.Option(help="write the page from these records without running anything")
    ] = None,
) -> None:
    """Run the verification studies and rebuild docs/verification.md; after a failure the page is not changed."""
    if records is not None:
        typer.echo(f"{PAGE.relative_to(ROOT)}: {write_page(records)} cases")
        return
    folder = Path(tempfile.mkdtemp(prefix="weavesim-verification-"))
    if code := run_studies(folder, workers):
        typer.echo(
            f"the page is unchanged: a study failed, see above. The others' records are in {folder}: repeat the failed "
            f"ones with pytest --manual {folder}, then write the page with scripts/verification.py --records {folder}",
            err=True,
        )
        raise typer.Exit(code)
    typer.echo(f"{PAGE.relative_to(ROOT)}: {write_page(folder)} cases")
    shutil.rmtree(folder)


if __name__ == "__main__":
    typer.run(main)
