"""Every value of an element of a formed sheet, with its unit and meaning, under the name that files give it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...measures.angles import yarn_angles, yarn_vectors
from ...measures.stresses import STRESS_FIELDS, stress_fields
from ...run.fields import FIELDS
from ...run.frame import SheetFrame, SheetInfo

DIRECTIONS = {
    "warp_direction": ("1", "unit direction of the warp: x, y, z"),
    "weft_direction": ("1", "unit direction of the weft: x, y, z"),
    "warp_angle_deg": ("degrees", "from the element's side between corners 1 and 2 to the warp, about its normal"),
    "weft_angle_deg": ("degrees", "from the element's side between corners 1 and 2 to the weft, about its normal"),
}


@dataclass(frozen=True, eq=False)
class ElementValue:
    """One value per element.

    Attributes:
        unit: of the values; "1" for pure numbers.
        description: for readers.
        values: (element_count,) or (element_count, component_count).
    """

    unit: str
    description: str
    values: np.ndarray


def element_values(info: SheetInfo, frame: SheetFrame) -> dict[str, ElementValue]:
    """By name in files: fields of the run, yarn directions, and stresses where the frame has resultants."""
    known = {field.name: field for field in FIELDS}
    out = {}
    for name, values in frame.fields.items():
        if field := known.get(name):
            out[field.file_name] = ElementValue(field.file_unit, field.description, field.in_file(values))
        else:
            out[name] = ElementValue("", "", values)
    directions = (
        *yarn_vectors(info.blank, frame.position),
        *(np.rad2deg(angle) for angle in yarn_angles(info.blank, frame.position)),
    )
    for (name, (unit, text)), values in zip(DIRECTIONS.items(), directions, strict=True):
        out[name] = ElementValue(unit, text, values)
    if frame.resultants:
        stresses = stress_fields(
            info.blank, info.fabric, frame.position, frame.director, frame.fields, frame.resultants
        )
        out |= {name: ElementValue(*STRESS_FIELDS[name], values) for name, values in stresses.items()}
    return out
