"""Fabrics from laboratory tests: fits with intervals, and what the data cannot tell."""

from .calibration import Calibration, Estimate, Residual, calibrate
from .options import CalibrationOptions

__all__ = ["Calibration", "CalibrationOptions", "Estimate", "Residual", "calibrate"]
