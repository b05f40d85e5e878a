"""The rooms of the project in the order of their layers, read by the layer test and by the picture of them."""

import weavesim

# From bottom to top. "base" stands for the modules outside the folders: errors, checks, the device, ...
ORDER = (
    "kernels", "base", "tables", "meshes", "fabric", "process", "sheet", "tools", "measures", "engine", "run", "output",
    "calibration", "job", "study", "app", "scenes", "scripts",
)  # fmt: skip
# Modules at the top of weavesim/ that hand on what lies above them.
DOORS = {"weavesim", "weavesim.__main__"}


def room_of(name: str) -> str | None:
    """Room of a module, or of a name within one; "door" for what hands names on, None outside the project."""
    parts = name.split(".")
    if parts[0] != "weavesim":
        return parts[0] if parts[0] in ("scripts", "tests") else None
    if name in DOORS or parts[1] in weavesim.__all__:
        return "door"
    return parts[1] if parts[1] in ORDER else "base"
