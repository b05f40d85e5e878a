"""How many threads a run takes: measured on its own steps, and now and then anew."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

# Length of a turn on the number of threads that is fastest [s]: long beside the start of a thread.
STAY = 0.05
# Length of a turn that only looks at another number [s], several time slices of a busy core, and the shortest time
# between two looks at the same one.
LOOK = 0.03
REST = 0.2
# Share of a run that looks at one number of threads may cost.
LOOK_SHARE = 0.01


class Turn(NamedTuple):
    """What was done on one number of threads in a row."""

    blocks: int
    seconds: float
    looking: bool


class ThreadChoice:
    """Picks the fastest of a few numbers of threads while the work goes on.

    Work is done in turns. The next turn takes the number that was fastest of late, or looks at a neighbour of it: at
    once if that has never been tried, else when the time since the last look pays for what that look cost. So a number
    that other programs slow down is left after a slow turn or two, tried now and then, and taken again when it pays.

    Args:
        counts: numbers of threads, ascending; the first turn takes the first.
    """

    def __init__(self, counts: Sequence[int]) -> None:
        self.counts = tuple(counts)
        self.count = self.counts[0]
        self._turns: dict[int, tuple[Turn, ...]] = {}  # the last two, or the last look
        self._due = dict.fromkeys(self.counts, 0.0)  # time of the next look
        self._now = 0.0
        self._looking = True
        self._turn_blocks, self._turn_seconds = 0, 0.0
        self._blocks: Counter[int] = Counter()

    @property
    def most_used(self) -> int:
        """The number that most blocks were done on; before the first, the one to begin with."""
        return self._blocks.most_common(1)[0][0] if self._blocks else self.count

    def block_count(self) -> int:
        """Blocks after which the present turn should be over, one at least."""
        if not self._turns:
            return 1
        known = self.count if self.count in self._turns else self._fastest()
        left = (LOOK if self._looking else STAY) - self._turn_seconds
        return max(1, math.ceil(left / self._cost(known)))

    def report(self, block_count: int, seconds: float) -> None:
        """Take note that ``count`` threads did ``block_count`` blocks in ``seconds``, and choose ``count`` anew."""
        self._blocks[self.count] += block_count
        self._now += seconds
        self._turn_blocks += block_count
        self._turn_seconds += seconds
        # one block is enough if it is long; short ones count together
        if self._turn_seconds >= (LOOK if self._looking else STAY):
            self._end_turn()

    def _end_turn(self) -> None:
        turn = Turn(self._turn_blocks, max(self._turn_seconds, 1e-9), self._looking)
        self._turn_blocks, self._turn_seconds = 0, 0.0
        # a look is short and may have been lucky: it counts until there is more to go by
        before = () if turn.looking else tuple(t for t in self._turns.get(self.count, ())[-1:] if not t.looking)
        self._turns[self.count] = (*before, turn)
        fastest = self._fastest()
        lost = 0.0 if before else turn.seconds - turn.blocks * self._cost(fastest)
        self._due[self.count] = self._now + max(REST, lost / LOOK_SHARE)
        place = self.counts.index(fastest)
        neighbours = self.counts[max(place - 1, 0) : place] + self.counts[place + 1 : place + 2]
        due = [count for count in neighbours if self._due[count] <= self._now]
        self._looking = bool(due)
        self.count = min(due, key=lambda count: self._due[count]) if due else fastest

    def _cost(self, count: int) -> float:
        """Seconds per block of late."""
        turns = self._turns[count]
        return sum(turn.seconds for turn in turns) / sum(turn.blocks for turn in turns)

    def _fastest(self) -> int:
        return min(self._turns, key=self._cost)
