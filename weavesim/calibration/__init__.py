"""Fabrics from laboratory tests: fits with intervals, and what the data cannot tell."""

from .calibration import calibrate
from .options import CalibrationOptions
from .record import write_calibration
from .result import Calibration, Estimate, Residual

__all__ = ["Calibration", "CalibrationOptions", "Estimate", "Residual", "calibrate", "write_calibration"]
