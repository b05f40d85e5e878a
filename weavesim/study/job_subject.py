"""A job as the subject of a study: values into its keys, set-ups, runs without a film, numbers."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.setup import Setup
from ..errors import InputError
from ..job.build import setup_of
from ..job.overrides import overridden
from ..job.read import JobFile, read_job
from ..job.scenes import scene_of
from ..measures.defects.judgement import Limits
from ..output.folder import ResultFolder
from ..output.results import Wanted
from ..run.frame import Outcome
from ..run.guards.guard import VERDICTS
from ..run.interruption import Interrupted, interruption
from ..run.simulation import Simulation
from .factors import Factor
from .key_units import unit_of_key
from .material_points import SheetPoints, fields_at, points_of
from .measures import STUDY_FINDINGS, flattened, study_numbers
from .plans.trials import Trial
from .schema import NoiseTable
from .subject import Case, digest, quiet
from .table import Found

if TYPE_CHECKING:
    from ..sheet.sheet import Sheet

# Waves of the unevenness: up to so many along each side of the blank.
WAVE_COUNT = 6


@dataclass(frozen=True)
class JobTask:
    """The run of a job, or the runs of a scene with cases.

    Attributes:
        setups: by case; "" without cases.
        scene: name of the scene; "" for a job without.
        parameters: of the scene.
        limits: of wrinkles and bridging.
        points: material points whose fields are wanted.
        threads: of a CPU; None for the set-up's own.
    """

    setups: tuple[tuple[str, Setup], ...]
    scene: str
    parameters: Any
    limits: Limits
    points: tuple[SheetPoints, ...] = ()
    threads: int | None = None

    def compute(self) -> Found:
        """Run it in memory, with its summary in a folder for the time being."""
        numbers: dict[str, Any] = {}
        fields: dict[str, np.ndarray] = {}
        verdicts: list[str] = []
        for case, setup in self.setups:
            prefix = f"{case}." if case else ""
            found = self._run(setup)
            verdicts.append(found.verdict)
            numbers |= {f"{prefix}{name}": value for name, value in found.numbers.items()}
            fields |= {f"{prefix}{name}": values for name, values in found.fields.items()}
        order = [VERDICTS[level] for level in sorted(VERDICTS)]
        worst = max(verdicts, key=lambda verdict: order.index(verdict) if verdict in order else len(order))
        return Found(verdict=worst, numbers=numbers, fields=fields)

    def found(self, simulation: Simulation, folder: ResultFolder, wanted: Wanted) -> Found:
        """What one run found, with ``folder`` as its observer."""
        scene, given = _loaded(self.scene), dict(simulation.summary())
        if scene is not None and scene.findings is not None:
            given |= scene.findings(self.parameters, simulation, wanted)
        summary = folder.write(given)
        fields = fields_at(simulation, self.points) if self.points else {}
        numbers = flattened({**study_numbers(simulation, self.limits), **summary})
        return Found(verdict=str(summary.get("verdict", "")), numbers=numbers, fields=fields)

    def observed(self, setup: Setup, path: str) -> tuple[ResultFolder, Wanted]:
        """An observer that writes nothing but the summary to a folder for the time being, and what it shows."""
        scene, wanted = _loaded(self.scene), Wanted()
        if scene is not None and scene.wanted is not None:
            wanted = scene.wanted(self.parameters, setup)
        return ResultFolder(path, writers=(), **vars(wanted)), wanted

    def _run(self, setup: Setup) -> Found:
        if self.threads is not None and setup.solver.threads is None and setup.solver.device == "cpu":
            solver = setup.solver.model_copy(update={"threads": self.threads})
            setup = setup.model_copy(update={"solver": solver})
        with tempfile.TemporaryDirectory(prefix="weavesim-") as path, interruption() as interrupted:
            folder, wanted = self.observed(setup, path)
            simulation = Simulation(setup)
            simulation.run([folder])
            if simulation.outcome is not Outcome.FINISHED:
                raise Interrupted(interrupted.signal) if interrupted.signal else KeyboardInterrupt
            return self.found(simulation, folder, wanted)


def _loaded(scene: str) -> Any:
    """A scene by its name; None for none. Scenes stand above this room, which only runs them."""
    if not scene:
        return None
    from ..job.scenes import known_scenes

    return known_scenes()[scene].load()


@dataclass(frozen=True)
class JobSubject:
    """A job whose keys are varied.

    Attributes:
        job: path of the job file.
        settings: of all runs, in the form of --set.
        files_from: folders outside the job's own that it may read files from.
        noise: how runs are repeated.
        limits: of wrinkles and bridging.
        points: material points whose fields are wanted.
        threads: of a CPU, for a job that does not say.
    """

    job: Path
    settings: tuple[str, ...] = ()
    files_from: tuple[Path, ...] = ()
    noise: NoiseTable = NoiseTable()
    limits: Limits = Limits()
    points: tuple[SheetPoints, ...] = ()
    threads: int | None = None

    def case(self, factors: Sequence[Factor], trial: Trial) -> Case:
        """The run of a trial.

        Raises:
            InputError: values that the job does not have or allow.
        """
        own = [text for factor, value in zip(factors, trial.values, strict=True) for text in factor.settings(value)]
        file = self.file(own)
        self._check_once(file, own)
        if trial.repeat and self.noise.by == "mesh":
            file = self.file([*own, *_other_mesh(file, self._share(trial.repeat))])
        setups, scene, parameters = self._setups(file)
        if trial.repeat and self.noise.by == "unevenness":
            setups = {case: uneven(setup, trial.repeat, self.noise.speed) for case, setup in setups.items()}
        setup_hash = digest([setup.content_hash for setup in setups.values()])
        if len(setups) == 1 and not scene:
            setup_hash = next(iter(setups.values())).content_hash
        # what a scene finds may depend on its parameters beyond the set-up
        beyond = parameters.model_dump(mode="json") if scene else {}
        for name in ("out", "overwrite", "write", "without", "threads"):
            beyond.pop(name, None)
        key = digest(setup_hash, scene, beyond, self.limits.model_dump(mode="json"))
        return Case(
            key, setup_hash, JobTask(tuple(setups.items()), scene, parameters, self.limits, self.points, self.threads)
        )

    def _check_once(self, file: JobFile, own: Sequence[str]) -> None:
        """Raise InputError for a value that is varied twice, or varied and set for all runs, however it is called."""
        taken: dict[tuple[str, ...], int] = {}
        settings = (*self.settings, *own)
        for place, setting in enumerate(settings):
            for keys in overridden(file.document.values, [setting])[1]:
                if keys in taken and place >= len(self.settings):
                    name, other = (text.partition("=")[0].strip() for text in (setting, settings[taken[keys]]))
                    is_own = taken[keys] >= len(self.settings)
                    how = "varied twice" if is_own else "varied, and set for all runs"
                    also = f", as {other} too" if other != name else ""
                    raise InputError(f"{name} is {how}{also}: one of both would be ignored; leave it out there")
                taken[keys] = place

    def unit_of(self, key: str) -> str:
        """SI unit of a key of the job; "" for none, or for a key that is refused later."""
        try:
            return unit_of_key(self.file([]), key)
        except InputError:
            return ""

    def file(self, settings: Sequence[str]) -> JobFile:
        """The job with the study's settings and some of its own."""
        return read_job(self.job, [*self.settings, *settings], self.files_from)

    def with_common_points(self, count: int) -> JobSubject:
        """The same, with the fields at about ``count`` material points on each sheet of the job as it stands.

        Raises:
            InputError: a scene with cases, whose sheets differ.
        """
        setups, _, _ = self._setups(self.file([]))
        if len(setups) > 1:
            raise InputError("--fields: a scene with several cases has no common material points; choose one case")
        return replace(self, points=points_of(next(iter(setups.values())), count))

    def with_threads(self, threads: int) -> JobSubject:
        """The same, with so many threads for each run, unless the job says how many."""
        return replace(self, threads=threads)

    def _setups(self, file: JobFile) -> tuple[dict[str, Setup], str, Any]:
        solver = file.job.solver
        for name in ("mass_scaling_angle", "mass_scaling_draw_in"):
            if getattr(solver, name) is not None:
                file.refuse(
                    ["solver", name],
                    f"{name}: every run of a study would look for a scaling of its own; find one by weavesim form, and "
                    "give its target_step",
                )
        if file.job.scene is None:
            return {"": setup_of(file)}, "", None
        scene, parameters = scene_of(file, out=Path("out"))
        return scene.setups(parameters), scene.name, parameters

    def _share(self, repeat: int) -> float:
        """Factor of the mesh size in a repeat: evenly spaced around 1, without 1 itself."""
        count = self.noise.repeats
        place = repeat if repeat <= count // 2 else repeat - count - 1
        return 1.0 + self.noise.spread * place / math.ceil(count / 2)

    def known_numbers(self, case: Case) -> tuple[set[str], bool]:
        """Prepare the first run and compute its numbers at time zero; compiles its kernels.

        Raises:
            InputError: the run would be refused.
        """
        task = case.task
        assert isinstance(task, JobTask)
        names: set[str] = set()
        for prefix, setup in task.setups:
            simulation = Simulation(setup)
            with quiet():
                simulation.prepare()
            own = {finding.key: 0.0 for finding in STUDY_FINDINGS}
            own |= flattened({**_of_one_sheet(setup), **simulation.summary()})
            names |= {f"{prefix}.{name}" if prefix else name for name in own}
        # what a stage ended with, and what a scene finds, is known at the end
        return names, not task.scene and not any(setup.stages for _, setup in task.setups)


