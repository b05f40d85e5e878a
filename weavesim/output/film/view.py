"""Where a film is seen from, and what lights it.

Lights follow UsdLux: a distant light is normalised, so that its intensity is the irradiance whatever its angle; without
that, an angle of three degrees left a five-hundredth of it, and films were nearly black in every renderer. Intensities
are about 1, as renderers with plain exposure want them (Blender, usdview); the camera states that exposure in its own
attributes, and the file asks Omniverse, whose default wants a thousand times as much, for automatic exposure.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

# Of the eye about the part [degrees].
_AZIMUTH, _ELEVATION = -60.0, 38.0
# A full-frame camera; USD counts in tenths of a stage unit, here of a metre [0.1 m].
_FOCAL_LENGTH, _APERTURE = 0.5, (0.36, 0.24)
# What the part may fill of the picture, whose half sides are 1: left and right, below, above. Below is the legend.
_PART = (0.95, 0.74, 0.94)
# Middle and half height of the legend in the same measure.
_LEGEND_PLACE, _LEGEND_HALF_HEIGHT = -0.87, 0.11
# Of the distance of the part.
_LEGEND_DEPTH = 0.5
_KEY_INTENSITY, _SKY_INTENSITY = 0.6, 0.75
_LIGHT_COLOUR = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class View:
    """A view of a part.

    Attributes:
        right, up, to_eye: unit vectors of the picture, (3,) each.
        eye: where the camera is, (3,) [m].
        distance: of the eye to the middle of the part [m].
        front: of the nearest point of the part, towards the eye [m].
    """

    right: np.ndarray
    up: np.ndarray
    to_eye: np.ndarray
    eye: np.ndarray
    distance: float
    front: float

    @classmethod
    def of(cls, lower: np.ndarray, upper: np.ndarray, side: float) -> View:
        """The nearest view that has all of a box in the picture.

        Args:
            lower, upper: corners of the box, (3,) each [m].
            side: 1 to look from above, -1 from below, with the z axis pointing down in the picture.
        """
        azimuth, elevation = np.deg2rad((_AZIMUTH, _ELEVATION))
        to_eye = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
        to_eye[2] *= side
        right = np.cross((0.0, 0.0, side), to_eye)
        right /= np.linalg.norm(right)
        axes = np.stack([right, np.cross(to_eye, right), to_eye])
        centre = 0.5 * (lower + upper)
        corner = np.array(np.meshgrid(*zip(lower, upper, strict=True))).reshape(3, -1).T - centre
        x, y, z = axes @ corner.T
        slope = np.array(_APERTURE) / (2.0 * _FOCAL_LENGTH)
        beside, below, above = _PART
        limits = ((x, slope[0] * beside, slope[0] * beside), (y, slope[1] * below, slope[1] * above))
        distance = max(_least_distance(place, z, first, last) for place, first, last in limits)
        shift = [_middle(place, z, first, last, distance) for place, first, last in limits]
        eye = centre + axes.T @ (*shift, distance)
        return cls(right, axes[1], to_eye, eye, distance, float(z.max()))

    def matrix(self, origin: np.ndarray, scale: float = 1.0) -> Any:
        """Transform of a frame whose axes are right, up and to the eye."""
        from pxr import Gf

        rows = [[*(scale * axis).tolist(), 0.0] for axis in (self.right, self.up, self.to_eye)]
        return Gf.Matrix4d(*rows[0], *rows[1], *rows[2], *np.asarray(origin, dtype=float).tolist(), 1.0)

    def legend(self) -> Any:
        """Transform of a legend whose half height is 1: below the part in the picture, and in front of it."""
        # well in front, where no tool reaches
        depth = min(self.distance - 1.02 * self.front, _LEGEND_DEPTH * self.distance)
        half = depth * _APERTURE[1] / (2.0 * _FOCAL_LENGTH)
        middle = self.eye - depth * self.to_eye + _LEGEND_PLACE * half * self.up
        return self.matrix(middle, _LEGEND_HALF_HEIGHT * half)


def _least_distance(place: np.ndarray, depth: np.ndarray, first: float, last: float) -> float:
    """Distance from which all points lie between two slopes of the picture, wherever it is centred [m]."""
    needed = place[:, None] - place + last * depth[:, None] + first * depth
    return float(needed.max()) / (first + last)


def _middle(place: np.ndarray, depth: np.ndarray, first: float, last: float, distance: float) -> float:
    """Where to centre the picture for that [m]."""
    lowest = (place - last * (distance - depth)).max()
    highest = (place + first * (distance - depth)).min()
    return 0.5 * float(lowest + highest)


def define_camera(stage: Any, view: View, name: str) -> None:
    """A camera /World/NAME, whose exposure leaves light as it is."""
    from pxr import Gf, Sdf, UsdGeom

    camera = UsdGeom.Camera.Define(stage, f"/World/{name}")
    camera.ClearXformOpOrder()
    camera.AddTransformOp().Set(view.matrix(view.eye))
    camera.CreateFocalLengthAttr(_FOCAL_LENGTH)
    camera.CreateHorizontalApertureAttr(_APERTURE[0])
    camera.CreateVerticalApertureAttr(_APERTURE[1])
    camera.CreateFocusDistanceAttr(view.distance)
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.01 * view.distance, 10.0 * view.distance))
    for exposure, value in (("iso", 100.0), ("time", 1.0), ("fStop", 1.0), ("responsivity", 1.0)):
        camera.GetPrim().CreateAttribute(f"exposure:{exposure}", Sdf.ValueTypeNames.Float, custom=False).Set(value)


def define_lights(stage: Any, view: View) -> None:
    """A white sky, and a key light from above the left shoulder of the viewer."""
    from pxr import Gf, UsdGeom, UsdLux

    UsdGeom.Scope.Define(stage, "/World/lights")
    sky = UsdLux.DomeLight.Define(stage, "/World/lights/sky")
    sky.CreateIntensityAttr(_SKY_INTENSITY)
    key = UsdLux.DistantLight.Define(stage, "/World/lights/key")
    key.CreateIntensityAttr(_KEY_INTENSITY)
    key.CreateNormalizeAttr(True)
    key.CreateAngleAttr(3.0)
    for light in (sky, key):
        light.CreateColorAttr(Gf.Vec3f(*_LIGHT_COLOUR))
    to_light = 0.7 * view.to_eye + 0.55 * view.up - 0.45 * view.right
    to_light /= np.linalg.norm(to_light)
    right = np.cross(view.up, to_light)
    right /= np.linalg.norm(right)
    rows = [[*axis.tolist(), 0.0] for axis in (right, np.cross(to_light, right), to_light)]
    key.ClearXformOpOrder()
    key.AddTransformOp().Set(Gf.Matrix4d(*rows[0], *rows[1], *rows[2], 0.0, 0.0, 0.0, 1.0))
