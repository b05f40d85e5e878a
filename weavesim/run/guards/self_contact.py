"""The contact of a sheet with itself: meshes that are too coarse for it, and contacts that may have been missed."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ...kernels.rows import PassEntry
from .guard import Doubt, Guard, Level, Start

if TYPE_CHECKING:
    from ..verdict import Judged

# Element size over thickness up to which nodes on facets keep every fold apart (contact of edges is not computed).
LARGEST_SIZE = 2.0
# Of the thickness: penetration that is not doubted. Beyond the largest one the run stops: see ``find_failure``.
USUAL_DEPTH = 0.1


class SelfContactMesh(Guard):
    """Elements so large that the crests of two folds may cross between their nodes, and symmetry planes."""

    name = "self_contact_mesh"
    watches = "elements that are large for self-contact"

    def before(self, start: Start) -> Iterable[Doubt]:
        """Sheets with self-contact whose elements are larger than twice the thickness, or that are cut at a plane."""
        for sheet, info in zip(start.model.sheets, start.model.setup.sheets, strict=True):
            if info.self_contact is None:
                continue
            size, thickness = sheet.geometry.largest_size, sheet.fabric.thickness
            if size > LARGEST_SIZE * thickness:
                yield self.doubt(
                    Level.NOTE,
                    f"self-contact with elements of {1e3 * size:.3g} mm, {size / thickness:.1f} times the thickness",
                    "nodes meet facets; the crests of folds that cross each other may meet between nodes, deeper than "
                    f"they should: there, take elements of at most {1e3 * LARGEST_SIZE * thickness:.3g} mm",
                    sheet=sheet.name,
                    value=size,
                    limit=LARGEST_SIZE * thickness,
                )
            if sheet.symmetry.planes:
                yield self.doubt(
                    Level.NOTE,
                    f"self-contact beside the symmetry plane {' and '.join(sheet.symmetry.planes)} = 0",
                    "a sheet does not meet its own mirror image: a fold that closes on the plane passes through it, "
                    "which the guard beyond_symmetry tells; run the whole part if it does",
                    sheet=sheet.name,
                )


class SelfContactSearch(Guard):
    """Contacts that the search may have missed, and deep ones."""

    name = "self_contact_depth"
    watches = "how deep a sheet has been in itself, and whether its search was in time"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """The worst of the passes of each sheet."""
        model, state = run.run.model, run.run.state
        for index, sheet in enumerate(model.sheets):
            own = [k for k, each in enumerate(model.passes) if each.is_own and each.place.slave == index]
            entries = [state.passes[k].entry.numpy() for k in own]
            if any(entry[PassEntry.late] for entry in entries):
                yield self.doubt(
                    Level.WARNING,
                    "a node in self-contact slid farther between two searches than they allow for",
                    "its reaction may have been missed, which the energy balance tells: take a smaller step_safety",
                    sheet=sheet.name,
                )
            deepest = max((float(entry[PassEntry.deepest]) for entry in entries), default=0.0)
            if deepest > USUAL_DEPTH * sheet.fabric.thickness:
                yield self.doubt(
                    Level.WARNING,
                    f"the sheet has been {1e3 * deepest:.3g} mm deep in itself, "
                    f"{deepest / sheet.fabric.thickness:.0%} of the thickness",
                    "raise stiffness_share of its self_contact, up to 0.2, or move the tools more slowly",
                    sheet=sheet.name,
                    value=deepest,
                    limit=USUAL_DEPTH * sheet.fabric.thickness,
                )
