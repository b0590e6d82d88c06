"""Evaluated meshes as arrays."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np

from .collada import Mesh, Triangles
from .texcoord import TexCoord

# Steps per unit by which normals are told apart: 21 bits for each of the three fit one number.
_NORMAL_STEPS = 1_000_000


@dataclass
class Corners:
    """What `foreach_get` reads of a mesh's triangles."""

    # (triangles, 3): vertices, corners; (triangles,): polygons, materials.
    vertices: np.ndarray
    loops: np.ndarray
    polygons: np.ndarray
    materials: np.ndarray

    @classmethod
    def read(cls, data: bpy.types.Mesh) -> Corners:
        data.calc_loop_triangles()
        triangles = data.loop_triangles
        return cls(
            column(triangles, "vertices", 3, np.int32),
            column(triangles, "loops", 3, np.int32),
            column(triangles, "polygon_index", 1, np.int32).ravel(),
            column(triangles, "material_index", 1, np.int32).ravel(),
        )


def column(items: bpy.types.bpy_prop_collection, name: str, width: int, kind: type) -> np.ndarray:
    """One property of all items, `width` numbers each."""
    values = np.empty(len(items) * width, kind)
    items.foreach_get(name, values)
    return values.reshape(-1, width)


def positions(data: bpy.types.Mesh) -> np.ndarray:
    return column(data.vertices, "co", 3, np.float32)


def slots(data: bpy.types.Mesh) -> list[int]:
    """The material slots that polygons use."""
    return np.unique(column(data.polygons, "material_index", 1, np.int32)).tolist()


def digest(data: bpy.types.Mesh) -> bytes:
    """Tells whether a mesh is as it was."""
    return hashlib.blake2b(positions(data).tobytes(), digest_size=16).digest()


def read(data: bpy.types.Mesh, texcoords: Sequence[TexCoord]) -> Mesh:
    """Triangles by material, normals as Blender shades them, all UV maps (the active one first) and `texcoords`."""
    corners = Corners.read(data)
    normals, normal_indices = _normals(data, corners)
    mesh = Mesh(positions(data), normals)
    indices = []
    for name, rows in _uv_maps(data, texcoords):
        values, inverse = _distinct_pairs(rows)
        mesh.uv_sets.append((name, values))
        indices.append(inverse[corners.loops])
    for material in np.unique(corners.materials):
        own = corners.materials == material
        flat = lambda rows: rows[own].ravel()  # noqa: E731
        group = Triangles(symbol(material), flat(corners.vertices), flat(normal_indices), [flat(rows) for rows in indices])
        mesh.groups.append(group)
    return mesh


def symbol(material: int) -> str:
    """What the triangles of a material slot are called in the file."""
    return f"slot{material}"


def _normals(data: bpy.types.Mesh, corners: Corners) -> tuple[np.ndarray, np.ndarray]:
    """Normals, and which of them the three corners of each triangle have."""
    if data.normals_domain == "POINT":
        return column(data.vertex_normals, "vector", 3, np.float32), corners.vertices
    if data.normals_domain == "FACE":
        return column(data.polygon_normals, "vector", 3, np.float32), np.repeat(corners.polygons[:, None], 3, axis=1)
    normals = column(data.corner_normals, "vector", 3, np.float32)
    steps = np.round(normals * _NORMAL_STEPS).astype(np.int64) + _NORMAL_STEPS
    keys = (steps[:, 0] << 42) | (steps[:, 1] << 21) | steps[:, 2]
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    return normals[first], inverse.astype(np.int32)[corners.loops]


def _uv_maps(data: bpy.types.Mesh, texcoords: Sequence[TexCoord]) -> list[tuple[str, np.ndarray]]:
    """Names and rows per corner."""
    layers = {layer.name: layer for layer in data.uv_layers}
    rows = {name: column(layer.uv, "vector", 2, np.float32) for name, layer in layers.items()}
    active = next((layer.name for layer in data.uv_layers if layer.active_render), None)
    maps = [(TexCoord(name).name(), rows[name]) for name in sorted(rows, key=lambda name: name != active)]
    for texcoord in texcoords:
        layer = texcoord.layer or active
        if layer in rows and not texcoord.is_plain():
            maps.append((texcoord.name(), texcoord.apply(rows[layer])))
    return maps


def _distinct_pairs(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The distinct rows, and which of them each row is."""
    keys = np.ascontiguousarray(rows, np.float32).view(np.uint64).ravel()
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    return rows[first], inverse.astype(np.int32)


def mean_chord(data: bpy.types.Mesh, scale: float) -> float:
    """Mean length of the straight ways through a closed body (Cauchy): four volumes over the surface."""
    corners = Corners.read(data)
    a, b, c = (positions(data).astype(np.float64)[corners.vertices[:, i]] * scale for i in range(3))
    across = np.cross(b - a, c - a)
    area = 0.5 * np.linalg.norm(across, axis=1).sum()
    volume = abs(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6.0
    return 4.0 * volume / area if area > 0.0 else 0.0
