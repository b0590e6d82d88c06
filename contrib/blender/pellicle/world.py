"""The world as the renderer's environment."""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element

import bpy
import numpy as np

from . import graph
from .field import Evaluation, Field, Unsupported
from .graph import Input, Output
from .notes import Notes
from .numerals import real, reals
from .picture import Pictures, colorspace

# Blender's panoramas have -x in the middle of u = 0, the renderer's +y: a quarter turn.
_QUARTER_DEG = 90.0


def translate(world: bpy.types.World | None, pictures: Pictures, notes: Notes) -> Element | None:
    """The `<environment>`; `None` where it is black."""
    if world is None:
        return None
    tree = graph.tree_of(world)
    if graph.surface(tree, "Volume") is not None:
        notes.add(f"world `{world.name}`: its volume", "is not translated")
    background = graph.surface(tree, "Surface")
    if background is None:
        return None if tree is not None and tree.get_output_node("CYCLES") else _constant(world.color[:], 1.0)
    if background.kind != "ShaderNodeBackground":
        notes.add(f"world `{world.name}`: the node `{background.node.name}`", "is not translated; the world is black")
        return None
    colour, strength = background.input("Color"), background.input("Strength")
    factor = _number(world, strength, notes)
    source = colour.source()
    if source is not None and source.kind == "ShaderNodeTexEnvironment":
        return _image(world, source, factor, pictures, notes)
    try:
        rgb = Evaluation().at(colour).rgb().mean(axis=(0, 1))
    except Unsupported as fault:
        notes.add(f"world `{world.name}`: {fault}", "is not translated; the colour socket's own value is written")
        rgb = np.array(colour.socket.default_value[:3])
    return _constant(rgb, factor)


def _constant(rgb: np.ndarray | tuple[float, ...], strength: float) -> Element | None:
    if max(rgb) * strength <= 0.0:
        return None
    return Element("environment", radiance=reals(rgb, 7), strength=real(strength, 7))


def _image(world: bpy.types.World, source: Output, strength: float, pictures: Pictures, notes: Notes) -> Element | None:
    image = source.node.image
    turn = _turn_deg(source.input("Vector"))
    if image is None or source.node.projection != "EQUIRECTANGULAR" or turn is None:
        reason = "is not an equirectangular image, or its mapping does more than turn it about z"
        notes.add(f"world `{world.name}`: `{source.node.name}`", f"{reason}; the world is black")
        return None
    if not image.is_float and colorspace(image, notes) == "linear":
        notes.add(f"image `{image.name}`", "is linear and not of floating-point numbers: it is read as sRGB")
    element = Element("environment", image=pictures.copy(image), strength=real(strength, 7))
    element.set("rotation_deg", real(_QUARTER_DEG - turn, 7))
    return element


def _turn_deg(vector: Input | None) -> float | None:
    """The turn about z of what the texture is looked up with; `None` for anything else."""
    source = vector.source() if vector is not None else None
    if source is None or (source.kind == "ShaderNodeTexCoord" and source.socket.name in ("Generated", "Object")):
        return 0.0
    if source.kind != "ShaderNodeMapping" or _turn_deg(source.input("Vector")) != 0.0:
        return None
    values = [source.input(name) for name in ("Location", "Rotation", "Scale")]
    if any(value is not None and value.source() is not None for value in values):
        return None
    turn = values[1].default()
    others = [*turn[:2], *(values[0].default() if values[0] else ()), *(size - 1.0 for size in values[2].default())]
    return math.degrees(turn[2]) if max(map(abs, others)) < 1e-6 else None


def _number(world: bpy.types.World, socket: Input, notes: Notes) -> float:
    try:
        return float(Field.grey(Evaluation().at(socket)).mean())
    except Unsupported as fault:
        notes.add(f"world `{world.name}`: {fault}", "is not translated; the strength socket's own value is written")
        return float(socket.socket.default_value)
