"""How fast weavesim is, on what problem, and how far from what the machine can do.

    python scripts/benchmark.py rates [--case double_dome_5mm] [--json now.json] [--compare before.json]
    python scripts/benchmark.py laws        what each law and unit cell costs, beside the default ones
    python scripts/benchmark.py bounds      memory bandwidth and multiply-adds of this machine
    python scripts/benchmark.py against ../weavesim-before     this checkout beside another one
    python scripts/benchmark.py peers       Newton's cloth solvers on the same drape (scripts/peers.py)

Contestants take short turns one after the other, so that a machine whose speed drifts treats all alike: compare rows of
one run, not runs. Rates are of the best turn, ratios are medians of paired turns.
"""

from __future__ import annotations

import datetime
import json
import platform
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np
import typer

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

app = typer.Typer(add_completion=False, help=__doc__, no_args_is_help=True, pretty_exceptions_enable=False)


# --- cases ------------------------------------------------------------------------------------------------------------


def _double_dome(mesh_size: float) -> Callable[..., Any]:
    def build(**options: Any):
        from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome

        return _ready(double_dome(DoubleDomeParameters(mesh_size=mesh_size, **options)))

    return build


def _hemisphere(**options: Any):
    from weavesim.scenes.hemisphere import HemisphereParameters, hemisphere

    return _ready(hemisphere(HemisphereParameters(**options), "low-bending"))


def _ready(made: Any) -> Any:
    """A scene's set-up as a simulation. The scenes of 0.1 return simulations: ``against`` measures those too."""
    from weavesim import Simulation

    return made if isinstance(made, Simulation) else Simulation(made)


def _patch(side: int) -> Callable[..., Any]:
    """A free square of ``side`` x ``side`` elements of 5 mm, stretched, sheared and thrown, that meets no tool."""

    def build(**options: Any):
        from weavesim import Blank, Simulation
        from weavesim.fabric import glass_polypropylene

        size = min(0.005, 19.0 / side)
        blank = Blank.rectangle((0.0, 0.0), (side * size, side * size), size)
        x, y, _ = blank.node_position.T
        wave = 20.0 * np.pi
        velocity = np.column_stack([np.sin(wave * y), np.sin(wave * x), np.sin(wave * x) * np.sin(wave * y)])
        try:
            from weavesim.engine.setup import Setup, Solver
            from weavesim.sheet.sheet import Sheet
        except ImportError:  # 0.1, for ``against``
            options |= {"blank": blank, "fabric": glass_polypropylene(), "initial_velocity": velocity}
            return Simulation(name="patch", duration=1.0, **options)
        sheet = Sheet(blank, glass_polypropylene(), initial_velocity=velocity)
        return Simulation(Setup("patch", sheets=(sheet,), duration=1.0, solver=Solver(**options)))

    return build


CASES: dict[str, Callable[..., Any]] = {
    "double_dome_10mm": _double_dome(0.01),
    "double_dome_5mm": _double_dome(0.005),
    "double_dome_2.5mm": _double_dome(0.0025),
    "double_dome_1.25mm": _double_dome(0.00125),
    "hemisphere": _hemisphere,
    "patch_1k": _patch(32),
    "patch_10k": _patch(100),
    "patch_100k": _patch(316),
    "patch_1m": _patch(1000),
}
# The longest takes 3 GB and several minutes: by name only.
DEFAULT_CASES = tuple(name for name in CASES if name != "patch_1m")


