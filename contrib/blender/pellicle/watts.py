"""Blender's light strengths as radiometry. Lengths are Blender units, which Blender takes for metres.

All of these are measured against Cycles by `contrib/blender/tests`, within 1 %.
"""

from __future__ import annotations

import math

Rgb = tuple[float, float, float]


def point_intensity(watts: float) -> float:
    """W/sr of a point or spot light: all its power over the sphere; a spot is not brighter for being narrow."""
    return watts / (4.0 * math.pi)


def area_radiance(watts: float, area: float) -> float:
    """W/(sr m2) of a one-sided lambertian emitter."""
    return watts / (math.pi * area)


def sphere_radiance(watts: float, radius: float) -> float:
    """W/(sr m2) of a sphere that has `point_intensity`."""
    return point_intensity(watts) / (math.pi * radius * radius)


def disc_area(width: float, height: float) -> float:
    return 0.25 * math.pi * width * height


def aperture_radius(focal_mm: float, f_number: float) -> float:
    """Metres: half of focal length over f-number."""
    return 0.5e-3 * focal_mm / f_number
