"""Traits for which the kernels of a sheet are generated, from its set-up alone."""

from __future__ import annotations

import numpy as np

from ..fabric.device import law_traits
from ..fabric.fabric import Fabric
from ..kernels.shell.laws import SheetTraits
from ..kernels.stepping.node_data import NodeTraits
from ..process.dynamics import Dynamics
from ..process.friction import AmongLaws, has_law
from ..sheet.geometry import ElementGeometry
from ..sheet.sheet import Sheet
from ..tools.device import strokes_wait
from ..tools.shapes import IDENTITY, shape_kinds
from .setup import Setup, World
from .staging.derive import among_laws


def sheet_traits(fabric: Fabric, geometry: ElementGeometry, dynamics: Dynamics) -> SheetTraits:
    """Traits for the element kernels."""
    return SheetTraits(
        **law_traits(fabric),
        follows_thickness=dynamics.contact_thickness == "current",
        flat=geometry.flat,
        skewed=bool(np.abs(geometry.hourglass_offset).max() > 1.0e-9),
    )


def node_traits(sheet: Sheet, world: World) -> NodeTraits:
    """Traits for the node kernel."""
    parts = [part for tool in world.tools for part in tool.shape.parts()]
    return NodeTraits(
        follows_thickness=world.dynamics.contact_thickness == "current",
        loaded=sheet.loads is not None,
        supported=bool(sheet.supports),
        shape_kinds=shape_kinds(tool.shape for tool in world.tools),
        rotated=any(part.rotation != IDENTITY for part in parts),
        touched=sheet.self_contact is not None
        or any(sheet.name in (interface.lower, interface.upper) for interface in world.interfaces),
        sampled=bool(world.tools) and world.dynamics.contact_samples == "surface",
        carried=any(tool.motion.is_carried for tool in world.tools),
        friction_laws=any(has_law(tool.friction) or isinstance(tool.friction, AmongLaws) for tool in world.tools),
    )


def as_in_stages(setup: Setup, world: World) -> World:
    """A world with laws of friction where its stages have them."""
    lawful = among_laws(setup, world)
    if not lawful:
        return world
    tools = tuple(tool.model_copy(update={"friction": AmongLaws.of(0.0)}) for tool in world.tools)
    return world.model_copy(update={"tools": tools})


def waiting(setup: Setup) -> tuple[bool, ...]:
    """Whether strokes of a run have a largest force; both where its stages may have it either way."""
    own = strokes_wait(setup.tools)
    if not setup.stages:
        return (own,)
    later = any(move.motion.limiting_force > 0.0 for stage in setup.stages for move in stage.moves)
    return (False, True) if own or later else (False,)
