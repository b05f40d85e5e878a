"""Sources of the reference: the public names by what they are for, the scenes, and every command with its options."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from scripts.documentation.parameter_fields import default_of

# Pages of the reference: file, title, what it is about, and the rooms whose public names it has, in this order.
PAGES: tuple[tuple[str, str, str, tuple[str, ...]], ...] = (
    ("fabrics", "Fabrics", "Laws, unit cells, presets and files.", ("fabric",)),
    ("calibration", "Calibration", "Fabrics from the tests of a laboratory.", ("calibration",)),
    ("sheets", "Sheets", "Blanks, plies and symmetry.", ("sheet",)),
    ("tools", "Tools", "Rigid tools and their shapes.", ("tools",)),
    ("process", "Process", "Strokes, supports, friction, loads and interfaces.", ("process",)),
    (
        "runs",
        "Runs",
        "Set-ups, simulations, frames, states and errors.",
        ("engine", "run", "app", "checks", "device", "errors"),
    ),
    ("output", "Results", "Result folders and writers.", ("output",)),
)
# Rooms whose names are not those of ``weavesim`` itself.
ROOMS: tuple[tuple[str, str, str], ...] = (
    ("measures", "Measures", "weavesim.measures"),
    ("guards", "Guards", "weavesim.run.guards"),
    ("writers", "Writers", "weavesim.output"),
    ("tables", "Tables of tests", "weavesim.tables"),
    ("meshes", "Mesh files", "weavesim.meshes"),
)


def headed(title: str, mark: str = "=") -> str:
    """A heading in reStructuredText."""
    return f"{title}\n{mark * len(title)}\n\n"


def entry(module: str, name: str) -> str:
    """What makes autodoc document one public name."""
    thing = getattr(import_module(module), name)
    path = f"{module}.{name}"
    if isinstance(thing, type):
        return f".. autoclass:: {path}\n   :members:\n   :show-inheritance:\n\n"
    if callable(thing) and hasattr(thing, "__name__"):
        return f".. autofunction:: {path}\n\n"
    keys = ", ".join(f"``{key}``" for key in thing) if isinstance(thing, Iterable) else ""
    return f".. py:data:: {path}\n\n   {'Of: ' + keys if keys else 'A constant.'}\n\n"


def public_names() -> dict[str, list[str]]:
    """Names of ``weavesim`` by the room that they come from."""
    import weavesim

    rooms: dict[str, list[str]] = {}
    for name in weavesim.__all__:
        if name != "__version__":
            rooms.setdefault(weavesim._module_of[name].split(".")[0], []).append(name)
    return rooms


def commands(command: Any, path: str) -> Iterator[tuple[str, Any]]:
    """A command and those below it, each with all words that call it."""
    inner = getattr(command, "commands", None)
    if inner is None:
        yield path, command
        return
    for name in sorted(inner):
        yield from commands(inner[name], f"{path} {name}")


def parameter_class(path: str) -> Any:
    """Class whose fields are the options of a command; None for one that declares its own."""
    from weavesim.app.calibrate_command import CalibrateParameters
    from weavesim.app.command_line import SCENES

    name = path.removeprefix("weavesim ")
    if name == "calibrate":
        return CalibrateParameters
    return SCENES[name].load().parameters if name in SCENES else None


def field_options(parameters: Any) -> Iterator[tuple[str, str]]:
    """Options of a command that come from the fields of a class: how each is typed, and what it is."""
    for name, field in parameters.model_fields.items():
        default = "" if field.default is False else default_of(field).strip("'")
        yield f"--{name.replace('_', '-')}", (field.description or "") + (f" [default: {default}]" if default else "")


def escaped(text: str) -> str:
    """Text whose marks reStructuredText leaves alone."""
    for mark in "\\*`|_":
        text = text.replace(mark, f"\\{mark}")
    return text


def options_of(path: str, command: Any) -> list[tuple[str, str]]:
    """Arguments and options of a command: how each is typed, and what it is."""
    if (parameters := parameter_class(path)) is not None:
        return list(field_options(parameters))
    context = command.make_context(path, [], resilient_parsing=True)
    records = [one.get_help_record(context) for one in command.params if one.name != "help"]
    return [record for record in records if record is not None]


def command_page() -> str:
    """Every command with its arguments and options, as the code declares them."""
    import typer

    from weavesim.app.command_line import application

    text = headed("Commands") + "Every command of ``weavesim``, with its arguments and options.\n\n"
    for path, command in commands(typer.main.get_command(application), "weavesim"):
        text += headed(path, "-")
        text += escaped(" ".join((command.help or "").split())) + "\n\n"
        for names, about in options_of(path, command):
            text += f"``{names}``\n    {escaped(' '.join(about.split())) or 'as the command says'}\n\n"
    return text


def scene_page() -> str:
    """The scenes: their parameters, and what makes a set-up of them."""
    from weavesim.app.command_line import SCENES

    text = headed("Scenes") + "Problems ready to run: parameters in, a set-up out. A command runs each.\n\n"
    for name, scene in SCENES.items():
        parameters = scene.load().parameters
        text += headed(f"weavesim {name}", "-") + escaped(scene.help) + "\n\n"
        text += f".. autoclass:: {parameters.__module__}.{parameters.__qualname__}\n   :show-inheritance:\n\n"
    return text


def write(folder: Path) -> list[str]:
    """Write the pages of the reference, and return their names in the order of reading.

    Raises:
        LookupError: public names of a room that has no page.
    """
    folder.mkdir(parents=True, exist_ok=True)
    rooms = public_names()
    texts = {"commands": command_page(), "scenes": scene_page()}
    for file, title, about, of_rooms in PAGES:
        names = [name for room in of_rooms for name in rooms.pop(room, [])]
        texts[file] = headed(title) + about + "\n\n" + "".join(entry("weavesim", name) for name in names)
    if rooms:
        raise LookupError(f"the rooms {sorted(rooms)} have public names, but no page in {__file__}")
    top = set(public_names_of("weavesim"))
    for file, title, module in ROOMS:
        names = [name for name in import_module(module).__all__ if name not in top]
        texts[file] = headed(title) + f"``{module}``\n\n" + "".join(entry(module, name) for name in names)
    for file, text in texts.items():
        (folder / f"{file}.rst").write_text(text, encoding="utf-8")
    return list(texts)


def public_names_of(module: str) -> list[str]:
    """Names that a package offers."""
    return list(import_module(module).__all__)
