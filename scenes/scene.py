"""Scenes: problems ready to run, one per file. Every file here or one folder below that defines ``SCENE`` is a scene.

Names and help texts are read from the source, so that ``weavesim --help`` imports no scene.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from weavesim.app.options import RunOptions
    from weavesim.engine.setup import Setup
    from weavesim.output import ResultFolder
    from weavesim.output.results import Wanted
    from weavesim.run.checkpoint.job import Job
    from weavesim.run.simulation import Simulation


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A problem: how parameters become set-ups, and what their results show.

    Attributes:
        name: of its command; must be a literal, like ``help``.
        help: one line.
        parameters: class of its options.
        make: (parameters), or (parameters, case) if there are cases -> the set-up.
        cases: (parameters) -> names of the runs, each with its own folder; None for a single run.
        wanted: (parameters, set-up) -> what to show in addition to the standard results; None for nothing.
        findings: (parameters, finished run, ``wanted``) -> the scene's own summary entries; None for none.
    """

    name: str
    help: str
    parameters: type[RunOptions]
    make: Callable[..., Setup]
    cases: Callable[[Any], tuple[str, ...]] | None = None
    wanted: Callable[[Any, Setup], Wanted] | None = None
    findings: Callable[[Any, Simulation, Wanted], Mapping[str, Any]] | None = None

    def setups(self, parameters: RunOptions) -> dict[str, Setup]:
        """Set-ups by case; the case of a single run is ``""``.

        Raises:
            InputError: parameters that contradict each other.
        """
        if self.cases is None:
            return {"": self.make(parameters)}
        return {case: self.make(parameters, case) for case in self.cases(parameters)}

    def run(self, parameters: RunOptions) -> dict[str, Any]:
        """Run all cases in sequence and write their results to ``parameters.out``.

        Returns:
            The summary; for a scene with cases, the summaries by case and the outcome of the last one.

        Raises:
            InputError: bad input, before anything runs.
            RunError: a run had to stop; results up to its last good frame are written first.
        """
        from weavesim.names import file_name
        from weavesim.output import ResultFolder
        from weavesim.output.results import Wanted
        from weavesim.run.interruption import interruption

        setups = self.setups(parameters)
        wanted = {case: self.wanted(parameters, s) if self.wanted else Wanted() for case, s in setups.items()}
        folders = {
            case: ResultFolder(
                parameters.out / file_name("case", case) if case else parameters.out,
                writers=parameters.writers,
                overwrite=parameters.overwrite,
                options=parameters.model_dump(mode="json") | ({"case": case} if case else {}),
                solver_fields=parameters.solver_fields,
                **vars(shown),
            )
            for case, shown in wanted.items()
        }
        summaries: dict[str, Any] = {}
        with ExitStack() as stack:
            interrupted = stack.enter_context(interruption())
            for folder in folders.values():
                stack.callback(folder.release)
                folder.claim()
            if parameters.tolerances is not None:
                setups = {case: self.scaled(parameters, case, setup) for case, setup in setups.items()}
            jobs = {
                case: self._job(parameters, case, setup, order) for order, (case, setup) in enumerate(setups.items())
            }
            following = list(setups)
            for case, setup in setups.items():
                clear = partial(_begin, [(folders[case], jobs[case]) for case in following], parameters)
                summaries[case] = self._run_case(
                    parameters, case, setup, folders[case], wanted[case], job=jobs[case], before=clear
                )
                following = []
                summaries["outcome"] = summaries[case].get("outcome")
                if summaries["outcome"] != "finished" or interrupted.is_set():
                    break
        return summaries[""] if self.cases is None else summaries

    def scaled(self, parameters: RunOptions, case: str, setup: Setup) -> Setup:
        """A set-up with the largest mass scaling that keeps the tolerances of the parameters, found by coarser runs.

        Raises:
            InputError: the scene cannot be coarser.
            RunError: the coarse run without scaling had to stop.
        """
        from weavesim.errors import InputError
        from weavesim.run.scaling.mass import choose_mass_scaling, with_mass_scaling

        def make(mesh_size: float, target_step: float | None) -> Setup:
            own = {"mass_scaling_angle": None, "mass_scaling_draw_in": None, "strict": False, "limits": None}
            changed = {"mesh_size": mesh_size, "target_step": target_step, **own}
            try:
                coarse = parameters.model_copy(update=changed)
                return self.make(coarse) if self.cases is None else self.make(coarse, case)
            except InputError as error:
                raise InputError(
                    f"a mass scaling is sought on elements of {1e3 * mesh_size:.4g} mm, which is refused: {error}"
                ) from None

        assert parameters.tolerances is not None
        return with_mass_scaling(setup, choose_mass_scaling(make, parameters.mesh_size, **parameters.tolerances))

    def _job(self, parameters: RunOptions, case: str, setup: Setup, order: int) -> Job:
        from weavesim.run.checkpoint.job import Job
        from weavesim.run.frame import new_run_id

        return Job(
            setup, new_run_id(), parameters.model_dump(mode="json"), {"scene": self.name, "case": case},
            parameters.writers, order, parameters.solver_fields, parameters.stops,
        )  # fmt: skip

    def resume(self, job: Job, options: Mapping[str, Any], out: Path) -> dict[str, Any]:
        """Go on with one run of this scene, from its last checkpoint to its end.

        Args:
            job: of the run.
            options: of the scene, by name; the files that they name are there.
            out: folder of the results of the run.

        Returns:
            The summary.

        Raises:
            InputError: the run cannot be resumed.
            RunError: it had to stop; results up to its last good frame are written first.
        """
        from weavesim.output import ResultFolder
        from weavesim.output.results import Wanted

        parameters = self.parameters(**{**options, "out": out, "write": None, "without": None, "solver_fields": False})
        case = job.origin["case"]
        wanted = self.wanted(parameters, job.setup) if self.wanted else Wanted()
        given = dict(job.options) | ({"case": case} if case else {})
        how: dict[str, Any] = {"writers": job.writers, "solver_fields": job.solver_fields, **vars(wanted)}
        folder = ResultFolder(out, options=given, resumes=True, **how)
        return self._run_case(parameters, case, job.setup, folder, wanted, job=job, resumes=True)

    def _run_case(
        self, parameters: RunOptions, case: str, setup: Setup, folder: ResultFolder, wanted: Wanted, **how: Any
    ) -> dict[str, Any]:
        from weavesim.app.run_into_folder import run_into_folder
        from weavesim.output.run_page.values import rows_of

        def measure(simulation: Simulation) -> Mapping[str, Any]:
            return self.findings(parameters, simulation, wanted) if self.findings else {}

        options = dict(how["job"].options) | ({"case": case} if case else {})
        shown = {row.label: row.text for row in rows_of(parameters)} | ({"case": case} if case else {})
        interval = parameters.checkpoint_interval
        return run_into_folder(
            setup, folder, options=options, measure=measure, checkpoint_interval=interval, shown=shown,
            reads_frames=bool(wanted.all_curves), **how
        )  # fmt: skip