def _of_one_sheet(setup: Setup) -> dict[str, Any]:
    """Names of the numbers of sheets, as ``output.results.run_summary`` has them."""
    from ..measures.findings import SHEET_FINDINGS
    from ..run.verdict import RUN_FINDINGS

    own = {finding.key: 0.0 for finding in SHEET_FINDINGS}
    late = {finding.key: 0.0 for finding in RUN_FINDINGS if finding.key.endswith(("_ratio", "_error", "_mm"))}
    if len(setup.sheets) == 1:
        return {**own, **late}
    return {**late, "sheets": [{"name": sheet.name, **own} for sheet in setup.sheets]}


def _other_mesh(file: JobFile, share: float) -> list[str]:
    """Settings of another mesh size for all plies.

    Raises:
        InputError: a scene whose mesh size is not in the job.
    """
    if file.job.scene is not None:
        _, parameters = scene_of(file, out=Path("out"))
        return [f"scene.mesh_size={share * parameters.mesh_size!r}"]
    if any(ply.outline is not None and not ply.outline.lower().endswith(".dxf") for ply in file.job.ply):
        raise InputError('[noise] by = "mesh": a ply has its own mesh; write by = "unevenness"')
    if len(file.job.ply) == 1:
        return [f"ply.mesh_size={share * file.job.ply[0].mesh_size!r}"]
    return [f"ply.{ply.name}.mesh_size={share * ply.mesh_size!r}" for ply in file.job.ply]


