"""The elements of a scene file, from plain values. Nothing here knows Blender."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from .numerals import reals, wholes

PROFILE = "pellicle"
_NAMESPACE = "http://www.collada.org/2005/11/COLLADASchema"
# The order that the standard asks for.
_LIBRARIES = ("cameras", "lights", "effects", "materials", "geometries", "animations", "visual_scenes")
VISUAL_SCENE = "scene"


@dataclass
class Triangles:
    """The triangles of one material: three indices each into positions, normals and every set of texture coordinates."""

    symbol: str
    positions: np.ndarray
    normals: np.ndarray
    uvs: list[np.ndarray]


@dataclass
class Mesh:
    positions: np.ndarray
    normals: np.ndarray
    # Names and (u, v) rows; the first is what a map without `texcoord` means.
    uv_sets: list[tuple[str, np.ndarray]] = field(default_factory=list)
    groups: list[Triangles] = field(default_factory=list)


def technique(owner: Element, content: Iterable[Element], profile: str = PROFILE) -> None:
    """Puts what COLLADA has no words for into the owner's `<extra>`."""
    extra = SubElement(SubElement(owner, "extra"), "technique", profile=profile)
    extra.extend(content)


def text(parent: Element, tag: str, content: str, **attributes: str) -> Element:
    element = SubElement(parent, tag, attributes)
    element.text = content
    return element


def effect(identity: str, base: Element, colour: Sequence[float]) -> Element:
    """`base` in our profile, and a plain colour for readers that do not know it."""
    element = Element("effect", id=identity)
    common = SubElement(SubElement(element, "profile_COMMON"), "technique", sid="common")
    diffuse = SubElement(SubElement(common, "lambert"), "diffuse")
    text(diffuse, "color", reals([*colour, 1.0], 6))
    technique(element, [base])
    return element


def material(identity: str, name: str, effect_id: str) -> Element:
    element = Element("material", id=identity, name=name)
    SubElement(element, "instance_effect", url=f"#{effect_id}")
    return element


def geometry(identity: str, name: str, mesh: Mesh) -> Element:
    element = Element("geometry", id=identity, name=name)
    body = SubElement(element, "mesh")
    body.append(source(f"{identity}-positions", mesh.positions, "XYZ", 9))
    body.append(source(f"{identity}-normals", mesh.normals, "XYZ", 7))
    for number, (_, values) in enumerate(mesh.uv_sets):
        body.append(source(f"{identity}-uv{number}", values, "ST", 8))
    vertices = SubElement(body, "vertices", id=f"{identity}-vertices")
    SubElement(vertices, "input", semantic="POSITION", source=f"#{identity}-positions")
    for group in mesh.groups:
        body.append(_triangles(identity, group))
    return element


def _triangles(identity: str, group: Triangles) -> Element:
    element = Element("triangles", material=group.symbol, count=str(len(group.positions) // 3))
    # Indices that are the same for two inputs are written once.
    columns: list[np.ndarray] = []

    def refer(semantic: str, to: str, indices: np.ndarray, **more: str) -> None:
        offset = next((i for i, column in enumerate(columns) if np.array_equal(column, indices)), len(columns))
        if offset == len(columns):
            columns.append(indices)
        SubElement(element, "input", semantic=semantic, source=f"#{identity}-{to}", offset=str(offset), **more)

    refer("VERTEX", "vertices", group.positions)
    refer("NORMAL", "normals", group.normals)
    for number, indices in enumerate(group.uvs):
        refer("TEXCOORD", f"uv{number}", indices, set=str(number))
    text(element, "p", wholes(np.stack(columns, axis=1)))
    return element


def source(identity: str, values: np.ndarray, params: Sequence[str], digits: int, kind: str = "float") -> Element:
    """A `<source>` of rows of numbers, with one letter or word for each column."""
    element = Element("source", id=identity)
    text(element, "float_array", reals(values, digits), id=f"{identity}-array", count=str(np.size(values)))
    _accessor(element, identity, np.size(values) // len(params), [(param, kind) for param in params])
    return element


def name_source(identity: str, names: Sequence[str]) -> Element:
    element = Element("source", id=identity)
    text(element, "Name_array", " ".join(names), id=f"{identity}-array", count=str(len(names)))
    _accessor(element, identity, len(names), [("INTERPOLATION", "name")])
    return element


def matrix_source(identity: str, values: np.ndarray) -> Element:
    element = Element("source", id=identity)
    text(element, "float_array", reals(values), id=f"{identity}-array", count=str(np.size(values)))
    _accessor(element, identity, np.size(values) // 16, [("TRANSFORM", "float4x4")], 16)
    return element


def _accessor(owner: Element, identity: str, count: int, params: list[tuple[str, str]], stride: int = 0) -> None:
    common = SubElement(owner, "technique_common")
    attributes = {"source": f"#{identity}-array", "count": str(count), "stride": str(stride or len(params))}
    accessor = SubElement(common, "accessor", attributes)
    for name, kind in params:
        SubElement(accessor, "param", name=name, type=kind)


def instance_geometry(geometry_id: str, bindings: Mapping[str, str], uv_names: Sequence[str]) -> Element:
    """`bindings`: material symbol to material id. `uv_names`: what the geometry's sets of texture coordinates are called."""
    element = Element("instance_geometry", url=f"#{geometry_id}")
    common = SubElement(SubElement(element, "bind_material"), "technique_common")
    for symbol, material_id in bindings.items():
        instance = SubElement(common, "instance_material", symbol=symbol, target=f"#{material_id}")
        for number, name in enumerate(uv_names):
            attributes = {"semantic": name, "input_semantic": "TEXCOORD", "input_set": str(number)}
            SubElement(instance, "bind_vertex_input", attributes)
    return element


def node(identity: str, name: str, matrix: np.ndarray, content: Element, size: Sequence[float] = ()) -> Element:
    """`matrix`: 4x4, for column vectors. `size`: a scale below it."""
    element = Element("node", id=identity, name=name)
    text(element, "matrix", reals(matrix), sid="transform")
    if len(size):
        text(element, "scale", reals(size), sid="size")
    element.append(content)
    return element


def document(tool: str, meter: float, libraries: Mapping[str, Sequence[Element]], render: Mapping[str, str]) -> Element:
    """The whole file, Z up."""
    root = Element("COLLADA", xmlns=_NAMESPACE, version="1.4.1")
    asset = SubElement(root, "asset")
    text(SubElement(asset, "contributor"), "authoring_tool", tool)
    SubElement(asset, "unit", name="meter" if meter == 1.0 else "unit", meter=f"{meter:.9g}")
    text(asset, "up_axis", "Z_UP")
    for library in _LIBRARIES:
        if libraries.get(library):
            SubElement(root, f"library_{library}").extend(libraries[library])
    scene = SubElement(root, "scene")
    SubElement(scene, "instance_visual_scene", url=f"#{VISUAL_SCENE}")
    technique(scene, [Element("render", render)])
    return root


def write(root: Element, path: str) -> None:
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)
