"""A state is complete: whatever goes on from it, here or elsewhere, gets the bits of a run that never stopped."""

import hashlib
import io
import json
import pickle
import subprocess
import sys

import numpy as np
import pytest
import warp as wp

from tests.support.continue_runs import continued, digests
from tests.support.every_kind import every_kind, pulled, two_worlds
from tests.support.paths import ROOT
from weavesim.device import resolve_thread_counts
from weavesim.engine.model import Model
from weavesim.engine.setup import Solver
from weavesim.engine.state import FILE_VERSION, State
from weavesim.engine.stepper import Stepper
from weavesim.errors import InputError

CASES = every_kind()
BLOCK_COUNT = 2


def started(setup) -> tuple[Model, State, Stepper]:
    model = Model(setup)
    state = State.initial(model)
    stepper = Stepper(model, state, thread_counts=resolve_thread_counts(setup.solver.threads))
    stepper.load()
    stepper.start()
    return model, state, stepper


def constants(model: Model) -> dict[str, str]:
    """Digests of all arrays of a model, and its structs of numbers."""
    found = {
        f"array {k}": hashlib.sha256(array.numpy().tobytes()).hexdigest() for k, array in enumerate(model.arrays())
    }
    for k, sheet in enumerate(model.sheets):
        for name in ("step_bounds", "laws", "cell"):
            found[f"{name} {k}"] = repr(getattr(sheet, name))
    return found


@pytest.fixture(scope="module")
def ends(tmp_path_factory) -> dict[str, tuple[dict, dict, dict, bool]]:
    """Of every case: digests of the run itself, of its clone, of its file in another process; model left as it was."""
    folder = tmp_path_factory.mktemp("states")
    here = {}
    for k, (name, setup) in enumerate(CASES.items()):
        model, state, stepper = started(setup)
        before = constants(model)
        stepper.advance(BLOCK_COUNT)
        clone = state.clone()
        state.save(folder / f"{k}.state", model)
        (folder / f"{k}.setup").write_bytes(pickle.dumps(setup))
        stepper.look_ahead()  # changes nothing
        stepper.advance(BLOCK_COUNT)
        finite = all(np.isfinite(array.numpy()).all() for _, array in state.arrays() if array.dtype != wp.vec3d)
        assert finite, name
        here[name] = digests(state), continued(setup, model, clone, BLOCK_COUNT), constants(model) == before
    done = subprocess.run(
        [sys.executable, "-m", "tests.support.continue_runs", str(folder), str(BLOCK_COUNT)],
        cwd=ROOT, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    there = json.loads(done.stdout.splitlines()[-1])
    return {
        name: (own, clone, there[str(k)], untouched) for k, (name, (own, clone, untouched)) in enumerate(here.items())
    }


@pytest.mark.parametrize("name", CASES)
def test_a_clone_goes_on_with_the_same_bits(ends, name):
    own, clone, _, _ = ends[name]
    assert clone == own and int(own["step_count"]) == 2 * BLOCK_COUNT * 20


@pytest.mark.parametrize("name", CASES)
def test_a_saved_state_goes_on_with_the_same_bits_in_another_process(ends, name):
    own, _, there, _ = ends[name]
    assert there == own


@pytest.mark.parametrize("name", CASES)
def test_nobody_writes_the_model(ends, name):
    assert ends[name][3]


def test_the_state_moves():
    """Otherwise the tests above would compare nothing."""
    _, state, stepper = started(two_worlds(CASES["worlds"].solver))
    before = digests(state)
    stepper.advance(2)
    after = digests(state)
    still = {name for name in before if before[name] == after[name]}
    # the first sheet alone has friction inside and tools near, the third alone supports; the weight has bounced off;
    # the works of a whole block are in their sums
    own = {
        f"sheets/{k}/{name}"
        for k in range(3)
        for name in (
            "slip",
            "holding",
            "friction",
            "gap",
            "depth",
            "thickness",
            "pressure_work",
            "grip",
            "friction_argument",
        )
    } | {name for name in before if "/sample_" in name or name.endswith("/moved")}
    unmoved = {f"sheets/{k}/{name}" for k in range(3) for name in ("node_work", "contact_force", "awake")}
    assert still <= own | {"reaction", "tool_force", "tool_pose", "tool_moment"} | unmoved  # no tool is carried
    assert not still & {
        "sheets/0/slip",
        "sheets/2/holding",
        "tool_work",
        "drive_displacement",
        "sheets/2/node_work_sum",
    }


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"precision": "float32"}, "its precision is float64, but this run has float32"),
        ({"lane_count": 16}, "its lane count is 1, but this run has 16"),
        ({"step_safety": 0.5}, "its setup is another one"),
    ],
)
def test_a_state_of_another_run_is_refused(tmp_path, change, message):
    setup = pulled(CASES["worlds"].solver)
    model = Model(setup)
    State.initial(model).save(tmp_path / "state", model)
    other = setup.model_copy(update={"solver": Solver(**(setup.solver.model_dump() | change))})
    with pytest.raises(InputError, match=message):
        State.load(tmp_path / "state", Model(other))


