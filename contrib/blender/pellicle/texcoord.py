"""Texture coordinates: which UV map, and what a Mapping node does to it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .names import legal


@dataclass(frozen=True)
class TexCoord:
    """A UV map (`None`: the active one) times an affine map, two rows of three."""

    layer: str | None = None
    affine: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0)

    def is_plain(self) -> bool:
        return self.affine == TexCoord().affine

    def name(self) -> str:
        """What maps and bindings call it; empty for the active UV map as it is."""
        if self.is_plain():
            return legal(self.layer) if self.layer else ""
        return legal((self.layer or "active") + "_by_" + "_".join(f"{number:.6g}" for number in self.affine))

    def mapped(self, location: tuple[float, float], turn_rad: float, scale: tuple[float, float]) -> TexCoord:
        """With Blender's Mapping node (type Point) behind it: scaled, turned, moved."""
        cos, sin = math.cos(turn_rad), math.sin(turn_rad)
        outer = np.array([[cos * scale[0], -sin * scale[1], location[0]], [sin * scale[0], cos * scale[1], location[1]]])
        inner = np.vstack([np.reshape(self.affine, (2, 3)), [0.0, 0.0, 1.0]])
        return TexCoord(self.layer, tuple(float(number) for number in (outer @ inner).ravel()))

    def apply(self, rows: np.ndarray) -> np.ndarray:
        affine = np.reshape(self.affine, (2, 3))
        return (rows @ affine[:, :2].T + affine[:, 2]).astype(np.float32)
