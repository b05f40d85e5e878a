"""What columns of each test are called in laboratories, and the units that they may have."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..tables import Role

ANGLE = Role("angle", ("shear angle", "frame angle", "gamma", "γ", "winkel", "scherwinkel", "angle de cisaillement"),
    ("rad",), is_required=False)  # fmt: skip
DISPLACEMENT = Role(
    "displacement",
    ("extension", "elongation", "crosshead", "crosshead displacement", "crosshead travel", "travel", "stroke",
     "standard travel", "standardweg", "weg", "traversenweg", "verschiebung", "déplacement", "deplacement"),
    ("m",), is_required=False,
)  # fmt: skip
_FORCES = (
    "load", "machine force", "crosshead force", "standard force", "normalised force", "normalized force",
    "normalised shear force", "normalized shear force", "shear force", "kraft", "standardkraft", "maschinenkraft",
    "effort", "loading", "force loading", "loading force", "belastung",
)  # fmt: skip
_UNLOADING = (
    "force unloading", "unloading force", "unload", "force unload", "return", "entlastung", "kraft entlastung",
    "normalised force unloading",
)  # fmt: skip
FRAME = (ANGLE, DISPLACEMENT, Role("force", _FORCES, ("N", "N/m")), Role("unloading", _UNLOADING, ("N", "N/m"), False))
BIAS = (
    replace(DISPLACEMENT, is_required=True), Role("force", _FORCES, ("N",)),
    Role("unloading", _UNLOADING, ("N",), False),
)  # fmt: skip


def _of_family(what: str, names: Sequence[str], units: tuple[str, ...]) -> tuple[Role, Role]:
    warp, weft = (
        Role(
            f"{yarn}_{what}",
            tuple(text for name in names for other in others for text in (f"{other} {name}", f"{name} {other}")),
            units,
        )
        for yarn, others in (("warp", ("warp", "kette", "chaîne")), ("weft", ("weft", "fill", "schuss", "trame")))
    )
    return warp, weft


STRAINS = _of_family("strain", ("strain", "elongation", "epsilon", "ε", "dehnung", "déformation"), ("1",))
FORCES = _of_family("force", ("force", "load", "tension", "kraft", "effort"), ("N/m", "N"))
_OVERHANG, _BENDING_LENGTH = ("overhang length", "überhang", "überhanglänge"), ("bending length", "biegelänge")
OVERHANGS = (
    Role("overhang", ("overhanging length", "length", *_OVERHANG), ("m",), False),
    *(replace(r, is_required=False) for r in _of_family("overhang", ("overhang", *_OVERHANG), ("m",))),
    Role("bending_length", _BENDING_LENGTH, ("m",), False),
    *(replace(r, is_required=False) for r in _of_family("bending_length", _BENDING_LENGTH, ("m",))),
    Role("angle", ("chord angle", "winkel"), ("rad",), False),
)
ROLES = {"picture_frame": FRAME, "bias_extension": BIAS, "biaxial": (*STRAINS, *FORCES), "cantilever": OVERHANGS}
ONE_OF = {
    "picture_frame": ("angle", "displacement"), "bias_extension": (), "biaxial": (),
    "cantilever": tuple(role.name for role in OVERHANGS[:-1]),
}  # fmt: skip
