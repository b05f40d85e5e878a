"""All constants of a run, on one device."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp

from ..device import initialise, load_kernel, resolve_device
from ..errors import InputError
from ..kernels.plies.own_search import SLOT_COUNT
from ..process.device import build_device_drives
from ..process.friction_device import carried_rate
from ..process.interfaces import Interface
from ..process.self_contact import SelfContact
from ..sheet.sheet import Sheet
from ..tools.device import build_device_tools
from ..tools.sampling import SampledDistance, mesh_parts, sample_meshes
from .compilation import MeshKernelSet, compile_missing, mesh_kernels
from .creases.crease_model import CreaseModel
from .layout import Span, padded
from .plies.facet_tables import FacetTables
from .plies.mirror_model import MirrorModel, mirror_places
from .plies.pass_model import PassModel, PassPlace, mean_density, own_pass_places, pass_places
from .setup import Setup, World, hash_of_run
from .sheet_model import SPARE_NODE_COUNT, Numerics, Places, SheetModel
from .traits import node_traits

# Largest row sum of the contact stiffness of one interface over the mass, over k_a/rho: nodes of one ply on the facets
# of another, and the reverse. Equal meshes have 2; up to 3.4 was measured for unequal and rotated ones.
LARGEST_PLY_ROW = 4.0
# A sheet whose own stable step is longer than that of its world by more than this factor, such as rubber on a fabric,
# meets tools as stiffly as that step allows: its own would let it sink into them.
SOFT = 2.0


class Model:
    """Constants of a run on one device; nothing writes them after construction.

    Args:
        setup: of the run.
        samples: sampled distances of its triangle meshes, if there are some from another model.
        kept: elements of every sheet that are there, (element_count,) bool each, or None for all of a sheet; see
            ``Trim``.

    Attributes:
        sheets: constants of every sheet, in the order of ``setup.sheets``.
        tools: of all worlds.
        drives: of all supports.
        contacts: interfaces between sheets, then the contact of each sheet with itself.
        contact_names: of these, for outputs; self-contact has the name of its sheet.
        passes: of all contacts.
        creases: of the sheets that touch themselves.
        reaction_count: blocks of nodes of the largest world, and of elements where these meet tools too.
        reference_step: stable step with straight yarns [s], the basis of the first step.

    Raises:
        InputError: no such device, tools that cannot be sampled, or a mesh that the sheet cannot carry.
    """

    def __init__(
        self,
        setup: Setup,
        samples: Mapping[Any, SampledDistance] | None = None,
        kept: Sequence[np.ndarray | None] = (),
    ) -> None:
        initialise()
        self.setup, solver = setup, setup.solver
        self.device, self.precision = resolve_device(solver.device), solver.precision
        self.lane_count = solver.lanes(is_cpu=self.device.is_cpu)
        numerics = Numerics(self.device, self.precision, self.lane_count, solver.target_step)
        self.real, self.types = numerics.real, numerics.types
        placed = list(_placed(setup, lambda sheet, world: _reaction_count(sheet, world) // self.lane_count))
        there = kept or [None] * len(setup.sheets)
        sheets = [SheetModel(numerics, *each, own) for each, own in zip(placed, there, strict=True)]
        for index, (_, world, _) in enumerate(placed):
            beside = (sheet for sheet, each in zip(sheets, placed, strict=True) if each[1] is world)
            smallest = min(sheet.reference_step for sheet in beside)
            if sheets[index].reference_step > SOFT * smallest:
                sheets[index] = SheetModel(numerics, *placed[index], there[index], smallest)
        self.sheets = tuple(sheets)
        self.reaction_count = max(sheet.places.last_reaction for sheet in self.sheets)
        self.drives = build_device_drives(setup.supports, self.device)
        self.samples = sampled_meshes(setup, str(self.device)) if samples is None else dict(samples)
        self.reference_step = min(sheet.reference_step for sheet in self.sheets)
        self.tools = build_device_tools(
            setup.tools, self.real, str(self.device), self.samples, self.contact_stiffness(), self.carried_rates()
        )
        own = (sheet.self_contact for sheet in setup.sheets)
        self.contacts: tuple[Interface | SelfContact, ...] = (
            *setup.interfaces,
            *(contact for contact in own if contact is not None),
        )
        self.contact_names = (
            *(interface.name for interface in setup.interfaces),
            *(sheet.name for sheet in setup.sheets if sheet.self_contact is not None),
        )
        self.passes = self._passes()
        own_passes = (each for each in self.passes if each.place.slot == 0)
        self.creases = tuple(CreaseModel(each) for each in own_passes)

    def _passes(self) -> tuple[PassModel, ...]:
        """Of all interfaces, whose plies need room in the stable step, and of sheets that touch themselves."""
        if not self.contacts:
            return ()
        names = [sheet.name for sheet in self.sheets]
        own = [index for index, sheet in enumerate(self.setup.sheets) if sheet.self_contact is not None]
        faces: dict[str, list[float]] = {name: [0.0, 0.0] for name in names}
        meetings = [(each.lower, each.upper) for each in self.setup.interfaces]
        meetings += [(names[index], names[index]) for index in own]
        for contact, (below, above) in zip(self.contacts, meetings, strict=True):
            lower, upper = (self.sheets[names.index(name)] for name in (below, above))
            densities = mean_density(lower), mean_density(upper)
            stiffness = contact.stiffness_share * densities[0] * densities[1] / sum(densities)
            for name, face, density in ((below, 1, densities[0]), (above, 0, densities[1])):
                bound = LARGEST_PLY_ROW * stiffness / (density * self.reference_step**2)
                faces[name][face] = max(faces[name][face], bound)
        for sheet in self.sheets:
            if any(faces[sheet.name]):
                sheet.bound_plies(*faces[sheet.name])
        places = pass_places(self.setup.interfaces, self.sheets)
        begun = {place.slave for place in places}
        for number, index in enumerate(own, len(self.setup.interfaces)):
            places += own_pass_places(number, index, index not in begun)
            places += mirror_places(number, index, self.sheets[index], int(SLOT_COUNT))
        tables = [FacetTables(sheet) for sheet in self.sheets]
        return tuple(self._pass(place, tables) for place in places)

    def _pass(self, place: PassPlace, tables: Sequence[FacetTables]) -> PassModel:
        contact = self.contacts[place.interface]
        ratio = _damping_ratio(contact, self.sheets[place.slave])
        slave, master = tables[place.slave], tables[place.master]
        if place.plane:
            assert isinstance(contact, SelfContact)
            return MirrorModel(place, contact, slave, ratio, self.reference_step)
        return PassModel(place, contact, slave, master, ratio, self.reference_step)

    def contact_stiffness(self) -> list[float]:
        """Of every tool with all nodes of all sheets that it may touch [N/m]."""
        result = [0.0] * len(self.setup.tools)
        for sheet in self.sheets:
            for tool in range(sheet.places.tools.start, sheet.places.tools.stop):
                result[tool] += float(sheet.contact_stiffness.sum())
        return result

    def carried_rates(self) -> list[float]:
        """Rate of a viscous film that the time step carries, on every tool [Pa s/m]."""
        result = [math.inf] * len(self.setup.tools)
        for sheet in self.sheets:
            rate = carried_rate(float(sheet.areal_density.min()), self.reference_step)
            for tool in range(sheet.places.tools.start, sheet.places.tools.stop):
                result[tool] = min(result[tool], rate)
        return result

    @property
    def sheet(self) -> SheetModel:
        """Constants of the only sheet of a run.

        Raises:
            InputError: the run has several.
        """
        if len(self.sheets) != 1:
            raise InputError(f"this run has {len(self.sheets)} sheets: use one of model.sheets")
        return self.sheets[0]

    @cached_property
    def identity(self) -> dict[str, object]:
        """Properties that a saved state must share with this run to continue it."""
        return {
            "setup": hash_of_run(self.setup),
            "precision": self.precision.value,
            "lane_count": self.lane_count,
        }

    def arrays(self) -> Iterator[wp.array]:
        """Every array of constants."""
        for sheet in self.sheets:
            for struct in (sheet.elements, sheet.nodes):
                yield from arrays_in(struct)
            yield from (sheet.step_inertia, sheet.held, sheet.drive_direction)
        for values in (self.tools, self.drives):
            yield from (array for array in vars(values).values() if isinstance(array, wp.array))
        yield from self.tables()

    def tables(self) -> Iterator[wp.array]:
        """Arrays of laws and unit cells: the same for any mesh."""
        for sheet in self.sheets:
            for struct in (sheet.laws, sheet.cell):
                yield from arrays_in(struct)


def _damping_ratio(interface: Interface | SelfContact, sheet: SheetModel) -> float:
    own = interface.damping_ratio
    return sheet.dynamics.contact_damping_ratio if own is None else own


def _placed(setup: Setup, reaction_count: Callable[[Sheet, World], int]) -> Iterator[tuple[Sheet, World, Places]]:
    """Every sheet with its world and its ranges in the arrays of the run."""
    tool_count = drive_count = 0
    for world in setup.worlds:
        tools, first_reaction = Span(tool_count, tool_count + len(world.tools)), 0
        tool_count = tools.stop
        for sheet in world.sheets:
            drives = Span(drive_count, drive_count + sum(len(support.drives) for support in sheet.supports))
            last_reaction = first_reaction + reaction_count(sheet, world)
            yield sheet, world, Places(tools, drives, first_reaction, last_reaction)
            drive_count, first_reaction = drives.stop, last_reaction


def _reaction_count(sheet: Sheet, world: World) -> int:
    """Nodes of a sheet that push tools, with padding, and elements where these do so too."""
    elements = padded(sheet.blank.element_count, 1) if node_traits(sheet, world).sampled else 0
    return padded(sheet.blank.node_count, SPARE_NODE_COUNT) + elements


def sampled_meshes(setup: Setup, device: str) -> dict[Any, SampledDistance]:
    """Sampled distances of all triangle meshes among the tools, deep enough for the sheets of their world."""
    samples: dict[Any, SampledDistance] = {}
    if mesh_parts(setup.tools):
        compile_missing(MeshKernelSet(device))
        for kernel in mesh_kernels():
            load_kernel(kernel, resolve_device(device))
    thinnest = min(sheet.fabric.thickness for sheet in setup.sheets)
    for world in setup.worlds:
        thickness = max(sheet.fabric.thickness for sheet in world.sheets)
        samples |= sample_meshes(world.tools, device, thickness, thinnest)
    return samples


def arrays_in(struct: Any) -> Iterator[wp.array]:
    """Arrays of a Warp struct and of its nested structs."""
    for name in struct._cls.vars:
        value = getattr(struct, name)
        if isinstance(value, wp.array):
            yield value
        elif hasattr(value, "_cls"):
            yield from arrays_in(value)