def test_threads_and_frames_do_not_matter_to_a_state(tmp_path):
    setup = pulled(CASES["worlds"].solver)
    model = Model(setup)
    State.initial(model).save(tmp_path / "state", model)
    other = setup.model_copy(update={"solver": setup.solver.model_copy(update={"threads": 2}), "frame_count": 7})
    assert digests(State.load(tmp_path / "state", Model(other))) == digests(State.initial(model))


@pytest.fixture(scope="module")
def saved(tmp_path_factory) -> tuple[Model, bytes]:
    """A model, and the file of its state at time zero."""
    path, model = tmp_path_factory.mktemp("saved") / "state", Model(pulled(CASES["worlds"].solver))
    State.initial(model).save(path, model)
    return model, path.read_bytes()


@pytest.mark.parametrize("damage", ["missing", "text", "cut short"])
def test_a_damaged_file_is_refused(tmp_path, saved, damage):
    model, content = saved
    path = tmp_path / "state"
    if damage != "missing":
        path.write_bytes(b"no state" if damage == "text" else content[:-200])
    with pytest.raises(InputError, match="cannot be read"):
        State.load(path, model)


def test_a_flipped_byte_is_refused_or_changes_nothing(tmp_path, saved):
    """Checksums are those of the archive; what they do not cover, such as times of its files, is not read."""
    model, content = saved
    path, whole = tmp_path / "state", digests(State.initial(model))
    rng = np.random.default_rng(0)
    refused = 0
    for place in rng.integers(len(content), size=150):
        damaged = bytearray(content)
        damaged[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(damaged)
        try:
            assert digests(State.load(path, model)) == whole
        except InputError:
            refused += 1
    assert refused > 100


def rewritten(content: bytes, **changes: np.ndarray | None) -> bytes:
    """The file with other arrays; None leaves one out."""
    with np.load(io.BytesIO(content)) as file:
        arrays = {name: file[name] for name in file.files} | changes
    result = io.BytesIO()
    np.savez(result, **{name: array for name, array in arrays.items() if array is not None})
    return result.getvalue()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"clock": None}, "clock is missing or of another shape or type"),
        ({"clock": np.zeros(2)}, "clock is missing or of another shape or type"),
        ({"clock": np.zeros(3, dtype=np.float32)}, "clock is missing or of another shape or type"),
        ({"about": np.array("[1]")}, "cannot be read"),
        ({"about": np.array("null")}, "cannot be read"),
        ({"about": np.array('{"version": 0, "step_count": 0}')}, f"its version is 0, but this run has {FILE_VERSION}"),
        ({"about": np.array(f'{{"version": {FILE_VERSION}}}')}, "cannot be read"),
    ],
)
def test_what_is_missing_or_otherwise_in_a_file_is_named(tmp_path, saved, changes, message):
    model, content = saved
    (tmp_path / "state").write_bytes(rewritten(content, **changes))
    with pytest.raises(InputError, match=message):
        State.load(tmp_path / "state", model)


def test_a_file_appears_whole_or_not_at_all(tmp_path, monkeypatch):
    model = Model(pulled(CASES["worlds"].solver))
    state = State.initial(model)
    state.save(tmp_path / "state", model)
    before = (tmp_path / "state").read_bytes()
    monkeypatch.setattr(
        np, "savez", lambda file, **content: [file.write(b"half"), (_ for _ in ()).throw(OSError(28, "full"))]
    )
    with pytest.raises(OSError, match="full"):
        state.save(tmp_path / "state", model)
    assert [path.name for path in tmp_path.iterdir()] == ["state"] and (tmp_path / "state").read_bytes() == before
