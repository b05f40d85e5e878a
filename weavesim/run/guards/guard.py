"""Guards: each watches one thing that can make a result wrong, and says so by name, level, place, time and advice.

A guard is one class in a module of this folder, or anywhere; defining it registers it. Runs ask it before they start,
while they run, and at their end.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import IntEnum
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any, ClassVar

from ...errors import InputError
from ...names import enter

if TYPE_CHECKING:
    import numpy as np

    from ...engine.model import Model
    from ...engine.sheet_model import SheetModel
    from ..frame import Frame
    from ..ledger import Ledger
    from ..staging.rehearsal import Phase
    from ..verdict import Judged

logger = logging.getLogger(__name__)

_known: dict[str, type[Guard]] = {}


class Level(IntEnum):
    """How much a doubt says against a result."""

    NOTE = 0
    WARNING = 1
    DO_NOT_USE = 2

    @property
    def label(self) -> str:
        """ "note", "warning", "do not use"."""
        return self.name.lower().replace("_", " ")


# What a run's verdict is, by the worst level among its doubts.
VERDICTS = {Level.NOTE: "trusted", Level.WARNING: "doubtful", Level.DO_NOT_USE: "do not use"}


@dataclass(frozen=True)
class Doubt:
    """Something that speaks against a result.

    Attributes:
        guard: name of the guard that says so.
        level: how much it says against the result.
        text: what was found, with numbers and units.
        advice: what it means, or what to do.
        sheet: its name; None for a run as a whole.
        place: (x, y) on the flat blank [m].
        time: [s]; None before the run, or for a run as a whole.
        value, limit: what was found, and the most that is allowed.
    """

    guard: str
    level: Level
    text: str
    advice: str = ""
    sheet: str | None = None
    place: tuple[float, float] | None = None
    time: float | None = None
    value: float | None = None
    limit: float | None = None

    @property
    def message(self) -> str:
        """Text, place, time and advice in one sentence."""
        where = [f"sheet {self.sheet}"] if self.sheet else []
        if self.place:
            where.append(f"at ({self.place[0]:.4g}, {self.place[1]:.4g}) m on the flat blank")
        if self.time is not None:
            where.append(f"at {self.time:.4g} s")
        text = f"{self.text} ({', '.join(where)})" if where else self.text
        return f"{text}: {self.advice}" if self.advice else text

    def as_dict(self) -> dict[str, Any]:
        """All of it for summary.json: units in the names, the name of the level, and the message."""
        values = asdict(self) | {"level": self.level.label, "message": self.message}
        return {{"place": "place_m", "time": "time_s"}.get(name, name): value for name, value in values.items()}


@dataclass(frozen=True)
class Start:
    """A run at time zero, as guards see it before it starts.

    Attributes:
        model: constants of the run, with its set-up; of its first stage, if it has some.
        ledger: measures distances from the tools.
        frame: the undeformed state.
        phases: stages of the run as they are planned, or the run itself if it has none.
        accepts_unusual: whether its user takes unusual values as meant.
    """

    model: Model
    ledger: Ledger
    frame: Frame
    phases: tuple[Phase, ...]
    accepts_unusual: bool = False

    def meetings(self) -> Iterator[tuple[SheetModel, np.ndarray, int]]:
        """Every sheet, its positions (node_count, 3) [m], and each tool that it may touch, by index in the run."""
        for sheet, frame in zip(self.model.sheets, self.frame.sheets, strict=True):
            for index in range(sheet.places.tools.start, sheet.places.tools.stop):
                yield sheet, frame.position, index


class Guard:
    """Base class of all guards; each run has its own instance, which may remember what it saw.

    A subclass overrides what it needs of ``before``, ``watch`` and ``after``.

    Attributes:
        name: in results; a class without a name is not a guard itself.
        watches: what it watches, in a few words.
        lasting: whether what ``so_far`` says of a run in progress is said at its end too: a user may then have it end
            the run (``run.watch.stops``).
    """

    name: ClassVar[str] = ""
    watches: ClassVar[str] = ""
    lasting: ClassVar[bool] = False

    def __init_subclass__(cls) -> None:
        if cls.__dict__.get("name"):
            enter(_known, cls.name, cls, "guard")

    def before(self, start: Start) -> Iterable[Doubt]:
        """Doubts that are known before the run starts.

        Raises:
            InputError: the run must not start.
        """
        return ()

    def watch(self, frame: Frame, ledger: Ledger) -> None:
        """Called about eighty times in a run, at times that do not depend on its frames; nothing is returned."""

    def after(self, run: Judged) -> Iterable[Doubt]:
        """Doubts about the run so far; may be called more than once."""
        return ()

    def so_far(self, run: Judged) -> Iterable[Doubt]:
        """Of a ``lasting`` guard: doubts about a run in progress that will hardly be taken back; by default all."""
        return self.after(run)

    def memory(self) -> Mapping[str, Any]:
        """What ``watch`` remembers, for a checkpoint: plain values, lists, dictionaries with text for keys, arrays."""
        return {}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Take back what ``memory`` returned, when a run goes on after ``before``; tuples come back as lists."""

    @property
    def forgets(self) -> bool:
        """Whether it watches a run, but has no ``memory``: then it begins anew when a run goes on."""
        kind = type(self)
        return kind.watch is not Guard.watch and kind.memory is Guard.memory

    def doubt(self, level: Level, text: str, advice: str = "", **where: Any) -> Doubt:
        """A doubt of this guard; ``where`` are the other attributes of ``Doubt``."""
        return Doubt(self.name, level, text, advice, **where)


