"""Scenes: problems ready to run, one to a file. Every file of this folder that defines ``SCENE`` is one.

Names and help are read off the files, so that ``weavesim --help`` imports none of them.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from weavesim.app.options import RunOptions
    from weavesim.engine.setup import Setup
    from weavesim.output import ResultFolder
    from weavesim.output.results import Wanted
    from weavesim.run.simulation import Simulation


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A problem: parameters to set-ups, and what their results must show.

    Attributes:
        name: of its command; a literal, as ``help`` is.
        help: in a line.
        parameters: class of its options.
        make: of parameters, and a case where there are some: the set-up.
        cases: of parameters: names of the runs, each of which gets a folder of its own; None for a single run.
        wanted: of parameters and set-up: what to show besides what every run shows; None for nothing.
        findings: of parameters, finished run and ``wanted``: the scene's own entries of the summary; None for none.
    """

    name: str
    help: str
    parameters: type[RunOptions]
    make: Callable[..., Setup]
    cases: Callable[[Any], tuple[str, ...]] | None = None
    wanted: Callable[[Any, Setup], Wanted] | None = None
    findings: Callable[[Any, Simulation, Wanted], Mapping[str, Any]] | None = None

    def setups(self, parameters: RunOptions) -> dict[str, Setup]:
        """What is run, by case; the case of a single run is ``""``.

        Raises:
            InputError: parameters that contradict each other.
        """
        if self.cases is None:
            return {"": self.make(parameters)}
        return {case: self.make(parameters, case) for case in self.cases(parameters)}

    def run(self, parameters: RunOptions) -> dict[str, Any]:
        """Run all cases, one after the other, and leave their results in ``parameters.out``.

        Returns:
            The summary; of a scene with cases the summaries by case, and the outcome of the last.

        Raises:
            InputError: bad input, before anything is run.
            RunError: a run had to stop; its results up to the last good frame are written first.
        """
        from weavesim.output import ResultFolder
        from weavesim.output.results import Wanted

        setups = self.setups(parameters)
        wanted = {case: self.wanted(parameters, s) if self.wanted else Wanted() for case, s in setups.items()}
        folders = {
            case: ResultFolder(parameters.out / case, writers=parameters.writers, **vars(shown))
            for case, shown in wanted.items()
        }
        summaries: dict[str, Any] = {}
        for case, setup in setups.items():
            summaries[case] = self._run_case(parameters, case, setup, folders[case], wanted[case])
            summaries["outcome"] = summaries[case].get("outcome")
            if summaries["outcome"] != "finished":
                break
        return summaries[""] if self.cases is None else summaries

    def _run_case(
        self, parameters: RunOptions, case: str, setup: Setup, folder: ResultFolder, wanted: Wanted
    ) -> dict[str, Any]:
        from weavesim.app.run_into_folder import run_into_folder

        def measure(simulation: Simulation) -> Mapping[str, Any]:
            return self.findings(parameters, simulation, wanted) if self.findings else {}

        options = parameters.model_dump(mode="json") | ({"case": case} if case else {})
        return run_into_folder(setup, folder, options=options, measure=measure)


class SceneFile(NamedTuple):
    """A scene that is not imported yet."""

    module: str
    help: str

    def load(self) -> Scene:
        """Import it."""
        return import_module(f"{__package__}.{self.module}").SCENE


def known_scenes() -> dict[str, SceneFile]:
    """All scenes by name, in alphabetical order of their files."""
    package = import_module(__package__)
    found = {}
    for file in sorted(file for folder in package.__path__ for file in Path(folder).glob("*.py")):
        literals = _scene_literals(file.read_text(encoding="utf-8"))
        if literals:
            found[literals["name"]] = SceneFile(file.stem, literals["help"])
    return found


def _scene_literals(source: str) -> dict[str, str]:
    """``name`` and ``help`` of the scene that a module defines; {} if it defines none."""
    if "\nSCENE = Scene(" not in source:
        return {}
    for node in ast.parse(source).body:
        match node:
            case ast.Assign(targets=[ast.Name(id="SCENE")], value=ast.Call(keywords=keywords)):
                return {k.arg: ast.literal_eval(k.value) for k in keywords if k.arg in ("name", "help")}
    return {}
