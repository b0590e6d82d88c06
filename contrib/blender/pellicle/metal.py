"""Complex indices of metals that are known by colour.

Blender's F82 model says what a metal reflects straight on and at about 82 degrees (Kutz, Hasan & Edmondson 2021). A film
needs the complex index n + ik underneath. Straight-on reflectance leaves one degree of freedom, which the reflectance at 82
degrees decides, at each of the three wavelengths between which the renderer interpolates indices.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

# The angle where the F82 model puts its tint.
COS_82 = 1.0 / 7.0
# A mirror of reflectance 1 would need an infinite index.
_BRIGHTEST = 0.999
_DARKEST = 1e-4
_STEPS = 400
# Reflectances that nobody can tell apart, and the extinction of gold, silver and copper in the middle of the spectrum.
_TOLERANCE = 0.003
_USUAL_K = 3.0

# Linear sRGB to reflectances at 614, 549 and 466 nm, which have that colour where spectra are linear in between: the inverse
# of the colours of three hats, by the CIE 1931 observer under equal energy, adapted (Bradford) to white.
_WAVES = ((0.851861, 0.044743, 0.103396), (-0.096873, 1.269335, -0.172462), (0.024225, 0.036849, 0.938925))


def wave_reflectances(rgb: Sequence[float]) -> list[float]:
    """What a surface of this colour reflects at the wavelengths of an RGB triple of indices."""
    return [sum(weight * value for weight, value in zip(row, rgb)) for row in _WAVES]


def reflectance(n: float, k: float, cos: float) -> float:
    """Fresnel reflectance of unpolarised light from air, mean of both polarisations."""
    sin2 = 1.0 - cos * cos
    n2, k2 = n * n, k * k
    t = n2 - k2 - sin2
    a2b2 = math.sqrt(t * t + 4.0 * n2 * k2)
    a = math.sqrt(max(0.5 * (a2b2 + t), 0.0))
    across = (a2b2 + cos * cos - 2.0 * a * cos) / (a2b2 + cos * cos + 2.0 * a * cos)
    s = a2b2 * cos * cos + sin2 * sin2
    along = across * (s - 2.0 * a * cos * sin2) / (s + 2.0 * a * cos * sin2)
    return 0.5 * (across + along)


def schlick(f0: float, cos: float) -> float:
    return f0 + (1.0 - f0) * (1.0 - cos) ** 5


def index(f0: float, f82: float) -> tuple[float, float]:
    """(n, k) that reflects `f0` straight on and comes as near to `f82` at 82 degrees as a metal can."""
    f0 = min(max(f0, _DARKEST), _BRIGHTEST)
    root = math.sqrt(f0)
    # All n that reflect f0 for some k (Gulbrandsen 2014, equation 5).
    low, high = (1.0 - f0) / (1.0 + f0), (1.0 + root) / (1.0 - root)

    def extinction(n: float) -> float:
        return math.sqrt(max((f0 * (n + 1.0) ** 2 - (n - 1.0) ** 2) / (1.0 - f0), 0.0))

    candidates = [(n, extinction(n)) for n in (low * (high / low) ** (step / _STEPS) for step in range(_STEPS + 1))]
    misses = [abs(reflectance(n, k, COS_82) - f82) for n, k in candidates]
    nearest = min(misses)
    # Bright mirrors leave a wide choice, from which a film would tell the difference: take one like a real metal.
    good = [pair for pair, miss in zip(candidates, misses) if miss <= nearest + _TOLERANCE]
    return min(good, key=lambda pair: abs(pair[1] - _USUAL_K))


def index_of_dielectric(f0: float) -> float:
    """The real index that reflects `f0` straight on."""
    root = math.sqrt(min(max(f0, 0.0), 0.99))
    return (1.0 + root) / (1.0 - root)
