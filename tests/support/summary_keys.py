"""Keys of summaries: each number has its unit at the end of its name, or is known to be pure."""

from collections.abc import Iterator, Mapping
from numbers import Real
from typing import Any

from weavesim.measures.findings import SHEET_FINDINGS
from weavesim.measures.units import PURE, split_unit
from weavesim.run.verdict import RUN_FINDINGS
from weavesim.study.measures import STUDY_FINDINGS

# Tables and lists of several numbers, each by its own name.
OF_SEVERAL = {"interfaces", "stages", "trims", "sheet_intersections"}
# What these are has no unit.
PURE_ENDINGS = ("_count", "_ratio", "_share", "_coefficient", "_strain")
PURE_KEYS = {
    *(finding.key for finding in (*RUN_FINDINGS, *SHEET_FINDINGS, *STUDY_FINDINGS)
      if finding.unit == PURE and finding.key not in OF_SEVERAL),
    # of a run, of pairs of its sheets, of its stages and trims
    "at_end", "most", "total",
    # while it runs
    "share", "frame", "kinetic_over_internal",
    # of its verdict, whose limits say their units in docs/outputs.md
    "severity", "largest_compression", "limits",
    # of a cantilever
    "elastica_over_input", "peirce_over_input",
    # stretches and fractions of fields
    "warp_stretch", "weft_stretch", "fibre_volume_fraction",
}  # fmt: skip
# In the unit of what a warning is about, which its text tells.
OF_WARNINGS = {"value", "limit"}


def keys_without_unit(summary: Mapping[str, Any]) -> list[str]:
    """Dotted names of the numbers that have neither; also those whose unit is not in small letters."""
    return list(_found(summary, (), False))


def _found(value: Any, names: tuple[str, ...], known: bool) -> Iterator[str]:
    if isinstance(value, Mapping):
        for key, each in value.items():
            key = str(key)
            own = split_unit(key)[1] != PURE or key in PURE_KEYS or key.endswith(PURE_ENDINGS)
            of_warning = key in OF_WARNINGS and "doubts" in names
            yield from _found(each, (*names, key), known or own or of_warning)
    elif isinstance(value, list | tuple):
        for each in value:
            yield from _found(each, names, known)
    elif isinstance(value, Real) and not isinstance(value, bool) and not known:
        yield ".".join(names)