def warm_up(simulation: Any) -> None:
    """Steps before the clock starts, up to 4,000: the sheet is in motion, and that of a double dome meets its tools."""
    simulation.stepper.advance(int(np.clip(2_000_000 // simulation.setup.sheet.blank.element_count, 5, 200)))


# --- measuring one simulation -----------------------------------------------------------------------------------------


def seconds_per_step(simulation: Any, seconds: float, largest_block_count: int = 50) -> float:
    """Time of one step, without output, over about ``seconds``."""
    stepper = simulation.stepper
    first, started = stepper.step_count, time.perf_counter()
    block_count = 1
    while (elapsed := time.perf_counter() - started) < seconds:
        stepper.advance(block_count)
        _synchronise()
        block_count = min(2 * block_count, largest_block_count)
    return elapsed / (stepper.step_count - first)


def _synchronise() -> None:
    import warp as wp

    wp.synchronize()


def phases(simulation: Any, seconds: float) -> dict[str, float]:
    """Seconds of each phase of a step, and of an output frame, of a run on one thread; its state stays as it is."""
    repeats = 10
    result = {name: _repeat(phase, seconds) / repeats for name, phase in simulation.stepper.phases(repeats).items()}
    # these contain what goes before them
    result["nodes and contact"] -= result["elements"]
    result["elements"] -= result.pop("copy")
    # the best of a few, as for the others: writing to disk stalls now and then
    result["output frame"] = min(output_frame(simulation, 0.5 * seconds) for _ in range(3))
    return result


def output_frame(simulation: Any, seconds: float) -> float:
    """Mean time of an output frame as a run into a result folder makes it: ledger, film, series (not every time), log.

    At most as many as a run has, four at least, over about ``seconds``.
    """
    from weavesim.app.progress import RunLog
    from weavesim.output import ResultFolder
    from weavesim.run.frame import Outcome

    with TemporaryDirectory() as folder:
        observers = (ResultFolder(folder), RunLog(Path(folder)))
        for observer in observers:
            observer.start(simulation.info)
        for index in range(simulation.setup.frame_count + 1):
            if index == 1:  # what the first one prepares is not counted
                started = time.perf_counter()
            time_now = simulation.setup.duration * index / simulation.setup.frame_count
            frame = replace(simulation.ledger.frame(index), time=time_now)
            simulation.ledger.penetration(frame)
            for observer in observers:
                observer.frame(frame)
            if index >= 4 and time.perf_counter() - started > seconds:
                break
        elapsed = time.perf_counter() - started
        for observer in observers:
            observer.finish(Outcome.INTERRUPTED)
    return elapsed / index


def _repeat(work: Callable[[], object], seconds: float) -> float:
    """Best time of one call, over about ``seconds``, twice at least."""
    times, started = [], time.perf_counter()
    while time.perf_counter() - started < seconds or len(times) < 2:
        before = time.perf_counter()
        work()
        _synchronise()
        times.append(time.perf_counter() - before)
    return min(times)


def state_bytes(simulation: Any) -> float:
    """Allocated bytes per element of all arrays that constants and state of a run live in."""
    return sum(array.capacity for array in simulation.stepper.arrays()) / simulation.setup.sheet.blank.element_count


def moved_bytes(simulation: Any) -> float:
    """Bytes that a step reads and writes per element if every array is touched once by each kernel (performance.md)."""
    from weavesim.kernels.rows import CellReportRow, MotionRow

    model = simulation.stepper.model.sheet
    size, per_node = model.precision.numpy.itemsize, model.blank.node_count / model.blank.element_count
    flat = 4 * 4 + size * (4 + 2 + 1)
    if not model.sheet_traits.flat:
        flat += size * 8
    element_reads = flat + per_node * size * (3 * 3 + 1)
    element_own = 2 * size * (model.cell_law.unknown_count + CellReportRow.row_count())
    corners = size * (24 + 4)
    slots = model.nodes.corner_offset.shape[0]
    node_constants = 4 * slots + 4 + size * 4
    node_motion = 2 * size * (MotionRow.row_count() + len(model.node_report_rows) + 3 * model.tool_count)
    return element_reads + element_own + 2 * corners + per_node * (node_constants + node_motion)


def machine() -> dict[str, Any]:
    """What the numbers were measured on."""
    import warp as wp

    from weavesim import __version__
    from weavesim.device import available_threads, cpu_features, device_names

    model_name = platform.processor()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        model_name = next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    revision = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, cwd=ROOT)
    return {
        "date": datetime.date.today().isoformat(),
        "processor": model_name,
        "cores": available_threads(),
        "avx512": "avx512f" in cpu_features(),
        "devices": [wp.get_device(name).name for name in device_names()],
        "warp": wp.config.version,
        "python": platform.python_version(),
        "weavesim": __version__,
        "revision": revision.stdout.strip() or None,
    }


# --- rates ------------------------------------------------------------------------------------------------------------


@app.command(hidden=True)
def worker(case: str, precisions: str, threads: str, device: str, seconds: float, turns: int, avx512: bool) -> None:
    """One case in a process of its own: a line of JSON per precision and number of threads."""
    import resource

    import weavesim.device as settings

    if not avx512:
        settings.X86_COMPILER_FLAGS = "-target-feature -avx512f"
    rows = []
    for precision in precisions.split(","):
        variants = []
        for thread_count in (int(count) for count in threads.split(",")):
            started = time.perf_counter()
            simulation = CASES[case](precision=precision, threads=thread_count, device=device)
            setup = time.perf_counter() - started
            warm_up(simulation)
            variants.append((thread_count, simulation, setup, []))
        for _ in range(turns):
            for _, simulation, _, times in variants:
                times.append(seconds_per_step(simulation, seconds))
        for thread_count, simulation, setup, times in variants:
            count, step = simulation.setup.sheet.blank.element_count, min(times)
            rows.append(
                {
                    "case": case, "elements": count, "nodes": simulation.setup.sheet.blank.node_count,
                    "precision": precision,
                    "threads": thread_count, "device": device, "avx512": avx512,
                    "lanes": simulation.stepper.model.lane_count,
                    "setup_s": setup - simulation.stepper.loading_time,
                    "kernels_s": simulation.stepper.loading_time,
                    "step_us": 1e6 * step, "median_step_us": 1e6 * float(np.median(times)),
                    "rate": count / step, "moved_bytes": moved_bytes(simulation),
                    "state_bytes": state_bytes(simulation), "turn_steps_us": [1e6 * t for t in times],
                }
            )  # fmt: skip
        rows[-len(variants)]["phases_us"] = {
            name: 1e6 * value for name, value in phases(variants[0][1], 0.3 * seconds).items()
        }
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    for row in rows:
        row["peak_memory_mb"] = peak / 2**20
        print(json.dumps(row), flush=True)


@app.command()
def rates(
    case: Annotated[list[str] | None, typer.Option(help=f"one of {', '.join(CASES)}; may be repeated")] = None,
    precision: Annotated[str, typer.Option(help="float32, float64, or both with a comma")] = "float32,float64",
    threads: Annotated[str | None, typer.Option(help="numbers of CPU threads, with commas [default: 1, all]")] = None,
    device: Annotated[str, typer.Option(help='"cpu", "cuda:0", ...')] = "cpu",
    seconds: Annotated[float, typer.Option(help="length of a turn")] = 1.0,
    turns: Annotated[int, typer.Option(help="turns of every variant")] = 3,
    avx512: Annotated[bool, typer.Option(help="compile for AVX-512 where the processor has it")] = True,
    json_file: Annotated[Path | None, typer.Option("--json", help="write all numbers here")] = None,
    compare: Annotated[Path | None, typer.Option(help="an earlier file of --json to set beside")] = None,
) -> None:
    """Element-steps per second of whole steps: cell, laws, gather, contact, update; output not included."""
    from weavesim.device import available_threads

    names = case or list(DEFAULT_CASES)
    unknown = sorted(set(names) - set(CASES))
    if unknown:
        raise typer.BadParameter(f"{', '.join(unknown)}: choose from {', '.join(CASES)}", param_hint="--case")
    old = json.loads(compare.read_text()) if compare else None
    thread_list = threads or ",".join(map(str, sorted({1, available_threads()} if device == "cpu" else {1})))
    about = machine()
    rows = []
    for name in names:
        command = [sys.executable, __file__, "worker", name, precision, thread_list, device, str(seconds), str(turns)]
        command += [str(avx512)]
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
        if done.returncode:
            raise SystemExit(f"{name}: ended with {done.returncode}; its message is above")
        rows += [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
        typer.echo(f"{name}: done", err=True)
    result = {"machine": about, "rows": rows}
    if json_file is not None:
        write_json(json_file, result)
    typer.echo(report(result, old))


def write_json(path: Path, result: dict[str, Any]) -> None:
    """Write a whole file or none."""
    partial = path.with_suffix(".partial")
    partial.write_text(json.dumps(result, indent=1))
    partial.replace(path)


def report(result: dict[str, Any], old: dict[str, Any] | None = None) -> str:
    """Markdown tables of ``rates``, beside an earlier result if given."""
    about, rows = result["machine"], result["rows"]
    before = {_key(row): row["rate"] for row in old["rows"]} if old else {}
    lines = [", ".join(f"{name} {value}" for name, value in about.items()), ""]
    head = ["case", "elements", "precision", "device", "threads", "step [us]", "M element-steps/s", "GB/s moved"]
    head += ["state [bytes/element]", "kernels [s]", "set-up [s]", "peak [MB]"] + (["ratio to before"] if old else [])
    lines += ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for row in rows:
        cells = [
            row["case"], row["elements"], row["precision"], row["device"], row["threads"], f"{row['step_us']:.1f}",
            f"{row['rate'] / 1e6:.2f}", f"{row['rate'] * row['moved_bytes'] / 1e9:.1f}", f"{row['state_bytes']:.0f}",
            f"{row['kernels_s']:.1f}", f"{row['setup_s']:.2f}", f"{row['peak_memory_mb']:.0f}",
        ]  # fmt: skip
        if old:
            cells.append(f"{row['rate'] / before[_key(row)]:.2f}" if _key(row) in before else "new")
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    names = next((list(row["phases_us"]) for row in rows if "phases_us" in row), [])
    lines += ["", "Phases on one thread, microseconds per launch:", ""]
    lines += ["| case | precision | " + " | ".join(names) + " |", "|" + "---|" * (len(names) + 2)]
    for row in rows:
        if "phases_us" in row:
            values = " | ".join(f"{value:.1f}" for value in row["phases_us"].values())
            lines.append(f"| {row['case']} | {row['precision']} | {values} |")
    return "\n".join(lines)


def _key(row: dict[str, Any]) -> tuple[Any, ...]:
    return tuple(row.get(name, True) for name in ("case", "precision", "device", "threads", "avx512"))


# --- laws -------------------------------------------------------------------------------------------------------------


def law_variants() -> dict[str, Any]:
    """Fabrics that differ from the default one in one law."""
    from weavesim.fabric.bending import BendingCurve, YarnBending
    from weavesim.fabric.presets import UNIT_CELLS, glass_polypropylene
    from weavesim.fabric.shear import ShearFriction
    from weavesim.process.dynamics import Dynamics

    base = glass_polypropylene()

    def changed(dynamics: Dynamics | None = None, **update: Any) -> tuple[Any, Any]:
        return base.model_copy(update=update), dynamics

    stiff = base.bending.stiffness(base.thickness)
    curve = BendingCurve(curvature=(0.0, 10.0, 50.0), moment_values=(0.0, 8.0 * stiff, 25.0 * stiff))
    rubbing = BendingCurve.from_kawabata(rigidity=stiff, hysteresis=2e-2)
    soft = base.shear.model_copy(update={"locking_stiffness": 0.0})
    variants = {
        "default: plain weave, shear curve, isotropic bending": changed(),
        "linear shear": changed(shear=base.with_linear_shear(0.25e6).shear),
        "shear friction, tension-shear coupling": changed(
            shear_friction=ShearFriction(stiffness=60.0, limit=(0.5,), crossover_friction_length=1e-4)
        ),
        "bending per yarn family": changed(bending=YarnBending(warp=stiff, weft=stiff, twist=0.5 * stiff)),
        "bending curves": changed(bending=YarnBending(warp=curve, weft=curve, twist=0.5 * stiff)),
        "bending friction": changed(bending=YarnBending(warp=rubbing, weft=rubbing, twist=0.5 * stiff)),
        "no in-plane bending of yarns": changed(in_plane_bending_stiffness=0.0),
        "tools meet the current thickness": changed(Dynamics(contact_thickness="current")),
    }
    for name, cell in UNIT_CELLS.items():
        if name != "plain-weave":
            variants[f"unit cell: {name}"] = changed(unit_cell=cell(), shear=soft)
    return variants


@app.command()
def laws(
    turns: Annotated[int, typer.Option(help="turns of each law")] = 7,
    seconds: Annotated[float, typer.Option(help="length of a turn")] = 0.3,
    mesh_size: Annotated[float, typer.Option(help="of the double dome [m]")] = 0.01,
    precision: Annotated[str, typer.Option(help="float32 or float64")] = "float32",
) -> None:
    """Time per element and step of every law and unit cell in the double dome, on one thread."""
    from weavesim.run.simulation import Simulation
    from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome

    parameters = DoubleDomeParameters(mesh_size=mesh_size, precision=precision, threads=1)
    variants = law_variants()
    simulations = []
    for fabric, dynamics in variants.values():
        setup = double_dome(parameters, fabric)
        if dynamics is not None:
            (world,) = setup.worlds
            setup = setup.model_copy(update={"worlds": (world.model_copy(update={"dynamics": dynamics}),)})
        simulation = Simulation(setup)
        warm_up(simulation)
        simulations.append(simulation)
    times = np.array([[seconds_per_step(simulation, seconds) for simulation in simulations] for _ in range(turns)])
    count = simulations[0].blank.element_count
    typer.echo(", ".join(f"{name} {value}" for name, value in machine().items()))
    typer.echo(f"\n{count} elements, {precision}, one thread, {turns} turns of {seconds} s\n")
    typer.echo(ratio_table(list(variants), 1e9 * times / count))


def ratio_table(names: list[str], times: np.ndarray) -> str:
    """Medians, and ratios to the first of paired turns with their quartiles; times (turns, contestants) [ns]."""
    head = f"| | ns per element and step | minimum | ratio to {names[0].split(':')[0]} | quartiles |"
    lines = [head, "|---|---|---|---|---|"]
    for name, column in zip(names, times.T, strict=True):
        low, middle, high = np.quantile(column / times[:, 0], [0.25, 0.5, 0.75])
        lines.append(
            f"| {name} | {np.median(column):.0f} | {column.min():.0f} | {middle:.3f} | {low:.3f} to {high:.3f} |"
        )
    return "\n".join(lines)


# --- this checkout beside another -------------------------------------------------------------------------------------

# Steps on demand in a process of its own: reads a number of blocks, answers with nanoseconds per element and step. On
# one thread they are of the processor's time, which leaves out what other programs take.
CONTESTANT = """
import importlib.util, sys, time
import weavesim
location, case, precision, threads = sys.argv[1:]
specification = importlib.util.spec_from_file_location("benchmark", location)
benchmark = importlib.util.module_from_spec(specification)
specification.loader.exec_module(benchmark)
clock = time.process_time if threads == "1" else time.perf_counter
simulation = benchmark.CASES[case](precision=precision, threads=int(threads))
stepper, count = simulation.stepper, simulation.setup.sheet.blank.element_count
benchmark.warm_up(simulation)
print(count, flush=True)
for line in sys.stdin:
    first, started = stepper.step_count, clock()
    stepper.advance(int(line))
    print(1e9 * (clock() - started) / (stepper.step_count - first) / count, flush=True)
"""


class Contestant:
    """A case that steps in a process of its own, in one checkout."""

    def __init__(self, checkout: Path, case: str, precision: str, threads: int) -> None:
        from shared.checkouts import environment

        self._process = subprocess.Popen(
            [sys.executable, "-c", CONTESTANT, str(Path(__file__).resolve()), case, precision, str(threads)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=checkout,
            env=environment(checkout),
        )  # fmt: skip
        self.element_count = int(self._answer())

    def _answer(self) -> str:
        line = self._process.stdout.readline()
        if not line:
            raise SystemExit("a contestant broke off; its message is above")
        return line

    def turn(self, block_count: int) -> float:
        """Nanoseconds per element and step."""
        self._process.stdin.write(f"{block_count}\n")
        self._process.stdin.flush()
        return float(self._answer())

    def close(self) -> None:
        """End its process."""
        self._process.stdin.close()
        self._process.wait()


@app.command()
def against(
    checkout: Annotated[Path, typer.Argument(exists=True, file_okay=False, help="folder of another version")],
    case: Annotated[str, typer.Option(help=f"one of {', '.join(CASES)}")] = "double_dome_10mm",
    turns: Annotated[int, typer.Option(help="turns of each")] = 20,
    blocks: Annotated[int, typer.Option(help="blocks of 20 steps in a turn")] = 50,
    precision: Annotated[str, typer.Option(help="float32 or float64")] = "float32",
    threads: Annotated[int, typer.Option(help="CPU threads; processor time is measured on one, else wall time")] = 1,
) -> None:
    """A case in another checkout (git worktree add) and in this one, in alternating turns."""
    if case not in CASES:
        raise typer.BadParameter(f"{case}: choose from {', '.join(CASES)}", param_hint="--case")
    contestants = [Contestant(folder.resolve(), case, precision, threads) for folder in (checkout, ROOT)]
    times = np.array([[contestant.turn(blocks) for contestant in contestants] for _ in range(turns)])
    for contestant in contestants:
        contestant.close()
    typer.echo(
        f"{case}, {contestants[0].element_count} elements, {precision}, {threads} threads, {turns} turns of "
        f"{20 * blocks} steps"
    )
    typer.echo(ratio_table(["the other checkout", "this checkout"], times))


# --- peers ------------------------------------------------------------------------------------------------------------


@app.command()
def peers(
    contestant: Annotated[list[str] | None, typer.Option(help="one of the table's names; may be repeated")] = None,
    fabric: Annotated[list[str] | None, typer.Option(help="cloth, glass, glass-straight; may be repeated")] = None,
    quads: Annotated[int, typer.Option(min=2, help="elements along a side of weavesim's sheet")] = 50,
    seconds_simulated: Annotated[float, typer.Option(min=1e-3, help="length of the drape [s]")] = 0.3,
    limit: Annotated[float, typer.Option(min=0.0, help="seconds of stepping after which a contestant stops")] = 60.0,
    device: Annotated[str, typer.Option(help='"cpu", "cuda:0", ...')] = "cpu",
    newton_python: Annotated[
        str, typer.Option(help="interpreter of an environment with newton [default: this one]")
    ] = sys.executable,
    json_file: Annotated[Path | None, typer.Option("--json", help="write all numbers here")] = None,
) -> None:
    """Newton's cloth solvers and weavesim on the same drape: stiffness, rate and accuracy."""
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    import peers as drape

    names, fabrics = contestant or list(drape.CONTESTANTS), fabric or list(drape.FABRICS)
    for given, known, option in ((names, drape.CONTESTANTS, "contestant"), (fabrics, drape.FABRICS, "fabric")):
        if unknown := sorted(set(given) - set(known)):
            raise typer.BadParameter(f"{', '.join(unknown)}: choose from {', '.join(known)}", param_hint=f"--{option}")
    about: dict[str, Any] = {}
    if set(names) & set(drape.PEERS):
        versions = drape.newton_versions(newton_python)
        if versions is None:
            raise typer.BadParameter(
                f"{newton_python} has no Newton: install it with '{newton_python} -m pip install \"newton>=1.8\"', "
                "or give the interpreter of an environment that has it",
                param_hint="--newton-python",
            )
        about = versions
    about = machine() | about
    rows = []
    for name in fabrics:
        problem = drape.make_problem(name, quads, seconds_simulated)
        for row in drape.compete(problem, names, device, limit, newton_python):
            rows.append(row)
            typer.echo(f"{name}, {row['contestant']}: {row.get('error', 'done')}", err=True)
    if json_file is not None:
        write_json(json_file, {"machine": about, "rows": rows})
    typer.echo(", ".join(f"{name} {value}" for name, value in about.items()))
    typer.echo(f"\n{quads} x {quads} quadrilaterals, {seconds_simulated} s simulated, on {device}\n")
    typer.echo(drape.report(rows))


# --- bounds -----------------------------------------------------------------------------------------------------------


@app.command()
def bounds(
    megabytes: Annotated[int, typer.Option(help="size of the arrays that are copied")] = 256,
    turns: Annotated[int, typer.Option(help="of each measurement; the best counts")] = 5,
) -> None:
    """What the machine can do on one core: bytes copied, and multiply-adds in lanes as the kernels use them."""
    typer.echo(", ".join(f"{name} {value}" for name, value in machine().items()))
    typer.echo("\n| bound, one core | |\n|---|---|")
    for size in (64 * 2**10, 2**20, megabytes * 2**20):
        source = np.ones(size // 8)
        target = np.empty_like(source)
        repeats = max(1, 64 * 2**20 // size)
        best = min(_copy_seconds(source, target, repeats) for _ in range(turns))
        label = f"{size // 2**10} KB" if size < 2**20 else f"{size // 2**20} MB"
        typer.echo(f"| copy of {label}, read and written | {2e-9 * size * repeats / best:.1f} GB/s |")
    for precision in ("float32", "float64"):
        typer.echo(f"| multiply-adds in lanes, {precision} | {multiply_add_rate(precision, turns) / 1e9:.1f} GFlop/s |")


def _copy_seconds(source: np.ndarray, target: np.ndarray, repeats: int) -> float:
    started = time.perf_counter()
    for _ in range(repeats):
        np.copyto(target, source)
    return time.perf_counter() - started


def _timed(work: Callable[[], object]) -> float:
    started = time.perf_counter()
    work()
    return time.perf_counter() - started


def multiply_add_rate(precision: str, turns: int) -> float:
    """Operations per second (two per multiply-add) of eight independent chains of lanes on one core."""
    import warp as wp

    from weavesim.device import initialise, resolve_precision
    from weavesim.kernels.lanes import CPU_LANE_COUNT, lane_types

    initialise()
    real = resolve_precision(precision).real
    lanes = lane_types(real, CPU_LANE_COUNT).lanes
    chain_count, repeat_count, thread_count = 8, 2000, 64

    @wp.kernel(module="unique", enable_backward=False)
    def chains(values: wp.array2d(dtype=lanes)):
        i = wp.tid()
        factor = lanes(real(0.999))
        one = lanes(real(0.001))
        a0 = values[i, 0] + one
        a1 = values[i, 1] + one
        a2 = values[i, 2] + one
        a3 = values[i, 3] + one
        a4 = values[i, 4] + one
        a5 = values[i, 5] + one
        a6 = values[i, 6] + one
        a7 = values[i, 7] + one
        k = wp.int32(0)
        while k < repeat_count:
            a0 = wp.cw_mul(a0, factor) + one
            a1 = wp.cw_mul(a1, factor) + one
            a2 = wp.cw_mul(a2, factor) + one
            a3 = wp.cw_mul(a3, factor) + one
            a4 = wp.cw_mul(a4, factor) + one
            a5 = wp.cw_mul(a5, factor) + one
            a6 = wp.cw_mul(a6, factor) + one
            a7 = wp.cw_mul(a7, factor) + one
            k = k + 1
        values[i, 0] = a0 + a1 + a2 + a3 + a4 + a5 + a6 + a7

    values = wp.ones((thread_count, chain_count), dtype=lanes, device="cpu")
    wp.launch(chains, dim=thread_count, inputs=[values], device="cpu")
    best = min(_timed(lambda: wp.launch(chains, dim=thread_count, inputs=[values], device="cpu")) for _ in range(turns))
    return 2.0 * CPU_LANE_COUNT * chain_count * repeat_count * thread_count / best


if __name__ == "__main__":
    app()