def known_guards() -> dict[str, type[Guard]]:
    """All known guards by name, in alphabetical order."""
    package = import_module(__package__)
    for module in iter_modules(package.__path__):
        import_module(f"{package.__name__}.{module.name}")
    return dict(sorted(_known.items()))


class Guards:
    """The guards of one run.

    Attributes:
        first: doubts that were known before the run.
    """

    def __init__(self) -> None:
        self._guards: Sequence[Guard] = [guard() for guard in known_guards().values()]
        self.first: list[Doubt] = []
        self._failed: dict[str, Doubt] = {}

    def before(self, start: Start) -> list[Doubt]:
        """Ask all guards before the run; keeps and returns their doubts.

        Raises:
            InputError: the run must not start.
        """
        self.first = self._ask(lambda guard: guard.before(start))
        return self.first

    def watch(self, frame: Frame, ledger: Ledger) -> None:
        """Show all guards the current state."""

        def show(guard: Guard) -> Iterable[Doubt]:
            guard.watch(frame, ledger)
            return ()

        self._ask(show)

    def after(self, run: Judged) -> list[Doubt]:
        """All doubts about the run so far, the worst first."""
        found = [*self.first, *self._ask(lambda guard: guard.after(run)), *self._failed.values()]
        return sorted(dict.fromkeys(found), key=lambda doubt: -doubt.level)

    def so_far(self, run: Judged, names: Container[str]) -> list[Doubt]:
        """What the ``lasting`` guards of these names say of a run in progress, the worst first."""
        found = self._ask(lambda guard: guard.so_far(run) if guard.lasting and guard.name in names else ())
        return sorted(found, key=lambda doubt: -doubt.level)

    def memory(self) -> dict[str, Any]:
        """What all guards remember, for a checkpoint."""
        failed = {name: {**asdict(doubt), "level": int(doubt.level)} for name, doubt in self._failed.items()}
        return {"failed": failed, "guards": {guard.name: dict(guard.memory()) for guard in self._guards}}

    def recall(self, memory: Mapping[str, Any], time: float) -> None:
        """Give all guards what they remembered at ``time`` [s]; those without a memory are a doubt from then on."""
        for name, values in memory["failed"].items():
            place = None if values["place"] is None else tuple(values["place"])
            self._failed[name] = Doubt(**{**values, "level": Level(values["level"]), "place": place})
        for guard in self._guards:
            if guard.name in memory["guards"] and not guard.forgets:
                guard.recall(memory["guards"][guard.name])
            elif guard.forgets:
                text = f"the guard {guard.name} knows nothing of the run before {time:.4g} s, where it was resumed"
                advice = f"{guard.watches or 'what it watches'} was watched from then on only"
                self._failed.setdefault(guard.name, Doubt(guard.name, Level.WARNING, text, advice))

    def _ask(self, question: Callable[[Guard], Iterable[Doubt]]) -> list[Doubt]:
        """Answers of all guards, each once; a guard that fails is a doubt, and costs nobody a result."""
        found: list[Doubt] = []
        for guard in self._guards:
            try:
                found += question(guard)
            except InputError:
                raise
            except Exception as error:
                logger.debug("guard %s failed", guard.name, exc_info=True)
                text = f"the guard {guard.name} failed ({type(error).__name__}: {error})"
                failure = Doubt(guard.name, Level.WARNING, text, f"nothing watches {guard.watches or 'what it should'}")
                self._failed.setdefault(guard.name, failure)
        return list(dict.fromkeys(found))


def verdict_of(doubts: Iterable[Doubt]) -> str:
    """ "trusted", "doubtful" or "do not use"."""
    return VERDICTS[max((doubt.level for doubt in doubts), default=Level.NOTE)]


def report_new(find: Callable[[], Iterable[Doubt]], known: Iterable[Doubt], warnings: list[str]) -> None:
    """Add doubts that were not ``known`` before the run to its ``warnings`` and the log; notes to the log alone.

    Where they cannot be found, that is a warning: the results are still worth having.
    """
    before = set(known)
    try:
        doubts = list(find())
    except Exception as error:
        warnings.append(f"the result could not be judged: {type(error).__name__}: {error}")
        logger.warning("%s", warnings[-1], exc_info=error)
        return
    for doubt in doubts:
        if doubt in before:
            continue
        if doubt.level > Level.NOTE:
            warnings.append(doubt.message)
            logger.warning("%s", doubt.message)
        else:
            logger.info("%s", doubt.message)
