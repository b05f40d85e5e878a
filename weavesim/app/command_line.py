"""The ``weavesim`` command.

A scene's options are generated from its parameter class, so name, type, default, limits and help are written once. A
scene is imported only when it is used, which keeps ``weavesim --help`` fast.

Exit codes:

- 0: finished, everything is written;
- 1: the run had to stop; results up to its last good frame are written;
- 2: bad input, nothing has been run;
- 3: finished, but the verdict is "do not use";
- 4: finished, but some results could not be written or computed;
- 5: finished, but beyond a limit (``weavesim verdict``, ``--strict``);
- 6: stopped by a guard of ``--stop-on``, results so far are written;
- 128 plus the number of the signal: interrupted, results so far are written: 130 Ctrl-C, 143 SIGTERM, 129 SIGHUP.
"""

from __future__ import annotations

import inspect
import re
import sys
import types
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Union, get_args, get_origin

import typer

from .. import __version__
from ..device import Precision
from ..errors import InputError, RunError
from ..run.interruption import leaving_at_once
from .docs_command import docs_command
from .ending import ExitCode, closing_lines, exit_code
from .fabric_command import fabric_application
from .jobs import add_commands
from .results.compare import compare_command
from .results.export import export_command
from .results.film import film_command
from .results.kinematic import kinematic_command
from .results.verdict import verdict_command
from .session import announce_compilation, announced, ends_uncollected, interruptible, uncollected
from .study_command import study_command
from .terminal import hold_standard_streams, let_go_of_standard_streams, say

if TYPE_CHECKING:
    from ..engine.setup import Setup


application = typer.Typer(
    help="Draping and forming of woven fabrics.",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # it would take what stands in brackets for styles, and leave it out
)


application.add_typer(fabric_application, name="fabric")
application.command("export")(export_command)
application.command("film")(film_command)
application.command("verdict")(verdict_command)
application.command("kinematic")(kinematic_command)
application.command("compare")(compare_command)
application.command("docs")(docs_command)
application.command("study")(study_command)
add_commands(application)


def main(*leading: str) -> None:
    """Run the command line with the ``leading`` arguments followed by those of the process; exits with a code."""
    hold_standard_streams()
    ends_uncollected()
    try:
        with leaving_at_once():
            given = [*leading, *sys.argv[1:]]
            _check_filled(given)
            application(args=given, prog_name="weavesim")
    except InputError as error:
        _fail(error, ExitCode.INPUT_ERROR)
    except RunError as error:
        _fail(error, ExitCode.RUN_ERROR)
    finally:
        let_go_of_standard_streams()


def _check_filled(arguments: Sequence[str]) -> None:
    """Raise InputError for an empty argument: as a path it would be the current folder."""
    for place, text in enumerate(arguments):
        option, equals, value = text.partition("=")
        if equals and option.startswith("--") and not value:
            raise InputError(f"{option}: it is empty; give a value (of a path, '.' is the current folder)")
        if not text.strip():
            before = arguments[place - 1] if place and arguments[place - 1].startswith("-") else "an argument"
            raise InputError(f"{before}: it is empty; give a value (of a path, '.' is the current folder)")


def _fail(error: object, code: int) -> None:
    say(f"weavesim: {error}", error=True)
    sys.exit(int(code))


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"weavesim {__version__}")
        raise typer.Exit


@application.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


@application.command()
def devices() -> None:
    """List the devices of this machine."""
    import warp as wp

    from ..device import available_threads, cpu_features, initialise

    initialise()
    for device in wp.get_devices():
        memory = f", {device.total_memory / 2**30:.0f} GiB" if device.is_cuda else f", {available_threads()} cores"
        print(f"{device.alias}: {device.name}{memory}")
    print(f"CPU features: {cpu_features() or 'not reported by this system'}")
    print(f"Compiled kernels: {wp.config.kernel_cache_dir}")


@application.command("resume")
def resume_command(
    out: Annotated[Path, typer.Argument(help="folder of the results, or one with such folders", metavar="OUT")],
    threads: Annotated[int | None, typer.Option(min=1, help="CPU threads instead of those it began with")] = None,
    device: Annotated[str | None, typer.Option(help="device instead of the one it began with")] = None,
) -> None:
    """Go on with a run that was interrupted or killed, from its last checkpoint."""
    from .resume_command import resume_folder

    _run_to_its_end(out.name, out, lambda: resume_folder(out, threads=threads, device=device))


