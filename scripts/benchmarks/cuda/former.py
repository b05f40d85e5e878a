"""Bounds of kernels that are not recorded yet: those that were held before there was a record; many are generous."""

from __future__ import annotations

from collections.abc import Sequence

from .resources import Resources

# Registers and bytes of stack, the most that any scene needs.
SCENES = {
    ("element_forces", "float32"): (130, 0),
    ("element_forces", "float64"): (255, 16),
    ("node_motion", "float32"): (128, 0),
    ("node_motion", "float64"): (203, 0),
    ("element_frequencies", "float32"): (122, 0),
    ("element_frequencies", "float64"): (255, 0),
    ("surface_contact", "float32"): (168, 0),
    ("surface_contact", "float64"): (255, 104),
    ("meet_plies", "float32"): (128, 0),
    ("meet_plies", "float64"): (238, 0),
    ("seek_feet", "float64"): (106, 0),
    ("element_pressures", "float64"): (96, 0),
}
# Of tools that no scene has.
TOOLS = {
    ("tools: mesh", "node_motion", "float32"): (190, 512),
    ("tools: mesh", "surface_contact", "float32"): (243, 512),
    ("tools: carried", "node_motion", "float32"): (153, 0),
    ("tools: carried", "surface_contact", "float32"): (213, 0),
    ("tools: carried mesh", "node_motion", "float32"): (224, 512),
    ("tools: carried mesh", "surface_contact", "float32"): (255, 576),
    ("tools: mesh", "node_motion", "float64"): (244, 512),
    ("tools: mesh", "surface_contact", "float64"): (255, 848),
    ("tools: carried", "node_motion", "float64"): (210, 0),
    ("tools: carried", "surface_contact", "float64"): (255, 232),
    ("tools: carried mesh", "node_motion", "float64"): (255, 608),
    ("tools: carried mesh", "surface_contact", "float64"): (255, 1024),
    ("tools: carried", "carried_motion", "float64"): (200, 40),
    ("tools: waiting", "tool_motion", "float64"): (128, 0),
    ("tools: samples of a mesh", "mesh_distance_kernel", "float64"): (72, 512),
    ("tools: samples of a mesh", "sampled_distance_kernel", "float64"): (125, 528),
    ("tools: samples of a mesh", "fill_tiles_kernel", "float64"): (78, 128),
    ("tools: samples of a mesh", "tell_sides_kernel", "float64"): (71, 512),
    ("tools: samples of a mesh", "doubt_cells_kernel", "float64"): (79, 512),
}
SELF_CONTACT = {
    ("seek_own_facets", "float32"): (128, 0),
    ("seek_own_facets", "float64"): (168, 0),
    ("meet_creases", "float64"): (124, 0),
    ("list_pairs", "float64"): (82, 0),
    ("meet_mirror", "float32"): (40, 48),
    ("meet_mirror", "float64"): (54, 96),
    ("watch_mirror", "float32"): (32, 40),
    ("watch_mirror", "float64"): (32, 72),
}
SMALL, SAMPLING = (80, 0), (64, 128)
# Launched between the steps of a scene, where nothing was held.
UNKNOWN = ("element_ledger", "sample_distance", "tool_push")


def former_bound(kernel: str, precision: str, users: Sequence[str]) -> Resources | None:
    """Of a kernel, by the first of those who ask for it; None for batches and cells, which nothing held."""
    user = users[0]
    if user.startswith(("batch", "cell", "tools: carried in stages")) or kernel in UNKNOWN:
        return None
    if user == "self-contact":
        registers, stack = SELF_CONTACT.get((kernel, precision), SMALL)
    elif user.startswith("tools"):
        registers, stack = TOOLS.get((user, kernel, precision), SAMPLING)
    else:
        registers, stack = SCENES.get((kernel, precision), SMALL)
    return Resources(registers, stack, 10**6)


def former_bounds() -> dict[tuple[str, str, str], str]:
    """All that is bounded by name, in words, by who asks, kernel and precision."""
    every = {("scenes", *key): bound for key, bound in SCENES.items()}
    every |= TOOLS | {("self-contact", *key): bound for key, bound in SELF_CONTACT.items()}
    return {key: f"at most {registers}{f', {stack}' if stack else ''}" for key, (registers, stack) in every.items()}
