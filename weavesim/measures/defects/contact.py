"""The thickness at which a sheet meets tools: contact, gaps, penetration and verdict share it."""

from __future__ import annotations

import numpy as np


def half_thickness(initial: float, current: np.ndarray, follows: bool) -> np.ndarray:
    """From the middle of a sheet to the face that meets tools, of each element, (element_count,) [m].

    By default that is half the initial thickness: an element that thickens in shear does not thereby enter a tool.

    Args:
        initial: thickness of the undeformed fabric [m].
        current: of each element, (element_count,) [m].
        follows: whether contact follows the current thickness (``contact_thickness="current"``).
    """
    return 0.5 * current if follows else np.full(len(current), 0.5 * initial)
