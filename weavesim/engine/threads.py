"""How many threads a run uses: measured on its own steps, and again from time to time; and who takes turns with it."""

from __future__ import annotations

import math
import sys
import threading
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

from ..device import available_threads

# Length of a turn on the fastest number of threads [s]: long compared with starting a thread.
TURN = 0.05
# Length of a probe, a turn that only measures another number [s]: several time slices of a busy core. Shortest time
# between two probes of the same number.
PROBE = 0.03
PROBE_INTERVAL = 0.2
# Share of the run time that probes of one number of threads may cost.
PROBE_SHARE = 0.01

_changing = threading.Lock()
# Contexts of ``beside_steps``; the intervals of those of ``soon`` [s], after the one that was there before any.
_beside_count = 0
_intervals: list[float] = []


@contextmanager
def beside_steps() -> Iterator[None]:
    """For a thread that computes while others of this process step: runs that choose their threads leave it a core."""
    global _beside_count
    with _changing:
        _beside_count += 1
    try:
        yield
    finally:
        with _changing:
            _beside_count -= 1


def anyone_beside() -> bool:
    """Whether any thread is in ``beside_steps``."""
    return _beside_count > 0


@contextmanager
def soon(interval: float) -> Iterator[None]:
    """Inside this context, a thread that wants to run Python gets its turn within ``interval`` [s], or what it was.

    Contexts of several threads may end in any order; after the last, all is as before the first.
    """
    with _changing:
        if not _intervals:
            _intervals.append(sys.getswitchinterval())
        _intervals.append(interval)
        sys.setswitchinterval(min(_intervals))
    try:
        yield
    finally:
        with _changing:
            _intervals.remove(interval)
            sys.setswitchinterval(min(_intervals))
            if len(_intervals) == 1:
                _intervals.clear()


class Turn(NamedTuple):
    """Work done in a row on one number of threads."""

    blocks: int
    seconds: float
    probe: bool


class ThreadChoice:
    """Picks the fastest of a few numbers of threads while the run goes on.

    Work is done in turns. The next turn uses the number that was fastest recently, or probes the next lower or higher
    one: at once if that was never tried, otherwise when enough time has passed to make up for the cost of its last
    probe. A number that other programs slow down is dropped after a slow turn or two, probed occasionally, and used
    again when it is fastest again.

    While other threads of this process compute (``beside_steps``), another choice takes its place: what is measured
    then holds for then only.

    Args:
        counts: numbers of threads, ascending; the first turn uses the first.
    """

    def __init__(self, counts: Sequence[int]) -> None:
        self.counts = tuple(counts)
        self._meanwhile: dict[tuple[int, ...], ThreadChoice] = {}  # other choices, by their numbers
        self.count = self.counts[0]
        self._turns: dict[int, tuple[Turn, ...]] = {}  # the last two, or the last probe
        self._due = dict.fromkeys(self.counts, 0.0)  # time of the next probe
        self._now = 0.0
        self._probing = True
        self._turn_blocks, self._turn_seconds = 0, 0.0
        self._blocks: Counter[int] = Counter()

    @property
    def most_used(self) -> int:
        """The number that did most blocks; before the first block, the one to begin with."""
        blocks = sum((other._blocks for other in self._meanwhile.values()), self._blocks)
        return blocks.most_common(1)[0][0] if blocks else self.count

    def present(self) -> ThreadChoice:
        """What to take now: this choice, or one among the numbers that leave a core to everybody else who computes.

        A single number that was given stays.
        """
        if not _beside_count or len(self.counts) == 1:
            return self
        most = available_threads() - _beside_count
        counts = tuple(count for count in self.counts if count <= most) or self.counts[:1]
        return self._meanwhile.setdefault(counts, ThreadChoice(counts))

    def block_count(self) -> int:
        """Blocks until the current turn should end, at least one."""
        left = (PROBE if self._probing else TURN) - self._turn_seconds
        if self._turns:
            cost = self._cost(self.count if self.count in self._turns else self._fastest())
        elif self._turn_blocks:
            cost = self._turn_seconds / self._turn_blocks
        else:
            return 1
        return max(1, math.ceil(left / max(cost, 1e-9)))

    def report(self, block_count: int, seconds: float) -> None:
        """Record that ``count`` threads did ``block_count`` blocks in ``seconds``, and update ``count``."""
        self._blocks[self.count] += block_count
        self._now += seconds
        self._turn_blocks += block_count
        self._turn_seconds += seconds
        # one long block is a turn by itself; short ones are added up
        if self._turn_seconds >= (PROBE if self._probing else TURN):
            self._end_turn()

    def _end_turn(self) -> None:
        turn = Turn(self._turn_blocks, max(self._turn_seconds, 1e-9), self._probing)
        self._turn_blocks, self._turn_seconds = 0, 0.0
        # a probe is short and may be a fluke: a full turn replaces it
        before = () if turn.probe else tuple(t for t in self._turns.get(self.count, ())[-1:] if not t.probe)
        self._turns[self.count] = (*before, turn)
        fastest = self._fastest()
        lost = 0.0 if before else turn.seconds - turn.blocks * self._cost(fastest)
        self._due[self.count] = self._now + max(PROBE_INTERVAL, lost / PROBE_SHARE)
        place = self.counts.index(fastest)
        neighbours = self.counts[max(place - 1, 0) : place] + self.counts[place + 1 : place + 2]
        due = [count for count in neighbours if self._due[count] <= self._now]
        self._probing = bool(due)
        self.count = min(due, key=lambda count: self._due[count]) if due else fastest

    def _cost(self, count: int) -> float:
        """Recent seconds per block."""
        turns = self._turns[count]
        return sum(turn.seconds for turn in turns) / sum(turn.blocks for turn in turns)

    def _fastest(self) -> int:
        return min(self._turns, key=self._cost)
