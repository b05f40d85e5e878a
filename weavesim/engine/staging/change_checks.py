"""Checks of what stages change of loads and friction: names that exist, and changes that a run can make."""

from __future__ import annotations

from collections.abc import Sequence

from ...errors import InputError, did_you_mean
from ...process.friction import NO_YARNS, YarnAngleFriction
from ...process.interfaces import Interface
from ...process.stages import Stage
from ...sheet.sheet import Sheet
from ...tools.tool import Tool


def check_changes(
    stages: Sequence[Stage], tools: Sequence[Tool], sheets: Sequence[Sheet], interfaces: Sequence[Interface]
) -> None:
    """Check loads and friction of all stages against what the run has.

    Raises:
        ValueError: a name that is not there or is given twice, a law that a tool cannot have, or loads that do not fit
            their sheet.
    """
    of_tools, of_interfaces = ([each.name for each in kind] for kind in (tools, interfaces))
    laws = [*of_tools, *of_interfaces]
    names = [sheet.name for sheet in sheets]
    for stage in stages:
        given = [each.name for each in stage.friction]
        for name in given:
            if name not in laws:
                there = f"there are {', '.join(laws)}" if laws else "the run has none"
                raise ValueError(
                    f"stage {stage.name}: friction: there is no tool or interface {name!r}; {there}"
                    f"{did_you_mean(name, laws)}"
                )
            if given.count(name) > 1:
                raise ValueError(f"stage {stage.name}: friction of {name} is given twice; give one")
        for each in stage.friction:
            if isinstance(each.friction, YarnAngleFriction) and each.name in of_tools:
                raise ValueError(f"stage {stage.name}: friction of {each.name}: {NO_YARNS}")
        _check_loads(stage, sheets, names)


def _check_loads(stage: Stage, sheets: Sequence[Sheet], names: list[str]) -> None:
    loaded: list[str] = []
    for each in stage.loads or ():
        if each.sheet is None and len(names) > 1:
            raise ValueError(f"stage {stage.name}: loads: sheet is required, one of {', '.join(names)}")
        name = names[0] if each.sheet is None else each.sheet
        if name not in names:
            raise ValueError(
                f"stage {stage.name}: loads: there is no sheet {name!r}; there are {', '.join(names)}"
                f"{did_you_mean(name, names)}"
            )
        if name in loaded:
            raise ValueError(f"stage {stage.name}: loads on {name} are given twice; give one NodalLoads for each sheet")
        loaded.append(name)
        try:
            each.loads.arrays(sheets[names.index(name)].blank.node_count)
        except InputError as error:
            raise ValueError(f"stage {stage.name}: {error}") from None
