"""Continue saved states in a separate process: python -m tests.support.continue_runs FOLDER BLOCK_COUNT.

FOLDER has a pickled ``Setup`` and a saved state for every run; prints a digest of each final state as JSON.
"""

import hashlib
import json
import pickle
import sys
from pathlib import Path

from weavesim.device import resolve_thread_counts
from weavesim.engine.model import Model
from weavesim.engine.setup import Setup
from weavesim.engine.state import State
from weavesim.engine.stepper import Stepper


def digests(state: State) -> dict[str, str]:
    """Of every array, by name, and the number of steps."""
    own = {name: hashlib.sha256(array.numpy().tobytes()).hexdigest() for name, array in state.arrays()}
    return own | {"step_count": str(state.step_count)}


def continued(setup: Setup, model: Model, state: State, block_count: int) -> dict[str, str]:
    """Digests after ``block_count`` more blocks."""
    stepper = Stepper(model, state, thread_counts=resolve_thread_counts(setup.solver.threads))
    stepper.load()
    stepper.advance(block_count)
    return digests(state)


def main(folder: str, block_count: str) -> None:
    result = {}
    for file in sorted(Path(folder).glob("*.setup")):
        setup = pickle.loads(file.read_bytes())
        model = Model(setup)
        result[file.stem] = continued(setup, model, State.load(file.with_suffix(".state"), model), int(block_count))
    print(json.dumps(result))


if __name__ == "__main__":
    main(*sys.argv[1:])
