"""The notation of lay-ups: "0/45/-45/90", "[0/90]s", "[45/-45]2s" to angles, bottom to top.

A code is a list of angles [degrees] and of groups in brackets, separated by slashes or commas. After a group may stand
how often it is repeated, then "s" for symmetric (followed by its mirror image), or "t" for total (nothing follows). An
angle may be repeated with an underscore, "0_3". "±45" is 45/-45.
"""

from __future__ import annotations

import re

from ..errors import InputError

# More are a slip.
LARGEST_PLY_COUNT = 500
EXAMPLES = 'write it as "0/45/-45/90", "[0/90]s" or "[45/-45]2s", angles in degrees, from the bottom to the top'

_TOKEN = re.compile(
    r"\s*(?:(?P<open>[\[(])|(?P<close>[\])])|(?P<separator>[/,;|])|(?P<underscore>_)|(?P<letter>[a-z]+)"
    r"|(?P<angle>(?:\+-|-\+|\+/-|±|∓|[+-])?\s*\d+(?:\.\d*)?|(?:\+-|-\+|\+/-|±|∓|[+-])?\s*\.\d+))",
    re.IGNORECASE,
)
_CLOSING = {"[": "]", "(": ")"}
# Signs of the two plies of a pair.
_PAIRS = {"±": (1.0, -1.0), "+-": (1.0, -1.0), "+/-": (1.0, -1.0), "∓": (-1.0, 1.0), "-+": (-1.0, 1.0)}


def angles_of(code: str) -> tuple[float, ...]:
    """Angles of all plies [degrees], bottom to top.

    Raises:
        InputError: a code that cannot be read, or of too many plies.
    """
    reader = _Reader(code)
    angles = reader.stack()
    if reader.kind:
        reader.refuse(
            f"{reader.text!r} has no opening bracket" if reader.kind == "close" else _after_group(reader.text)
        )
    return tuple(angles)


def code_of(angles: tuple[float, ...]) -> str:
    """The shortest of the usual codes: symmetric and repeated lay-ups in brackets."""
    plain = "/".join(f"{angle:g}" for angle in angles)
    count = len(angles)
    for half in (True, False):
        if half and (count % 2 or angles != angles[::-1]):
            continue
        own = angles[: count // 2] if half else angles
        length = next(k for k in range(1, len(own) + 1) if len(own) % k == 0 and own[:k] * (len(own) // k) == own)
        times = len(own) // length
        if half or times > 1:
            inner = "/".join(f"{angle:g}" for angle in own[:length])
            return f"[{inner}]{times if times > 1 else ''}{'s' if half else ''}"
    return plain


def _after_group(text: str) -> str:
    return f"{text!r} is not expected there; a group of plies that is repeated or symmetric stands in brackets"


class _Reader:
    """Reads a code from left to right.

    Attributes:
        kind: of the next token; "" at the end.
        text: of the next token.
    """

    def __init__(self, code: str) -> None:
        self._given = code
        self._code = code.strip().replace("\u2212", "-").replace("°", "")
        self._place = 0
        self.kind = self.text = ""
        self._advance()

    def refuse(self, problem: str) -> None:
        """Raise the error."""
        raise InputError(f"lay-up {self._given!r}: {problem}; {EXAMPLES}")

    def _advance(self) -> None:
        self.kind, self.text = "", ""
        if self._place >= len(self._code):
            return
        found = _TOKEN.match(self._code, self._place)
        if found is None or found.lastgroup is None:
            self.refuse(f"{self._code[self._place :].strip()[:1]!r} at character {self._place + 1} is not understood")
            return
        self.kind, self.text, self._place = found.lastgroup, found.group(found.lastgroup), found.end()

    def stack(self) -> list[float]:
        """Items up to a closing bracket or the end."""
        angles = self._item()
        while self.kind == "separator":
            self._advance()
            angles += self._item()
            self._check_count(len(angles))
        return angles

    def _item(self) -> list[float]:
        if self.kind == "open":
            return self._group()
        if self.kind != "angle":
            what = f"before {self.text!r}" if self.kind else "at the end"
            self.refuse(f"an angle is missing {what}" if self._code else "it is empty")
        sign = re.match(r"[^\d.\s]*", self.text)
        prefix = sign.group() if sign else ""
        if prefix in _PAIRS:
            value = float(self.text[len(prefix) :])
            angles = [factor * value for factor in _PAIRS[prefix]]
        else:
            angles = [float(self.text.replace(" ", ""))]
        self._advance()
        if self.kind == "underscore":
            self._advance()
            times = self._count("the underscore")
            angles = [angle for angle in angles for _ in range(times)]
        return angles

    def _group(self) -> list[float]:
        opening = self.text
        self._advance()
        angles = self.stack()
        if self.kind != "close" or self.text != _CLOSING[opening]:
            found = repr(self.text) if self.kind else "the end"
            self.refuse(f"{found} stands where {_CLOSING[opening]!r} must close {opening!r}")
        self._advance()
        if self.kind == "underscore":
            self._advance()
        if self.kind == "angle":
            angles = angles * self._count("a group")
        if self.kind == "letter":
            letter = self.text.lower()
            if letter not in ("s", "t"):
                self.refuse(f"{self.text!r} after a group: s for symmetric or t for total is allowed")
            angles = angles + angles[::-1] if letter == "s" else angles
            self._advance()
        self._check_count(len(angles))
        return angles

    def _count(self, after: str) -> int:
        """A whole number of repeats, which is the next token."""
        if self.kind != "angle" or not self.text.isdigit() or not 1 <= int(self.text) <= LARGEST_PLY_COUNT:
            found = repr(self.text) if self.kind else "nothing"
            self.refuse(f"{found} after {after}: a number of repeats from 1 to {LARGEST_PLY_COUNT} is needed")
        count = int(self.text)
        self._advance()
        return count

    def _check_count(self, count: int) -> None:
        if count > LARGEST_PLY_COUNT:
            self.refuse(f"more than {LARGEST_PLY_COUNT} plies")
