"""Decks of Abaqus and CalculiX (.inp): nodes and surface elements, of parts as their assembly places them.

meshio forgets the first block of nodes at the second, and the places of instances; hence a reader of our own.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from ...errors import InputError
from ..kinds import is_text, looks_like
from ..mesh_file import Cells, MeshFile
from ..source import LARGEST_COUNT, Source, counted, listed, number, numbers, whole
from .abaqus_elements import AXISYMMETRIC, kind_of
from .deck_lines import Line, lines_of_deck
from .grid import Block, Grid, Placement

# Keywords that make or move nodes and elements in ways that are not followed here, with what to do.
_REFUSED = {
    **dict.fromkeys(
        ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY"), "write the deck with all nodes and elements"
    ),
    **dict.fromkeys(("INCLUDE", "MANIFEST"), "copy the content of the other file to this place in the deck"),
    "IMPERFECTION": "write the deck with the nodes where they are",
    "PARAMETER": "write the deck with numbers in place of the parameters",
    "RIGID SURFACE": "mesh the tool with rigid elements, or export it as STL",
    **dict.fromkeys(("ADJUST", "SYMMETRIC MODEL GENERATION"), "write the deck with all nodes where they are"),
    "IMPORT": "write the deck with all nodes and elements",
}
_TYPE_NAME = re.compile(r"[A-Z0-9]{1,12}\Z")


@dataclass
class _Card:
    """A keyword line, and where its data lines are."""

    keyword: str
    options: dict[str, str]
    line: Line
    data: list[tuple[Line, bytes]] = field(default_factory=list)


@dataclass
class _Deck:
    """What the cards of a deck say: a grid of its own, parts, and instances of them.

    Attributes:
        left_out: numbers of elements that bound no surface, by type.
        plane: whether there are nodes without a third coordinate.
    """

    source: Source
    grid: Grid = field(default_factory=lambda: Grid("the deck"))
    parts: dict[str, Grid] = field(default_factory=dict)
    instances: list[tuple[Placement, str, Grid]] = field(default_factory=list)
    has_assembly: bool = False
    left_out: dict[str, int] = field(default_factory=dict)
    plane: bool = False


def read_abaqus(source: Source) -> MeshFile:
    """Vertices and surface cells of a deck of Abaqus or CalculiX, of all instances of its parts.

    Raises:
        InputError: damaged, or volumes, elements of an unknown type, or keywords that are not followed.
    """
    if not is_text(source.data):
        raise source.misnamed("a deck", "binary data")
    deck = _Deck(source)
    seen = False
    current = deck.grid
    for card in _cards(source):
        seen = True
        try:
            current = _take(deck, card, current)
        except InputError:
            raise
        except ValueError as error:
            raise source.error(f"line {error.args[0] if error.args else card.line}: {_NEEDED[card.keyword]}") from None
    if not seen:
        kind = looks_like(source.data)
        raise source.error(f"it looks like {kind}, not like a deck" if kind else "it has no keywords, like *NODE")
    return _assembled(deck)


_NEEDED = {
    "NODE": "the number of a node and its finite coordinates are expected",
    "ELEMENT": "the number of an element and those of all its nodes are expected",
    "INSTANCE": "three numbers of a translation, then seven of a rotation are expected",
}


def _cards(source: Source) -> Iterator[_Card]:
    card: _Card | None = None
    begun: tuple[Line, bytes] | None = None
    for line, text in lines_of_deck(source):
        if begun is None and not text.startswith(b"*"):
            if card is None:
                kind = looks_like(source.data)
                raise source.error(
                    f"line {line}: text before the first keyword" + (f"; it looks like {kind}" if kind else "")
                )
            card.data.append((line, text))
            continue
        start, text = (begun[0], begun[1] + text) if begun else (line, text)
        if text.endswith(b","):  # the keyword line goes on
            begun = (start, text)
            continue
        begun = None
        if card is not None:
            yield card
        card = _card(start, text)
    if begun is not None:
        raise source.error(f"the file ends within the keyword of line {begun[0]}", "copy or export it again")
    if card is not None:
        yield card


def _card(line: Line, text: bytes) -> _Card:
    # a comma within quotes belongs to a name
    words = re.findall(r'(?:"[^"]*"|[^,"])+', text.decode("latin-1")[1:])
    keyword = " ".join(words[0].split()).upper() if words else ""
    options = {}
    for word in words[1:]:
        name, _, value = word.partition("=")
        options["".join(name.split()).upper()] = value.strip().strip('"')
    return _Card(keyword, options, line)


def _take(deck: _Deck, card: _Card, current: Grid) -> Grid:
    """Take what a card says; returns the grid that nodes and elements of the next cards belong to."""
    refuse = deck.source.error
    keyword, options = card.keyword, card.options
    if keyword in _REFUSED:
        raise refuse(f"line {card.line}: *{keyword} is not followed", _REFUSED[keyword])
    if keyword == "SYSTEM" and card.data:
        raise refuse(f"line {card.line}: *SYSTEM moves the nodes", "write the deck with nodes in one system")
    if keyword == "SURFACE" and options.get("TYPE", "").upper() in ("SEGMENTS", "CYLINDER", "REVOLUTION"):
        raise refuse(
            f"line {card.line}: an analytical rigid surface has no elements",
            "mesh the tool with rigid elements, or export it as STL",
        )
    if keyword == "NODE":
        _take_nodes(deck, card, current)
    elif keyword == "ELEMENT":
        _take_elements(deck, card, current)
    elif keyword == "PART":
        name = options.get("NAME", "").upper()
        if name in deck.parts:
            raise refuse(f"line {card.line}: a second part has the same name")
        deck.parts[name] = Grid(f"part {len(deck.parts) + 1}")
        return deck.parts[name]
    elif keyword == "ASSEMBLY":
        deck.has_assembly = True
    elif keyword == "INSTANCE":
        return _begin_instance(deck, card)
    elif keyword in ("END PART", "END INSTANCE", "END ASSEMBLY"):
        return deck.grid
    return current


def _begin_instance(deck: _Deck, card: _Card) -> Grid:
    part = card.options.get("PART", "").upper()
    if "LIBRARY" in card.options or part not in deck.parts:
        raise deck.source.error(
            f"line {card.line}: an instance of a part that is not in this deck", "write the deck with all its parts"
        )
    grid = Grid(f"instance {len(deck.instances) + 1}")
    deck.instances.append((_placement(card), part, grid))
    deck.has_assembly = True
    return grid


def _placement(card: _Card) -> Placement:
    rows = []
    for line, text in card.data:
        try:
            rows.append([number(word) if word.strip() else 0.0 for word in _fields(text)])
        except ValueError:
            raise ValueError(line) from None
        if (len(rows), len(rows[-1])) not in ((1, 1), (1, 2), (1, 3), (2, 7)):
            raise ValueError(line)
    translation = np.zeros(3)
    if rows:
        translation[: len(rows[0])] = rows[0]
    placement = Placement(translation)
    if len(rows) > 1:
        axis = np.subtract(rows[1][3:6], rows[1][:3])
        if not np.linalg.norm(axis) > 0.0:
            raise ValueError(card.data[1][0])
        placement = Placement(translation, np.array(rows[1][:3]), axis, rows[1][6])
    return placement


def _fields(text: bytes) -> list[bytes]:
    """Fields of a data line; a comma at its end ends no field."""
    fields = text.split(b",")
    return fields[:-1] if not fields[-1].strip() else fields


def _take_nodes(deck: _Deck, card: _Card, grid: Grid) -> None:
    options = card.options
    if "INPUT" in options or "FILE" in options:
        raise deck.source.error(f"line {card.line}: nodes in another file", "copy them to this place in the deck")
    if options.get("SYSTEM", "R").upper() != "R":
        raise deck.source.error(
            f"line {card.line}: nodes in cylindrical or spherical coordinates", "write the deck with x, y and z"
        )
    ids = np.empty(len(card.data), dtype=np.int64)
    position = np.zeros((len(card.data), 3))
    for row, (line, text) in enumerate(card.data):
        fields = _fields(text)
        try:
            ids[row] = whole(fields[0])
            given = fields[1:4]
            # coordinates, then a normal: none of them with a point are numbers with decimal commas
            if len(fields) > 4 and not any(b"." in word or b"E" in word.upper() for word in fields[1:]):
                raise deck.source.error(
                    f"line {line}: {len(fields) - 1} whole numbers in place of three coordinates, as decimal "
                    "commas make them",
                    "write decimals with a point",
                )
            if not given or ids[row] < 1:
                raise ValueError
            position[row, : len(given)] = _coordinates(given)
        except InputError:
            raise
        except (ValueError, IndexError):
            raise ValueError(line) from None
        deck.plane |= len(given) < 3
    if len(ids):
        grid.nodes.append((ids, position))


def _coordinates(fields: list[bytes]) -> list[float]:
    try:
        return numbers(fields)
    except ValueError:
        return [number(word) if word.strip() else 0.0 for word in fields]  # one left empty is zero


def _take_elements(deck: _Deck, card: _Card, grid: Grid) -> None:
    options = card.options
    if "INPUT" in options or "FILE" in options:
        raise deck.source.error(f"line {card.line}: elements in another file", "copy them to this place in the deck")
    name = options.get("TYPE", "").upper()
    if not _TYPE_NAME.match(name):
        raise deck.source.error(f"line {card.line}: elements without a type")
    kind = kind_of(name)
    if kind is None:
        raise deck.source.error(
            f"line {card.line}: elements of type {name}, which is not known here",
            "write the surface as shells or rigid elements, such as S3, S4, R3D3 and R3D4",
        )
    if kind[0] in ("line", "point", "volume"):
        count = sum(not text.endswith(b",") for _, text in card.data)
        if kind[0] == "volume" and count:
            raise deck.source.error(
                f"line {card.line}: {counted(count, 'element')} of type {name} that fill a volume",
                "write its surface instead, as shells or rigid elements",
            )
        deck.left_out[name] = deck.left_out.get(name, 0) + count
        return
    rows, lines, begun = [], [], []
    for line, text in card.data:
        begun += _fields(text)
        if text.endswith(b",") and len(begun) <= kind[1]:
            continue
        if len(begun) != kind[1] + 1:
            raise ValueError(line)
        try:
            rows.append([whole(word) for word in begun])
        except ValueError:
            raise ValueError(line) from None
        lines.append(line)
        begun = []
    if begun:
        raise ValueError(card.data[-1][0])
    if rows:
        table = np.array(rows, dtype=np.int64)
        grid.blocks.append(Block(kind[0], name, table[:, 0], table[:, 1:], np.array(lines)))


def _assembled(deck: _Deck) -> MeshFile:
    """All grids in one, in place."""
    placed = [(Placement(), deck.grid)]
    notes = []
    used = {part for _, part, _ in deck.instances}
    for place, name, own in deck.instances:
        placed.append((place, deck.parts[name].with_more(own)))
    for row, (name, part) in enumerate(deck.parts.items(), 1):
        count = sum(len(block.ids) for block in part.blocks)
        if deck.has_assembly and name not in used and count:
            notes.append(f"part {row} with {count} elements has no instance in the assembly: left out")
        elif not deck.has_assembly:
            placed.append((Placement(), part))
    if len(deck.instances) > 1:
        notes.append(f"all {len(deck.instances)} instances are taken, where the assembly places them")
    vertices: list[np.ndarray] = []
    labels: list[np.ndarray] = []
    cells: list[Cells] = []
    count = 0
    for place, grid in placed:
        ids, position, blocks = grid.resolved(deck.source, notes)
        if count + len(ids) > LARGEST_COUNT:
            raise deck.source.error("its instances have more nodes than a tool can have")
        vertices.append(place.of(position))
        labels.append(ids)
        cells += [Cells(b.kind, f"{b.name} elements", b.nodes + count, b.ids) for b in blocks]
        count += len(ids)
    if deck.left_out:
        found = [f"{count_} {name}" for name, count_ in deck.left_out.items()]
        notes.append(f"elements that bound no surface left out: {listed(found, 10)}")
    for block in cells:
        if block.called.startswith(AXISYMMETRIC):
            if deck.plane:
                raise deck.source.error(
                    f"its {block.called} are the section of a body of revolution", "write its surface"
                )
            notes.append(f"{block.called} taken as a surface in space, as meshio writes them")
    if not cells:
        what = (
            f"only {listed([f'{n} {name}' for name, n in deck.left_out.items()])}" if deck.left_out else "no elements"
        )
        raise deck.source.error(f"it has {what}", "write the surface as shells or rigid elements, such as S4 or R3D4")
    said = tuple(dict.fromkeys(notes))
    points, numbers_ = np.concatenate(vertices), np.concatenate(labels)
    return MeshFile(deck.source.name, "Abaqus deck", points, _together(cells), said, "element", numbers_)


def _together(cells: list[Cells]) -> tuple[Cells, ...]:
    """Cells of the same type in one."""
    by_type: dict[tuple[str, str], list[Cells]] = {}
    for block in cells:
        by_type.setdefault((block.kind, block.called), []).append(block)
    return tuple(
        Cells(kind, called, np.concatenate([b.nodes for b in blocks]), np.concatenate([b.labels for b in blocks]))
        for (kind, called), blocks in by_type.items()
    )
