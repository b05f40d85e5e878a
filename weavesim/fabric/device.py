"""The laws of a fabric on a device: structs that the kernels read. Only the engine imports this module."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from ..device import Precision
from ..kernels.curve import curve_struct
from ..kernels.lane_types import lane_types
from ..kernels.shell.laws import SheetTraits, sheet_laws_struct
from .curve import CURVE_PIECE_COUNT, tabulate
from .device_form import DeviceForm, Tabulated
from .fabric import Fabric


def law_traits(fabric: Fabric) -> dict[str, Any]:
    """The fields of ``SheetTraits`` that depend on the fabric's laws."""
    modules = {name: form.module for name, form in _forms(fabric).items()}
    return {**modules, "bending_friction": fabric.has_bending_friction}


def sheet_laws(fabric: Fabric, precision: Precision, device: Any) -> Any:
    """A ``sheet_laws_struct`` with all constants of a fabric except those of the stabilisation."""
    laws = sheet_laws_struct(precision.real, SheetTraits(**law_traits(fabric)))()
    for name, form in _forms(fabric).items():
        _fill(getattr(laws, name), form, precision, device)
    vec2 = wp.types.vector(2, precision.real)
    # in a family without friction the slider always slips: any spring stiffness will do
    laws.bending_friction.stiffness = vec2(*(stiffness or 1.0 for stiffness in fabric.bending.friction_stiffness))
    laws.bending_friction.limit = vec2(*fabric.bending.friction_limit)
    laws.thickness = fabric.thickness
    laws.thickening = fabric.compaction.thickening
    laws.inverse_crossover_modulus = 1.0 / fabric.compaction.modulus(fabric.unit_cell)
    laws.slip_resolution = 4.0 * np.finfo(precision.numpy).eps
    laws.transverse_shear_stiffness = fabric.transverse_shear_stiffness
    laws.in_plane_bending_stiffness = fabric.in_plane_bending_stiffness
    laws.compressive_stiffness = fabric.compressive_stiffness
    return laws


def device_curve(table: Tabulated, precision: Precision, device: Any) -> Any:
    """The table of a function on a device."""
    spacing = table.end / CURVE_PIECE_COUNT
    coefficients, integral = tabulate(table.function, spacing, CURVE_PIECE_COUNT)
    curve = curve_struct(precision.real)()
    curve.knot_spacing = spacing
    curve.knots_per_unit = CURVE_PIECE_COUNT / table.end
    curve.coefficient = wp.array(coefficients, dtype=lane_types(precision.real, 1).vec4, device=device)
    curve.integral = wp.array(integral, dtype=precision.real, device=device)
    return curve


def _forms(fabric: Fabric) -> dict[str, DeviceForm]:
    """Each law by its field name in ``SheetTraits`` and ``sheet_laws_struct``."""
    friction = fabric.shear_friction
    return {
        "shear": fabric.shear.device_form(fabric.thickness),
        "bending": fabric.bending.device_form(fabric.thickness),
        **({"shear_friction": friction.device_form()} if friction else {}),
    }


def _fill(struct: Any, form: DeviceForm, precision: Precision, device: Any) -> None:
    for name, value in form.constants.items():
        vector = wp.types.vector(np.size(value), precision.real)
        setattr(struct, name, vector(*value) if isinstance(value, tuple) else value)
    for name, table in form.curves.items():
        setattr(struct, name, device_curve(table, precision, device))
