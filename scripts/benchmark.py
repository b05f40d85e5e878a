"""How fast weavesim is, on which problem, and how close to the limits of the machine.

    python scripts/benchmark.py rates [--case double_dome_5mm] [--json now.json] [--compare before.json]
    python scripts/benchmark.py counts      bytes that a step moves, and that a run keeps, counted from its arrays
    python scripts/benchmark.py laws        cost of each law, relative to the default one
    python scripts/benchmark.py cells       cost of each unit cell, relative to the plain weave
    python scripts/benchmark.py stiffnesses what each stiffness takes of the stable step
    python scripts/benchmark.py compiling   processor time to compile the kernels of each unit cell
    python scripts/benchmark.py start       time from the command to the first step of a run
    python scripts/benchmark.py whole       a whole run by its parts, from the command to the end of its process
    python scripts/benchmark.py sheets      cost of several sheets in one run, relative to one
    python scripts/benchmark.py batch       variants of a run side by side, compared with one after the other
    python scripts/benchmark.py plies       cost of the contact between plies
    python scripts/benchmark.py meshes      cost of tools that are meshes, relative to built-in shapes
    python scripts/benchmark.py answer      time from the command to an answer within a tolerance of the converged one
    python scripts/benchmark.py bounds      memory bandwidth and multiply-add rate of this machine
    python scripts/benchmark.py schedule    a step on up to 64 threads, predicted from its plan
    python scripts/benchmark.py instructions     machine instructions of the kernels of a step on a CPU
    python scripts/benchmark.py cuda        registers and stack of every kernel on CUDA devices, without one
    python scripts/benchmark.py predict     a step on an H100, predicted from bytes, registers and instructions
    python scripts/benchmark.py against ../weavesim-before     this checkout compared with another one
    python scripts/benchmark.py peers       Newton's cloth solvers on the same drape (scripts/peers)

Contestants run in short alternating turns, so that drift in machine speed affects all of them equally: compare rows of
one run, not different runs. Rates are those of the best turn, ratios are medians of paired turns.
"""

import sys
from pathlib import Path

import typer

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from scripts.benchmarks.against import against  # noqa: E402
from scripts.benchmarks.answer import answer  # noqa: E402
from scripts.benchmarks.batch import batch  # noqa: E402
from scripts.benchmarks.bounds import bounds  # noqa: E402
from scripts.benchmarks.compilation.instructions import instructions  # noqa: E402
from scripts.benchmarks.compilation.start import start, whole  # noqa: E402
from scripts.benchmarks.compilation.times import compiling  # noqa: E402
from scripts.benchmarks.cuda.command import cuda, predict  # noqa: E402
from scripts.benchmarks.laws import cells, laws, stiffnesses  # noqa: E402
from scripts.benchmarks.rates import counts, rates, worker  # noqa: E402
from scripts.benchmarks.schedule import schedule  # noqa: E402
from scripts.benchmarks.sheets import plies, sheets  # noqa: E402
from scripts.benchmarks.tools.meshes import meshes  # noqa: E402
from scripts.peers.command import peers  # noqa: E402

app = typer.Typer(add_completion=False, help=__doc__, no_args_is_help=True, pretty_exceptions_enable=False)
app.command(hidden=True)(worker)
for command in (
    rates,
    counts,
    answer,
    laws,
    cells,
    stiffnesses,
    compiling,
    start,
    whole,
    sheets,
    batch,
    plies,
    meshes,
    against,
    peers,
    bounds,
    instructions,
    cuda,
    predict,
    schedule,
):
    app.command()(command)

if __name__ == "__main__":
    app()
