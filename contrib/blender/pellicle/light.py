"""Lamps, by Blender's own extra where COLLADA has no words: our renderer reads sizes, edges and shapes from it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

import bpy
import numpy as np

from . import graph, watts
from .collada import technique, text
from .field import Evaluation, Field, Unsupported
from .notes import Notes
from .numerals import real, reals

# Blender's numbers for kinds of lamps and shapes of areas.
_POINT, _SPOT, _AREA = "0", "2", "4"
_RECTANGLE, _DISK = "1", "4"

# Takes a remark on the lamp: what, and what is written instead.
Note = Callable[[str, str], None]


@dataclass
class Lamp:
    element: Element
    # Scale of an area's unit shape.
    size: tuple[float, ...] = ()
    # Extent across, in Blender units, of what a camera would see.
    width: float = 0.0


def translate(identity: str, light: bpy.types.Light, scale: tuple[float, float], hidden: bool, notes: Notes) -> Lamp:
    """`scale`: of the object along its x and y. `hidden`: neither camera, mirrors nor glass see the lamp."""
    note = lambda what, advice: notes.add(f"light `{light.name}`: {what}", advice)  # noqa: E731
    element = Element("light", id=identity, name=light.name)
    colour = _colour(light, note)
    if not light.use_shadow:
        note("no shadows", "it casts them here")
    if not getattr(light, "normalize", True):
        note("`Normalize` is off", "the power is taken as if it were on")
    for name in ("diffuse_factor", "specular_factor", "transmission_factor"):
        if getattr(light, name, 1.0) != 1.0:
            note(f"`{name}`", "is not translated")
    if light.type == "SUN":
        _common(element, "directional", colour * light.energy)
        if light.angle > 0.0:
            technique(element, [Element("spectrum", angle_deg=real(math.degrees(light.angle), 7))])
        return Lamp(element)
    if light.type == "AREA":
        return _area(element, light, colour, scale, hidden, note)
    intensity = colour * watts.point_intensity(light.energy)
    radius = 0.0 if hidden else light.shadow_soft_size
    if light.type == "SPOT":
        if light.use_square:
            note("a square spot", "is written round")
        spot = _common(element, "spot", intensity)
        text(spot, "falloff_angle", real(math.degrees(light.spot_size), 7))
        edge = {"spotsize": math.degrees(light.spot_size), "spotblend": light.spot_blend}
        _extra(element, {"type": _SPOT, "radius": radius} | edge)
    else:
        _common(element, "point", intensity)
        _extra(element, {"type": _POINT, "radius": radius})
    return Lamp(element, width=2.0 * radius)


def _area(
    element: Element, light: bpy.types.AreaLight, colour: np.ndarray, scale: tuple[float, float], hidden: bool, note: Note
) -> Lamp:
    width = light.size
    height = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else width
    is_round = light.shape in ("DISK", "ELLIPSE")
    world = (width * scale[0], height * scale[1])
    area = watts.disc_area(*world) if is_round else world[0] * world[1]
    if light.spread < math.pi - 1e-3:
        note(f"`Spread` {math.degrees(light.spread):.0f} degrees", "it shines to all sides of its front")
    if area <= 0.0:
        note("no area", "it gives no light")
        colour, area = colour * 0.0, 1.0
    radiance = colour * watts.area_radiance(light.energy, area)
    if hidden:
        shape = "disk" if is_round else "rectangle"
        technique(element, [Element("area", shape=shape, radiance=reals(radiance, 7), visible="false")])
    else:
        _common(element, "point", radiance)
        _extra(element, {"type": _AREA, "area_shape": _DISK if is_round else _RECTANGLE, "area_size": 1.0, "area_sizey": 1.0})
    return Lamp(element, (width, height, 1.0), max(world))


def _common(element: Element, kind: str, colour: np.ndarray) -> Element:
    source = SubElement(SubElement(element, "technique_common"), kind)
    text(source, "color", reals(colour), sid="color")
    return source


def _extra(element: Element, values: dict[str, float | str]) -> None:
    children = []
    for tag, value in values.items():
        child = Element(tag)
        child.text = value if isinstance(value, str) else real(value, 7)
        children.append(child)
    technique(element, children, "blender")


def _colour(light: bpy.types.Light, note: Note) -> np.ndarray:
    """All factors of the strength but the energy."""
    colour = np.array(light.color[:], np.float64) * 2.0 ** getattr(light, "exposure", 0.0)
    if getattr(light, "use_temperature", False):
        colour *= light.temperature_color[:]
    tree = light.node_tree if light.use_nodes else None
    source = graph.surface(tree, "Surface")
    if source is None:
        return colour
    if source.kind != "ShaderNodeEmission":
        note(f"the node `{source.node.name}`", "is not translated")
        return colour
    try:
        tint, strength = (Evaluation().at(source.input(name)) for name in ("Color", "Strength"))
    except Unsupported as fault:
        note(str(fault), "is not translated")
        return colour
    if tint.picture is not None or strength.picture is not None:
        note("an image", "its mean is written")
    return colour * Field.rgb(tint).mean(axis=(0, 1)) * Field.grey(strength).mean()