@application.command("cache")
def cache_command(
    clear: Annotated[
        bool, typer.Option("--clear", help="remove all compiled kernels and samples of tools; runs make theirs again")
    ] = False,
) -> None:
    """Show where the compiled kernels and the samples of tools are and how much they take, or remove them."""
    from .. import kernel_cache
    from ..device import kernel_cache_base

    base = kernel_cache_base()
    every = {folder: kernel_cache.modules(folder) for folder in kernel_cache.own_folders(base)}
    found = {folder: modules for folder, modules in every.items() if modules}
    for folder, modules in found.items():
        samples = sum(module.has_samples for module in modules)
        what = f"{len(modules) - samples} compiled kernels" + (f", samples of {samples} tools" if samples else "")
        print(f"{folder}: {what}, {sum(module.size for module in modules) / 1e6:.0f} MB")
    if clear:
        kernel_cache.clear(base)
    if not found:
        print(f"{base}: no compiled kernels")
    elif clear:
        print("Removed.")


@application.command("compile")
def compile_command(
    precision: Annotated[list[Precision] | None, typer.Option(help="precision of the runs; may be repeated")] = None,
    device: Annotated[str, typer.Option(help='device of the runs: "cpu" or "cuda:0", "cuda:1", ...')] = "cpu",
    unit_cell: Annotated[str, typer.Option(help="unit cell of the fabrics, by preset name")] = "plain-weave",
    scene: Annotated[str | None, typer.Option(help="compile for this scene only [default: all]")] = None,
    processes: Annotated[int | None, typer.Option(min=1, help="parallel compiler processes [default: cores]")] = None,
) -> None:
    """Compile the kernels of all scenes with default options, so that the first run starts at once."""
    import warp as wp

    from ..engine.compilation import KernelSet, compile_kernels
    from ..fabric.presets import UNIT_CELLS

    for what, name, known in (("unit cell", unit_cell, UNIT_CELLS), ("scene", scene, SCENES)):
        if name is not None and name not in known:
            raise InputError(f"{what} {name!r} is unknown: choose one of {', '.join(known)}")
    for wanted in precision or [Precision.SINGLE]:
        setups = default_setups([scene] if scene else SCENES, precision=wanted, device=device)
        with interruptible():
            seconds = compile_kernels(KernelSet.of_setups(setups, UNIT_CELLS[unit_cell]()), processes)
        print(f"{wanted}, {device}, {unit_cell}: compiled within {seconds:.1f} s")
    print(f"Compiled kernels: {wp.config.kernel_cache_dir}")


def default_setups(scenes: Iterable[str], **options: Any) -> list[Setup]:
    """The set-ups of scenes with their defaults, except for the ``options``."""
    result: list[Setup] = []
    for name in scenes:
        scene = SCENES[name].load()
        result += scene.setups(scene.parameters(**options)).values()
    return result


def _add_scene(name: str, scene: Any) -> None:
    # The options are not known before the scene is imported: everything after its name goes to a separate command.
    @application.command(
        name,
        help=scene.help,
        add_help_option=False,
        context_settings={"allow_extra_args": True, "ignore_unknown_options": True},
    )
    def command(context: typer.Context) -> None:
        # plain help: boxed columns would truncate the option names
        scene_application = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)
        with uncollected():  # up to the run
            loaded = scene.load()
            scene_command(scene_application, name, loaded.parameters, loaded.run, scene.help)
            scene_application(args=context.args, prog_name=f"weavesim {name}")


# By name, not imported yet. Scenes are above this package in the layer order; it only discovers which ones exist.
SCENES: dict[str, Any] = import_module("weavesim.scenes.scene").known_scenes()
for _name, _scene in SCENES.items():
    _add_scene(_name, _scene)


@application.command(
    "calibrate",
    help="Fit a fabric to tests of a laboratory.",
    add_help_option=False,
    context_settings={"allow_extra_args": True, "ignore_unknown_options": True},
)
def _calibrate(context: typer.Context) -> None:
    from .calibrate_command import PANELS, CalibrateParameters, calibrate_into_folder

    parameters = CalibrateParameters
    fields = parameters.model_fields
    options = {name: _option(name, field, PANELS.get(name, "Choices")) for name, field in fields.items()}
    by_position = typer.Argument(help=fields["fabric"].description, metavar="FABRIC")
    options["fabric"] = options["fabric"].replace(annotation=Annotated[str, by_position])

    def command(**values: Any) -> None:
        given = {name: value for name, value in values.items() if value != options[name].default}
        with _typed(options, parameters), interruptible():
            checked = parameters(**{n: tuple(v) if isinstance(v, list) else v for n, v in given.items()})
            for line in calibrate_into_folder(checked):
                say(line)

    command.__signature__ = inspect.Signature(list(options.values()))  # type: ignore[attr-defined]
    command.__annotations__ = {name: option.annotation for name, option in options.items()}
    separate = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)
    separate.command(help=parameters.__doc__)(command)
    separate(args=context.args, prog_name="weavesim calibrate")