def uneven(setup: Setup, seed: int, speed: float) -> Setup:
    """The same set-up, its sheets thrown a little by a smooth random velocity along z.

    Args:
        setup: of a run.
        seed: of the velocity, from 1.
        speed: root mean square over the nodes [m/s].
    """
    worlds = tuple(
        world.model_copy(
            update={"sheets": tuple(_thrown(sheet, seed, speed, place) for place, sheet in enumerate(world.sheets))}
        )
        for world in setup.worlds
    )
    return setup.model_copy(update={"worlds": worlds})


def _thrown(sheet: Sheet, seed: int, speed: float, place: int) -> Sheet:
    """Cosines of up to ``WAVE_COUNT`` half waves along both sides of the blank: the same on every mesh."""
    flat = sheet.blank.material_coordinates
    lower, upper = flat.min(axis=0), flat.max(axis=0)
    x, y = math.pi * ((flat - lower) / (upper - lower)).T
    random = np.random.default_rng([seed, place]).normal(size=(WAVE_COUNT + 1, WAVE_COUNT + 1))
    wave = np.zeros(sheet.blank.node_count)
    for i in range(WAVE_COUNT + 1):
        for j in range(WAVE_COUNT + 1):
            if i + j:  # all of it up or down is no unevenness
                wave += random[i, j] * np.cos(i * x) * np.cos(j * y)
    velocity = (
        np.zeros((sheet.blank.node_count, 3)) if sheet.initial_velocity is None else sheet.initial_velocity.copy()
    )
    velocity[:, 2] += speed * wave / max(float(np.sqrt(np.mean(wave**2))), 1.0e-300)
    return sheet.model_copy(update={"initial_velocity": velocity})