def _begin(cases: list[tuple[ResultFolder, Job]], parameters: RunOptions) -> None:
    """Before the first case: remove old results of all, which must not stand beside new ones, and keep their jobs, so
    that a command that is killed in one case is resumed with the others.
    """
    from weavesim.run.checkpoint.checkpoints import Checkpoints

    for folder, _ in cases:
        folder.clear()
    for folder, job in cases if parameters.checkpoint_interval else ():
        Checkpoints(folder.path).begin(job)


class SceneFile(NamedTuple):
    """A scene that has not been imported yet; ``module`` is its name within this package."""

    module: str
    help: str

    def load(self) -> Scene:
        """Import it."""
        return import_module(f"{__package__}.{self.module}").SCENE


def known_scenes() -> dict[str, SceneFile]:
    """All scenes by name, in alphabetical order of their files."""
    package = import_module(__package__)
    files: dict[str, Path] = {}
    for folder in map(Path, package.__path__):
        files |= {file.stem: file for file in folder.glob("*.py")}
        files |= {f"{file.parent.name}.{file.stem}": file for file in folder.glob("*/*.py")}
    found = {}
    for module, file in sorted(files.items(), key=lambda item: item[1].stem):
        literals = _scene_literals(file.read_text(encoding="utf-8"))
        if literals:
            found[literals["name"]] = SceneFile(module, literals["help"])
    return found


def _scene_literals(source: str) -> dict[str, str]:
    """``name`` and ``help`` of the scene defined in a module; {} if it defines none."""
    # what stands before it takes ten times as long to parse
    _, begin, rest = source.partition("\nSCENE = Scene(")
    try:
        tree = ast.parse(begin + rest)
    except SyntaxError:  # the line stands in a text before
        tree = ast.parse(source)
    for node in tree.body:
        match node:
            case ast.Assign(targets=[ast.Name(id="SCENE")], value=ast.Call(keywords=keywords)):
                return {k.arg: ast.literal_eval(k.value) for k in keywords if k.arg in ("name", "help")}
    return {}
