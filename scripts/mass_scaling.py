"""Find the largest mass scaling of a scene that keeps a tolerance, by runs on a coarser mesh.

The chosen step is what ``--target-step`` of the scene takes; a run notes it in its summary.
"""

from __future__ import annotations

import logging
import sys
from pathlib import Path
from typing import Annotated

import typer

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))


def main(
    scene: Annotated[str, typer.Argument(help="a scene with one run, such as double-dome")],
    option: Annotated[
        list[str] | None, typer.Option(help="an option of the scene as NAME=VALUE, such as mesh_size=0.004")
    ] = None,
    angle_tolerance: Annotated[float, typer.Option(help="of the shear angles [degrees]")] = 0.5,
    draw_in_tolerance: Annotated[float, typer.Option(help="of the border's positions [m]")] = 0.5e-3,
) -> None:
    from weavesim.errors import InputError
    from weavesim.run.scaling.mass import choose_mass_scaling
    from weavesim.scenes.scene import known_scenes

    logging.disable(logging.WARNING)
    try:
        if scene not in known_scenes():
            raise InputError(f"scene {scene!r}: one of {', '.join(known_scenes())} is needed")
        found = known_scenes()[scene].load()
        pairs = [given.partition("=") for given in option or ()]
        given = {name.strip().replace("-", "_"): _number(value) for name, _, value in pairs}
        parameters = found.parameters(**given)

        def make(mesh_size: float, target_step: float | None):
            changed = parameters.model_copy(update={"mesh_size": mesh_size, "target_step": target_step})
            setups = found.setups(changed)
            if len(setups) > 1:
                raise InputError(f"scene {scene}: it has the runs {', '.join(setups)}; choose one by an option")
            return next(iter(setups.values()))

        chosen = choose_mass_scaling(
            make, parameters.mesh_size, angle_tolerance=angle_tolerance, draw_in_tolerance=draw_in_tolerance
        )
    except InputError as error:
        raise SystemExit(str(error)) from None
    print(chosen.report())


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text.strip()


if __name__ == "__main__":
    typer.run(main)