def scene_command(
    scene_application: typer.Typer, scene: str, parameters: Any, run: Callable[[Any], dict[str, Any]], text: str
) -> None:
    """Add a command whose options are the fields of ``parameters``, a subclass of ``RunOptions``.

    The command passes on the options that differ from their defaults, runs, prints where the results are, and exits
    with a code.
    """
    from .options import RunOptions

    options = {
        name: _option(name, field, "Run" if name in RunOptions.model_fields else "Scene")
        for name, field in parameters.model_fields.items()
    }

    def command(**values: Any) -> None:
        given = {name: value for name, value in values.items() if value != options[name].default}
        with _typed(options, parameters):
            checked = parameters(**given)
        with _typed(options, parameters):
            _run_to_its_end(scene, checked.out, lambda: run(checked))

    # Typer reads a command's options from its signature.
    command.__signature__ = inspect.Signature(list(options.values()))  # type: ignore[attr-defined]
    command.__annotations__ = {name: option.annotation for name, option in options.items()}
    scene_application.command(help=text)(command)


def _run_to_its_end(name: str, out: Path, run: Callable[[], dict[str, Any]]) -> None:
    """Run, say where the results are, and exit with a code."""
    with uncollected():
        from ..engine.compilation import side_by_side
        from ..tools.samples.stored import samples_stored

    announce = partial(announce_compilation, name)
    with interruptible() as interrupted, side_by_side(announce), samples_stored(), announced():
        result = run()
        number = interrupted.signal
        for line in closing_lines(result, out, number):
            say(line)
    if code := exit_code(result, number):
        raise typer.Exit(code)


@contextmanager
def _typed(options: Iterable[str], parameters: type) -> Iterator[None]:
    """Have messages about bad input name options as they are typed, also where only sentences name them."""
    from ..checks import typed_as
    from ..ranges import ACCEPTING

    flags = {name: _flag(name) for name in options}
    try:
        with typed_as(flags):
            yield
    except InputError as error:
        text = str(error).removeprefix(f"{parameters.__name__}: ")
        text = text.replace(ACCEPTING, "If this is meant, give --accept-unusual.")
        if text.startswith("fabric file"):  # its keys are names of their own
            raise InputError(text) from None
        # not within the name of a file
        names = "|".join(name for name in flags if "_" in name)
        raise InputError(
            re.sub(rf"(?<![\w./\\'\"-])(?:{names})(?![\w/\\'\"]|\.\w)", lambda match: flags[match[0]], text)
        ) from None


def _flag(name: str) -> str:
    """The option as typed."""
    return "--" + name.replace("_", "-")


def _option(name: str, field: Any, panel: str) -> inspect.Parameter:
    flag = _flag(name)
    kind = _plain_type(field.annotation)
    declaration = f"{flag}/--no-{flag[2:]}" if kind is bool else flag
    # a parser of our own: an empty name would become the current folder
    given: dict[str, Any] = {"parser": _path, "metavar": "<path>"} if Path in (kind, *get_args(kind)) else {}
    if get_origin(kind) is list and not given:
        given["metavar"] = f"<{getattr(get_args(kind)[0], '__name__', 'value')}>"
    default = inspect.Parameter.empty if field.is_required() else field.get_default(call_default_factory=True)
    if get_origin(kind) is list and isinstance(default, tuple):
        default = list(default)
    option = typer.Option(declaration, help=field.description, rich_help_panel=panel, **given)
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, option])


def _path(value: str | Path) -> Path:
    """A path as typed, which must have a name."""
    if not str(value).strip():
        raise typer.BadParameter("it is empty; a path is needed ('.' is the current folder)")
    return Path(value)


def _plain_type(annotation: Any) -> Any:
    """``annotation`` without the limits that only the parameter class checks."""
    if get_origin(annotation) is Annotated:
        return _plain_type(get_args(annotation)[0])
    if get_origin(annotation) is tuple:  # an option that may be repeated
        return list[_plain_type(get_args(annotation)[0])]  # type: ignore[misc]
    if get_origin(annotation) in (Union, types.UnionType):
        return Union[tuple(_plain_type(part) for part in get_args(annotation))]  # noqa: UP007
    return annotation


if __name__ == "__main__":
    main()
