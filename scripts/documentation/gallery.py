"""What the gallery shows: each picture with the commands that make it, and the page of them all."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "docs" / "images"


class Exhibit(NamedTuple):
    """One picture of the gallery.

    Attributes:
        name: of the file in docs/images, without its ending.
        title: heading on the page.
        text: what is seen.
        commands: what makes it, in this order; they run in one folder, after those of the exhibits before.
        sources: pictures that the commands leave, relative to that folder; several are put one below the other.
        after: name of the exhibit whose commands have to run before; empty for none.
        holds: whether what the text says is true of the folder; None where nothing of it may change.
    """

    name: str
    title: str
    text: str
    commands: tuple[str, ...]
    sources: tuple[str, ...]
    after: str = ""
    holds: Callable[[Path], bool] | None = None


def _wrinkles_and_bridges(folder: Path) -> bool:
    sheets = json.loads((folder / "verdict" / "verdict.json").read_text(encoding="utf-8"))["sheets"]
    return all({"wrinkle", "bridging"} <= {region["kind"] for region in sheet["regions"]} for sheet in sheets)


def _keeps_half(folder: Path) -> bool:
    summary = json.loads((folder / "out" / "grippers" / "summary.json").read_text(encoding="utf-8"))
    return bool(summary["dome_depth_mm"] > 25.0)


EXHIBITS = (
    Exhibit(
        "formed_sheet",
        "A double dome",
        "A woven glass/polypropylene blank of 5 mm elements, coloured by its shear angle; lines follow the yarns. One "
        "quarter is computed, the whole part is drawn.",
        ("weavesim double-dome",),
        ("out/double_dome/pictures/formed_sheet.png",),
    ),
    Exhibit(
        "sections",
        "Sections through the tools",
        "The same run, cut along both symmetry planes: sheet, punch, die and holder at the end of the stroke.",
        (),
        ("out/double_dome/pictures/sections.png",),
        after="formed_sheet",
    ),
    Exhibit(
        "draw_in",
        "Draw-in",
        "The outline of the same blank before and after, and how far its edge came in.",
        (),
        ("out/double_dome/pictures/draw_in.png",),
        after="formed_sheet",
    ),
    Exhibit(
        "net",
        "A kinematic net beside the run",
        "A net of inextensible yarns on the same punch, computed in seconds, and where the simulation differs from it "
        "([outputs.md](outputs.md)).",
        ("weavesim kinematic out/double_dome --out net",),
        ("net/kinematic.png",),
        after="formed_sheet",
    ),
    Exhibit(
        "check",
        "An own part before its run",
        "Sections through the tools of a tray at the start, and where its radii are too small for the elements "
        "([own_part.md](own_part.md)).",
        ("weavesim new tray --die docs/notebooks/tray.stl --thickness 1.2", "weavesim check tray/job.toml"),
        ("tray/job_check.png",),
    ),
    Exhibit(
        "tray",
        "An own part, formed",
        "The tray, formed from its surface alone: blank, punch and ring were found by `weavesim new`.",
        ("weavesim form tray/job.toml",),
        ("tray/out/pictures/formed_sheet.png",),
        after="check",
    ),
    Exhibit(
        "stack",
        "Two plies at 0 and 45 degrees",
        "Formed together over a ball, with friction between them, and drawn apart ([stacks.md](stacks.md)).",
        ("weavesim stack --lay-up 0/45 --mesh-size 0.0075",),
        ("out/stack/pictures/stack.png",),
    ),
    Exhibit(
        "verdict",
        "A verdict by regions",
        "Where these two plies are beyond a limit: without a blank holder they wrinkle, and bridge hollows of the "
        "tools ([outputs.md](outputs.md#verdict)).",
        ("weavesim verdict out/stack --out verdict",),
        ("verdict/verdict.png",),
        after="stack",
        holds=_wrinkles_and_bridges,
    ),
    Exhibit(
        "hemisphere",
        "A cloth on a ball",
        "It falls by its weight. Above: low bending and high shear stiffness; below: the reverse.",
        ("weavesim hemisphere",),
        tuple(f"out/hemisphere/{case}/pictures/formed_sheet.png" for case in ("low-bending", "high-bending")),
    ),
    Exhibit(
        "grippers",
        "A blank on springs",
        "Held by springs at its edges, pushed 50 mm down by a ball, and released: friction between its yarns keeps "
        "more than half of that. A fabric without it springs back until it is flat.",
        ("weavesim grippers --fabric glass-polypropylene-consensus",),
        ("out/grippers/pictures/formed_sheet.png",),
        holds=_keeps_half,
    ),
    Exhibit(
        "bias_extension",
        "Bias extension",
        "A strip pulled at 45 degrees to its yarns: the middle shears as the kinematics say, the ends half as far "
        "([laboratory.md](laboratory.md)).",
        ("weavesim bias-extension",),
        ("out/bias_extension/pictures/formed_sheet.png",),
    ),
    Exhibit(
        "fabric_consensus",
        "The curves of a fabric",
        "What is known of a preset, with the scatter of the laboratories, and the ends of the data "
        "([fabrics.md](fabrics.md)).",
        ("weavesim fabric show glass-polypropylene-consensus --out fabric",),
        ("fabric/*.png",),
    ),
    Exhibit(
        "architecture",
        "The rooms of the code",
        "What imports what, and the paths of a step and of a result ([architecture.md](architecture.md)).",
        ("python scripts/architecture.py --out architecture.png",),
        ("architecture.png",),
    ),
)


def exhibits_text() -> str:
    """The part of docs/gallery.md that is made from ``EXHIBITS``."""
    text = ""
    for one in EXHIBITS:
        text += f"## {one.title}\n\n![{one.title}](images/{one.name}.png)\n\n{one.text}\n\n"
        text += "".join(f"    {command}\n" for command in one.commands) + ("\n" if one.commands else "")
    return text.rstrip("\n") + "\n"
