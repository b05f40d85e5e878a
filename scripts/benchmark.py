"""How fast weavesim is, on what problem, and how far from what the machine can do.

    python scripts/benchmark.py rates [--case double_dome_5mm] [--json now.json] [--compare before.json]
    python scripts/benchmark.py laws        what each law and unit cell costs, beside the default ones
    python scripts/benchmark.py sheets      what several sheets in one run cost beside one
    python scripts/benchmark.py bounds      memory bandwidth and multiply-adds of this machine
    python scripts/benchmark.py against ../weavesim-before     this checkout beside another one
    python scripts/benchmark.py peers       Newton's cloth solvers on the same drape (scripts/peers)

Contestants take short turns one after the other, so that a machine whose speed drifts treats all alike: compare rows of
one run, not runs. Rates are of the best turn, ratios are medians of paired turns.
"""

import sys
from pathlib import Path

import typer

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from scripts.benchmarks.against import against  # noqa: E402
from scripts.benchmarks.bounds import bounds  # noqa: E402
from scripts.benchmarks.laws import laws  # noqa: E402
from scripts.benchmarks.rates import rates, worker  # noqa: E402
from scripts.benchmarks.sheets import sheets  # noqa: E402
from scripts.peers.command import peers  # noqa: E402

app = typer.Typer(add_completion=False, help=__doc__, no_args_is_help=True, pretty_exceptions_enable=False)
app.command(hidden=True)(worker)
for command in (rates, laws, sheets, against, peers, bounds):
    app.command()(command)

if __name__ == "__main__":
    app()
