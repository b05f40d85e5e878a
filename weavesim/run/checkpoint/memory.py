"""All that a run knows between two steps, as values and arrays: its state, and what it has seen of itself."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from .container import Content, DamageError

if TYPE_CHECKING:
    from ..simulation import Simulation

# A value that stands for an array, by the name of the array.
_ARRAY = "array of this name"
_STATE, _MEMORY = "state/", "memory/"


def taken_apart(memory: Any, arrays: dict[str, np.ndarray]) -> Any:
    """Nested dictionaries and lists with all arrays moved to ``arrays``."""
    if isinstance(memory, np.ndarray):
        name = f"{_MEMORY}{len(arrays)}"
        arrays[name] = memory
        return {_ARRAY: name}
    if isinstance(memory, Mapping):
        return {key: taken_apart(value, arrays) for key, value in memory.items()}
    if isinstance(memory, list | tuple):
        return [taken_apart(value, arrays) for value in memory]
    return memory


def put_together(memory: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    """What ``taken_apart`` got, with lists for tuples."""
    if isinstance(memory, Mapping):
        if set(memory) == {_ARRAY}:
            return arrays[memory[_ARRAY]]
        return {key: put_together(value, arrays) for key, value in memory.items()}
    return [put_together(value, arrays) for value in memory] if isinstance(memory, list) else memory


def memory_of(simulation: Simulation) -> Content:
    """Everything that a run needs to go on, but for its frames; waits for the device."""
    # it loads Warp, which a look into a folder of results does not need
    from ..staging.advance import stage_memory

    state = simulation.state
    arrays: dict[str, np.ndarray] = {}
    memory = {
        "watch": simulation.watch.memory(),
        "guards": simulation.prepare().guards.memory(),
        "stages": stage_memory(simulation),
        "wall_time": simulation.wall_time,
        "stepping_time": simulation.stepping_time,
    }
    values = {"step_count": state.step_count, "time": state.time, "memory": taken_apart(memory, arrays)}
    return Content(values, arrays | {_STATE + name: array for name, array in state.content().items()})


def recall(simulation: Simulation, content: Content) -> None:
    """Have a prepared run be where ``memory_of`` found it.

    Raises:
        DamageError: the content is of another run.
    """
    from ..staging.advance import recall_stage

    values, arrays = content
    state = {name.removeprefix(_STATE): array for name, array in arrays.items() if name.startswith(_STATE)}
    memory = put_together(values["memory"], arrays)
    recall_stage(simulation, memory["stages"])
    try:
        simulation.state.take(state, values["step_count"])
    except ValueError as error:
        raise DamageError(f"its {error}") from None
    simulation.watch.recall(memory["watch"])
    simulation.prepare().guards.recall(memory["guards"], values["time"])
    # a look before the next step reads what the last frame has found of the state
    simulation.ledger.frame(simulation.frame.index)
    simulation.wall_time, simulation.stepping_time = memory["wall_time"], memory["stepping_time"]
