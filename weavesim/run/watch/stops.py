"""Guards that end a run: those that its user has chosen, from a level on."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ...errors import InputError, did_you_mean
from ..guards import Doubt, Guards, Level, known_guards

if TYPE_CHECKING:
    from ..verdict import Judged

# What may stand for all guards, or behind the name of one: a note ends nothing.
LEVELS = {level.label.replace(" ", "-"): level for level in (Level.WARNING, Level.DO_NOT_USE)}


def stop_levels(names: Iterable[str]) -> dict[str, Level]:
    """Level from which on each guard ends a run, by its name.

    Args:
        names: each a guard ("self_intersection"), which ends a run by a warning; a guard with a level
            ("yarn_stretch:do-not-use"); or a level ("do-not-use"), for all guards that can end a run.

    Raises:
        InputError: no such guard or level, or a guard of which only the end of a run is judged.
    """
    if isinstance(names, str):
        raise InputError(f"stop_on = {names!r}: give a list, [{names!r}]")
    guards = known_guards()
    lasting = [name for name, guard in guards.items() if guard.lasting]
    found: dict[str, Level] = {}
    for given in names:
        name, colon, word = (part.strip() for part in given.partition(":"))
        if colon and word not in LEVELS:
            hint = did_you_mean(word, LEVELS)
            raise InputError(f"guard {given!r}: the level is one of {', '.join(LEVELS)}{hint}")
        if name in LEVELS and not colon:
            chosen, level = lasting, LEVELS[name]
        elif name in lasting:
            chosen, level = [name], LEVELS.get(word, Level.WARNING)
        elif name in guards:
            raise InputError(
                f"guard {given!r}: it judges a run by its end, or before it starts, and cannot end it; choose from "
                f"{', '.join(lasting)}"
            )
        else:
            hint = did_you_mean(name, [*lasting, *LEVELS])
            raise InputError(f"guard {given!r}: choose from {', '.join([*LEVELS, *lasting])}{hint}")
        for each in chosen:
            found[each] = min(level, found.get(each, level))
    return found


class Stops:
    """What ends a run before its time.

    Args:
        names: see ``stop_levels``.

    Attributes:
        by: the doubt that has ended it; None if none has.
    """

    def __init__(self, names: Iterable[str] = ()) -> None:
        self._levels = stop_levels(names)
        self.by: Doubt | None = None

    def pass_over(self, names: Iterable[str]) -> None:
        """Guards by which the run has ended, and after which its user has it go on."""
        for name in names:
            self._levels.pop(name, None)

    def look(self, guards: Guards, run: Judged) -> bool:
        """Whether a guard ends the run now."""
        if self._levels:
            for doubt in guards.so_far(run, self._levels):
                if doubt.level >= self._levels[doubt.guard]:
                    self.by = doubt
                    return True
        return False
