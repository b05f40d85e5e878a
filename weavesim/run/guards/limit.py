"""Guards of one number of the summary each."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from .guard import Doubt, Guard, Level

if TYPE_CHECKING:
    from ..verdict import Judged


class LimitGuard(Guard):
    """A number of the summary with an upper limit; one that is not finite is above it, and one that has no
    meaning for a run is not doubted.

    Attributes:
        key: of the number.
        text: description of the number.
        largest: largest value allowed.
        advice: what it means, or what to do.
        level: beyond ``largest``.
    """

    key: ClassVar[str] = ""
    text: ClassVar[str] = ""
    largest: ClassVar[float] = 0.0
    advice: ClassVar[str] = ""
    level: ClassVar[Level] = Level.WARNING

    def limit(self, run: Judged) -> float:
        """Largest value allowed for a run."""
        return self.largest

    def useless_beyond(self, run: Judged) -> float | None:
        """From where on the result must not be used; None if it may be."""
        return None

    def where(self, run: Judged) -> Mapping[str, Any]:
        """Sheet, place and time of the number, as attributes of ``Doubt``, as far as it has them."""
        return {}

    def after(self, run: Judged) -> Iterable[Doubt]:
        """The number, if it is above its limit."""
        return self.of(run, run.number(self.key))

    def of(self, run: Judged, value: float | None) -> Iterable[Doubt]:
        """What a value of the number says."""
        limit, worst = self.limit(run), self.useless_beyond(run)
        if value is not None and not value <= limit:
            useless = worst is not None and not value <= worst
            yield self.doubt(
                Level.DO_NOT_USE if useless else self.level,
                f"{self.text} is {value:.3g}, above {limit:g}",
                self.advice,
                value=float(value),
                limit=float(limit),
                **self.where(run),
            )
