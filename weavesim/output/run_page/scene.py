"""What the viewer of the page draws: sheets with their fields, tools, frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...measures.angles import yarn_components
from ...tools.drawing import coarser
from ..colours import DISTINCT_COLOURS
from .packing import COARSE_CODE, LARGEST_CODE, packed, packed_series
from .recorder import FrameRecorder, KeptField
from .shown_fields import JUDGED_FIELDS, ShownField, in_order, shown_field

if TYPE_CHECKING:
    from ...run.frame import RunInfo, SheetInfo
    from ..history import History

# Tools are for looking at: finer ones are shown by fewer triangles.
LARGEST_TRIANGLE_COUNT = 40_000
# Of the entries of a pose, over those of the run: a rotation matrix, and a shift in millimetres.
_POSE_UNITS = np.array([1.0] * 9 + [1.0e3] * 3)


def scene_of(
    info: RunInfo, recorder: FrameRecorder, history: History, judged: Sequence[Mapping[str, np.ndarray]] = ()
) -> dict[str, Any]:
    """Everything that the viewer draws, as values for JSON.

    Args:
        info: about the run.
        recorder: of its frames.
        history: of its frames.
        judged: of each sheet, fields of the last frame by names of ``JUDGED_FIELDS``, in SI units.
    """
    places = recorder.places
    sheets = [
        _sheet(info, k, recorder, judged[k] if k < len(judged) else {})
        for k in range(len(info.sheets) if places else 0)
    ]
    return {
        "frameCount": recorder.frame_count,
        "frames": {
            "index": [int(history.index[place]) for place in places],
            "time": [float(history.time[place]) for place in places],
            "stroke": [float(history.stroke[place]) for place in places],
            "stage": recorder.stages,
        },
        "sheets": sheets,
        "tools": _tools(info, recorder) if places else [],
    }


def _sheet(info: RunInfo, place: int, recorder: FrameRecorder, judged: Mapping[str, np.ndarray]) -> dict[str, Any]:
    sheet: SheetInfo = info.sheets[place]
    blank, values = sheet.blank, recorder.fields(place)
    last = len(recorder.places) - 1
    fields = [_field(shown_field(name), values[name], last) for name in in_order(list(values))]
    fields += [
        _field(field, KeptField([last], judged[field.name][None]), last)
        for field in JUDGED_FIELDS
        if field.name in judged
    ]
    kept = recorder.elements(place)
    return {
        "name": sheet.name,
        "fabric": sheet.fabric.name,
        "thickness": 1.0e3 * sheet.fabric.thickness,
        "level": info.levels[place],
        "world": sheet.world,
        "copies": [list(factors) for factors in sheet.symmetry.mirror_factors],
        "colour": DISTINCT_COLOURS[place % len(DISTINCT_COLOURS)],
        "nodeCount": blank.node_count,
        "elementCount": blank.element_count,
        "quads": packed(blank.quads.astype(np.uint32)),
        "flat": packed((1.0e3 * blank.material_coordinates).astype(np.float32)),
        "yarns": packed(yarn_components(blank).transpose(1, 0, 2).astype(np.float32)),
        # millimetres: numbers of the page are those that readers see
        "position": packed_series(1.0e3 * recorder.positions(place)),
        "fields": fields,
        **({} if kept is None else {"kept": packed_series(kept.astype(np.float32))}),
    }


def _field(field: ShownField, kept: KeptField, last: int) -> dict[str, Any]:
    """With the frames that have it, ``at``, null if all have; and the steps of its range, if they are few."""
    code = COARSE_CODE if kept.coarse else LARGEST_CODE
    packed_values = packed_series(field.factor * kept.values, logarithmic=field.logarithmic, largest_code=code)
    at = None if len(kept.at) == last + 1 else kept.at
    return field.as_dict() | {"at": at, "steps": code if kept.coarse else None, "values": packed_values}


def _tools(info: RunInfo, recorder: FrameRecorder) -> list[dict[str, Any]]:
    rest = float(np.mean(np.concatenate([sheet.blank.node_position[:, 2] for sheet in info.sheets])))
    displacement, pose, acts = recorder.tool_displacement, recorder.tool_pose, recorder.tool_acts
    found = []
    for k, (name, tool) in enumerate(zip(info.tool_names, info.tools, strict=True)):
        vertices, faces = coarser(tool.display_triangles(), LARGEST_TRIANGLE_COUNT)
        height = vertices[:, 2]
        found.append(
            {
                "name": name.replace("_", " "),
                "axis": [float(x) for x in tool.axis],
                "colour": [float(x) for x in tool.colour],
                "above": bool(0.5 * (height.min() + height.max()) > rest),
                "sheets": [place for place, sheet in enumerate(info.sheets) if k in sheet.tools],
                "displacement": (1.0e3 * displacement[:, k]).tolist(),
                # rotation row by row, and shift in millimetres, of each frame of a run in which a tool is carried
                "pose": (pose[:, k] * _POSE_UNITS).tolist() if pose.size else [],
                **({} if all(each[k] for each in acts) else {"acts": [each[k] for each in acts]}),
                "vertices": packed((1.0e3 * vertices).astype(np.float32)),
                "faces": packed(faces.astype(np.uint32)),
            }
        )
    return found
