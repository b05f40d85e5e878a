"""Check that this checkout computes the same bits as another commit: proof that a code change changes no result.

    python scripts/same_results.py --commit 4add259                      both versions, all cases
    python scripts/same_results.py --reference ../reference [--quick]    keeps results of the commit there, reuses them
    python scripts/same_results.py --reference ../reference --record     only runs what is missing there
    python scripts/same_results.py --reference ../reference --case cantilever --extra=--damping=101

Every case is one call of the command line, in a separate process. Compared bit for bit: every number of every frame
(ledger, stroke, tools, supports, steps, time) and hashes of its positions, directors and fields; these arrays of the
last frame; all CSV tables; the final state for ParaView; and the summary except for timings. Bytes of film, ParaView
series and pictures are reported in a separate column and do not affect the verdict. The exit code is 1 if anything
differs or a run fails. Bits depend on the processor and the version of Warp: do not use a reference from another
machine.
"""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from scripts.comparison.cases import CASES, REFERENCE_COMMIT  # noqa: E402
from scripts.comparison.reading import read_results, sha256  # noqa: E402
from scripts.comparison.running import Reference, bits_depend_on, run_case  # noqa: E402
from scripts.comparison.verdict import Verdict, compare, verdict_table  # noqa: E402


def say(text: str) -> None:
    """Print progress to standard error, separate from the results."""
    typer.echo(text, err=True)


@dataclass
class Comparison:
    """Runs cases in this checkout and compares them with a reference.

    Attributes:
        reference: results of the other commit.
        here: folder for those of this checkout.
        threads: of every run.
        extra: arguments for this checkout only.
        hashed: whether to keep hashes of every entry.
        kept: whether to keep the results of the reference, and of this checkout.
        digests: hashes of all entries, by case and version.
    """

    reference: Reference
    here: Path
    threads: int
    extra: Sequence[str] = ()
    hashed: bool = False
    kept: tuple[bool, bool] = (True, True)
    digests: dict[str, dict[str, dict[str, str]]] = field(default_factory=dict)

    def verdict(self, name: str) -> Verdict:
        """Verdict on a case: it is run here, and in the reference if that lacks it."""
        here = self.here / name
        try:
            there = self.reference.result(name, say)
            seconds = run_case(CASES[name], ROOT, self.reference.inputs, here, self.threads, self.extra)
            verdict = compare(name, there, here)
            verdict.seconds = seconds
            if self.hashed:
                self.digests[name] = {
                    label: {entry: sha256(values) for entry, values in read_results(folder).items()}
                    for label, folder in (("reference", there), ("here", here))
                }
        except (RuntimeError, OSError) as error:
            verdict = Verdict(name, failure=str(error))
        say(f"{name}: {verdict.row()[3]}")
        for kept, folder in zip(self.kept, (self.reference.folder / name, here), strict=True):
            if not kept:
                shutil.rmtree(folder, ignore_errors=True)
        return verdict


def record_all(reference: Reference, names: Sequence[str]) -> None:
    """Run the cases that a reference lacks, then exit."""
    failed = 0
    for name in names:
        try:
            reference.result(name, say)
        except (RuntimeError, OSError) as error:
            failed += 1
            say(f"{name}: {Verdict(name, failure=str(error)).row()[3]}")
    typer.echo(f"{reference.folder} has {len(names) - failed} of {len(names)} cases of {reference.commit[:7]}")
    raise typer.Exit(1 if failed else 0)


def report(verdicts: Sequence[Verdict], commit: str, every: bool) -> str:
    """The final report."""
    lines = [
        f"this checkout compared with {commit[:7]}; {', '.join(bits_depend_on().values())}\n",
        verdict_table(verdicts),
    ]
    if every:
        lines += [f"{verdict.case}: {one}" for verdict in verdicts for one in verdict.found]
    same = [verdict for verdict in verdicts if verdict.same]
    lines.append(f"\n{len(same)} of {len(verdicts)} cases are the same to the last bit")
    if changed := [verdict.case for verdict in verdicts if not verdict.same and not verdict.wrong]:
        lines.append(f"{len(changed)} were changed on purpose: {', '.join(changed)}")
    return "\n".join(lines)


def main(
    commit: Annotated[str, typer.Option(help="the version to compare with")] = REFERENCE_COMMIT,
    case: Annotated[list[str] | None, typer.Option(help="one of --list; may be repeated [default: all]")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="only a few cases, less than a minute each version")] = False,
    reference: Annotated[
        Path | None, typer.Option(help="folder for results of the commit: reused, or run once and kept")
    ] = None,
    record: Annotated[bool, typer.Option("--record", help="only run what is missing in --reference")] = False,
    keep: Annotated[Path | None, typer.Option(help="folder in which to keep the results of this checkout")] = None,
    hashes: Annotated[Path | None, typer.Option(help="JSON file for the SHA-256 of every entry")] = None,
    extra: Annotated[
        list[str] | None,
        typer.Option(help="argument for this checkout's runs only, to test that a difference is found"),
    ] = None,
    threads: Annotated[int, typer.Option(min=1, help="CPU threads; results are bit-identical for any number")] = 2,
    every: Annotated[bool, typer.Option("--all-differences", help="list every entry that differs")] = False,
    listing: Annotated[bool, typer.Option("--list", help="list the cases and exit")] = False,
) -> None:
    """Compare every bit of this checkout's results with another commit."""
    if listing:
        for name, one in CASES.items():
            typer.echo(f"{name}{' (quick)' if one.quick else ''}: weavesim {one.words}")
        return
    if record and reference is None:
        raise typer.BadParameter("specify the folder with --reference", param_hint="--record")
    names = case or [name for name, one in CASES.items() if one.quick or not quick]
    if unknown := [name for name in names if name not in CASES]:
        raise typer.BadParameter(f"{', '.join(unknown)}: choose from {', '.join(CASES)}", param_hint="--case")
    with ExitStack() as stack:
        temporary = Path(stack.enter_context(TemporaryDirectory(prefix="weavesim-same-")))
        known = Reference((reference or temporary / "reference").resolve(), commit, threads, stack)
        if record:
            record_all(known, names)
        comparison = Comparison(
            known, (keep or temporary / "here").resolve(), threads, extra or (), hashes is not None,
            kept=(reference is not None, keep is not None),
        )  # fmt: skip
        verdicts = [comparison.verdict(name) for name in names]
    if hashes is not None:
        about = {"commit": known.commit, "machine": bits_depend_on(), "cases": comparison.digests}
        hashes.write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")
    typer.echo(report(verdicts, known.commit, every))
    if any(verdict.wrong for verdict in verdicts):
        raise typer.Exit(1)


if __name__ == "__main__":
    typer.run(main)
