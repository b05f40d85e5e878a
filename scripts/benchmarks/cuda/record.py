"""The record of what every kernel needs on CUDA devices: what a change may not exceed.

A kernel whose source Warp hashes as it did when it was recorded, with the same options and the same version of Warp,
gives the same binary: by that hash Warp itself decides whether to compile. So only kernels that have changed are built.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import astuple, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from ...shared.kernel_content import content_of
from .resources import Resources, short_name

if TYPE_CHECKING:
    import warp as wp

RECORD = Path(__file__).resolve().parents[3] / "tests" / "unit" / "scripts" / "cuda" / "record.json"
ARCHITECTURES = (80, 90)
# Of instructions: the same source is not always the same number of them where something else of the module changes.
SPARE_INSTRUCTIONS = 1.03
# Options of a module that are for CPUs alone.
OF_CPU = ("cpu_", "extra_cpu_")


def content(kernel: wp.Kernel) -> str:
    """Hash of all that a kernel's binary for a GPU is made from, but for Warp and its compiler."""
    return content_of(kernel, lambda option: option.startswith(OF_CPU))


@dataclass(frozen=True)
class Entry:
    """One kernel in one precision, what asks for it, and what it needs on each architecture that it was built for."""

    kernel: str
    precision: str
    users: tuple[str, ...]
    content: str
    needs: Mapping[int, Resources]


@dataclass
class Record:
    """What was recorded with one version of Warp."""

    warp: str
    entries: list[Entry] = field(default_factory=list)

    @classmethod
    def read(cls, path: Path = RECORD) -> Record:
        """Raises OSError or ValueError if there is none."""
        stored = json.loads(path.read_text(encoding="utf-8"))
        entries = [
            Entry(
                each["kernel"],
                each["precision"],
                tuple(each["users"]),
                each["content"],
                {sm: Resources(*each[f"sm_{sm}"]) for sm in ARCHITECTURES if f"sm_{sm}" in each},
            )
            for each in stored["kernels"]
        ]
        return cls(stored["warp"], entries)

    def write(self, path: Path = RECORD) -> None:
        """One line for each kernel, so that a difference can be read."""
        lines = [
            json.dumps(
                {
                    "kernel": entry.kernel,
                    "precision": entry.precision,
                    "users": entry.users,
                    "content": entry.content,
                    **{f"sm_{one}": astuple(entry.needs[one]) for one in ARCHITECTURES if one in entry.needs},
                }
            )
            for entry in sorted(self.entries, key=lambda one: (one.kernel, one.precision, one.users))
        ]
        partial = path.with_suffix(".partial")
        partial.write_text(f'{{"warp": "{self.warp}", "kernels": [\n' + ",\n".join(lines) + "\n]}\n", encoding="utf-8")
        partial.replace(path)

    def knows(self, found: str, warp: str) -> bool:
        """Whether a kernel of this content has been recorded with this version of Warp."""
        return warp == self.warp and any(entry.content == found for entry in self.entries)

    def bound(self, kernel: str, precision: str, users: Iterable[str], architecture: int) -> Resources | None:
        """The most that a kernel of this name may need for each of its users; None if one of them is not recorded.

        A user with several kernels of a name may need as much as the largest of them.
        """
        bounds = []
        for user in users:
            own = [
                entry.needs[architecture]
                for entry in self.entries
                if (entry.kernel, entry.precision) == (kernel, precision)
                and user in entry.users
                and architecture in entry.needs
            ]
            if not own:
                return None
            bounds.append([max(values) for values in zip(*map(astuple, own), strict=True)])
        return Resources(*(min(values) for values in zip(*bounds, strict=True)))


def excess(needs: Resources, bound: Resources | None) -> list[str]:
    """In what a kernel exceeds its bound, in words; empty if in nothing, or if there is none."""
    if bound is None:
        return []
    pairs = {
        "registers": (needs.registers, bound.registers, 1.0),
        "bytes of stack": (needs.stack, bound.stack, 1.0),
        "instructions": (needs.instructions, bound.instructions, SPARE_INSTRUCTIONS),
    }
    return [f"{now} {name}, recorded {before}" for name, (now, before, spare) in pairs.items() if now > spare * before]


def renewed(
    record: Record,
    kernels: Mapping[str, Mapping[wp.Kernel, list[str]]],
    warp: str,
    build: Callable[[list[tuple[wp.Kernel, int]]], Iterable[Resources]],
    done: Callable[[Record], None],
) -> tuple[Record, list[str]]:
    """A record of these kernels, and what of it exceeds ``record``; what that knows is not built again.

    Args:
        record: from before.
        kernels: by precision, with their users.
        warp: its version now.
        build: gives what each of several kernels needs on an architecture, in their order.
        done: is given what is known after each build.
    """
    known = {entry.content: dict(entry.needs) for entry in record.entries} if warp == record.warp else {}
    every = [(precision, kernel, users) for precision, of in kernels.items() for kernel, users in of.items()]
    contents = {kernel: content(kernel) for _, kernel, _ in every}
    wanted = [
        (kernel, architecture)
        for architecture in reversed(ARCHITECTURES)
        for kernel in contents
        if architecture not in known.get(contents[kernel], {})
    ]

    def present() -> Record:
        return Record(
            warp,
            [
                Entry(short_name(kernel), precision, tuple(users), contents[kernel], dict(known[contents[kernel]]))
                for precision, kernel, users in every
                if contents[kernel] in known
            ],
        )

    for (kernel, architecture), needs in zip(wanted, build(wanted), strict=True):
        known.setdefault(contents[kernel], {})[architecture] = needs
        done(present())
    built, grown = {(contents[kernel], architecture) for kernel, architecture in wanted}, []
    for entry in present().entries:
        for architecture in ARCHITECTURES:
            if (entry.content, architecture) in built:
                bound = record.bound(entry.kernel, entry.precision, entry.users, architecture)
                over = excess(entry.needs[architecture], bound)
                place = f"{entry.kernel}, {entry.precision}, sm_{architecture}, {entry.users[0]}"
                grown += [f"{place}: {one}" for one in over]
    return present(), grown
