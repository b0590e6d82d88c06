"""Materials as effects."""

from __future__ import annotations

from collections.abc import Callable
from xml.etree.ElementTree import Element

import bpy

from . import collada, graph, shaders
from .notes import Notes
from .numerals import reals
from .picture import Pictures
from .reader import Reader
from .texcoord import TexCoord

# What Blender shows where there is no material.
_DEFAULT = (0.8, 0.8, 0.8)


def translate(
    identity: str,
    material: bpy.types.Material | None,
    pictures: Pictures,
    notes: Notes,
    chord: Callable[[], float],
    meter: float,
) -> tuple[Element, set[TexCoord]]:
    """The `<effect>`, and the texture coordinates that its maps need."""
    if material is None:
        return collada.effect(identity, Element("diffuse", reflectance=reals(_DEFAULT)), _DEFAULT), set()
    tree = graph.tree_of(material)
    animated = tree is not None and tree.animation_data is not None
    reader = Reader(material.name, animated, pictures, notes, chord, meter)
    output = graph.surface(tree, "Surface")
    if output is not None:
        base, colour = shaders.surface(reader, output)
    elif tree is not None and tree.get_output_node("CYCLES") is not None:
        # Without a surface shader there is only a volume, or nothing at all.
        base, colour = Element("dielectric", ior="1", priority="0"), _DEFAULT
        if graph.surface(tree, "Volume") is None:
            base, colour = Element("diffuse", reflectance="0"), (0.0, 0.0, 0.0)
    else:
        colour = tuple(material.diffuse_color)[:3]
        base = Element("diffuse", reflectance=reals(colour, 7))
    _volume(reader, base, tree)
    displacement = graph.surface(tree, "Displacement")
    if displacement is not None:
        reader.note(f"the displacement by `{displacement.node.name}`", "is not translated")
    return collada.effect(identity, base, colour), reader.texcoords


def _volume(reader: Reader, base: Element, tree: bpy.types.NodeTree | None) -> None:
    volume = graph.surface(tree, "Volume")
    if volume is None:
        return
    if volume.kind != "ShaderNodeVolumeAbsorption" or base.tag != "dielectric":
        reader.note(f"the volume `{volume.node.name}`", "only Volume Absorption in glass is translated")
        return
    density = reader.number(volume.input("Density"), 1.0)
    # The colour is what a unit of density lets through, to first order.
    absorption = [density * (1.0 - min(value, 1.0)) / reader.meter for value in reader.rgb(volume.input("Color"))]
    base.set("absorption_per_m", reals(absorption, 7))
