"""Films of made runs, opened as a viewer does."""

import numpy as np
from pxr import Usd, UsdGeom, UsdValidation

from weavesim.output import Film
from weavesim.run.frame import Outcome

SHEETS_OF_STACK = ("/World/sheets/upper", "/World/sheets/lower")


def write_film(path, run, frame_count=None):
    info, frames = run
    film = Film(path)
    film.start(info)
    for frame in frames[:frame_count]:
        film.frame(frame)
    film.finish(Outcome.FINISHED if frame_count is None else Outcome.INTERRUPTED)
    return path


def complaints(stage):
    registry = UsdValidation.ValidationRegistry()
    context = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators())
    return [f"{error.GetName()}: {error.GetMessage()}" for error in context.Validate(stage)]


def chosen(path, **variants: str):
    """The film with these variants of /World, chosen as a viewer does: in its session, not in the file."""
    stage = Usd.Stage.Open(str(path))
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        for name, variant in variants.items():
            assert stage.GetPrimAtPath("/World").GetVariantSet(name).SetVariantSelection(variant)
    return stage


def moved(stage, path: str, time: float = 0.0) -> np.ndarray:
    """Where the origin of a prim is [m]."""
    transform = UsdGeom.Xformable(stage.GetPrimAtPath(path)).ComputeLocalToWorldTransform(time)
    return np.array(transform.ExtractTranslation())
