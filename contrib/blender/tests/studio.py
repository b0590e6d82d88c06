"""What the scenarios share: small scenes, pictures of them by Cycles and by pellicle, and their numbers."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from xml.etree import ElementTree

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

import pellicle  # noqa: E402
from pellicle.exporter import Options, Report, export  # noqa: E402

PROGRAM = os.environ.get("PELLICLE_PROGRAM", "pellicle")
# The add-on looks for it on PATH.
os.environ["PATH"] = f"{Path(PROGRAM).parent}{os.pathsep}{os.environ['PATH']}"
NAMES = {"c": "http://www.collada.org/2005/11/COLLADASchema"}
FOLDER = Path(tempfile.mkdtemp(prefix="pellicle-blender-"))


def empty(width: int = 16, height: int = 16, samples: int = 64) -> bpy.types.Scene:
    """A scene with a black world and a camera at the origin that looks down."""
    if hasattr(bpy.types.Scene, "pellicle"):
        pellicle.unregister()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    pellicle.register()
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", samples, False, False
    cycles.sample_clamp_indirect, cycles.pixel_filter_type = 0.0, "BOX"
    scene.camera = place(bpy.data.cameras.new("camera"))
    world = bpy.data.worlds.new("world")
    scene.world = world
    with_nodes(world).nodes["Background"].inputs["Strength"].default_value = 0.0
    return scene


def with_nodes(owner: bpy.types.Material | bpy.types.World) -> bpy.types.NodeTree:
    """The node tree, which older versions only have when asked for."""
    if owner.node_tree is None:
        owner.use_nodes = True
    return owner.node_tree


def place(
    data: bpy.types.ID | None, location: tuple = (0, 0, 0), rotation: tuple = (0, 0, 0), name: str = ""
) -> bpy.types.Object:
    entity = bpy.data.objects.new(name or (data.name if data else "empty"), data)
    entity.location, entity.rotation_euler = location, rotation
    bpy.context.scene.collection.objects.link(entity)
    return entity


def material(name: str, shader: str, **inputs: object) -> bpy.types.Material:
    """One shader node with these inputs, their spaces written as `_`."""
    made = bpy.data.materials.new(name)
    tree = with_nodes(made)
    tree.nodes.clear()
    node = tree.nodes.new(f"ShaderNode{shader}")
    node.name = "shader"
    for key, value in inputs.items():
        if isinstance(value, str):
            setattr(node, key, value)
        else:
            socket = node.inputs[key.replace("_", " ")]
            socket.default_value = (*value, 1.0) if socket.type == "RGBA" else value
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return made


def ball(radius: float, location: tuple, surface: bpy.types.Material | None, name: str = "ball") -> bpy.types.Object:
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5, radius=radius, location=location)
    return _dressed(surface, name)


def sheet(size: float, location: tuple, surface: bpy.types.Material | None, rotation: tuple = (0, 0, 0)) -> bpy.types.Object:
    bpy.ops.mesh.primitive_plane_add(size=size, location=location, rotation=rotation)
    return _dressed(surface, "sheet")


def _dressed(surface: bpy.types.Material | None, name: str) -> bpy.types.Object:
    entity = bpy.context.object
    entity.name = name
    bpy.ops.object.shade_smooth()
    if surface is not None:
        entity.data.materials.append(surface)
    return entity


def lamp(kind: str, location: tuple = (0.3, 0.2, 2.0), rotation: tuple = (0, 0, 0), **values: object) -> bpy.types.Object:
    light = bpy.data.lights.new(kind.lower(), kind)
    for name, value in values.items():
        setattr(light, name, value)
    return place(light, location, rotation)


def written(name: str, **options: bool) -> tuple[str, Report]:
    path = FOLDER / f"{name}.dae"
    report = export(bpy.context.scene, path, Options(**options))
    return str(path), report


def run(*arguments: str) -> str:
    """What the program prints; a test fails with its messages, warnings too."""
    done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True)
    if done.returncode or "warning" in done.stderr:
        raise AssertionError(f"pellicle {' '.join(arguments)}: {done.stderr}")
    return done.stdout


def ours(name: str, *options: str) -> np.ndarray:
    """The scene by pellicle: (rows, columns, 3), the lower row first."""
    path, _ = written(name)
    picture = path.replace(".dae", ".exr")
    run("render", path, "-o", picture, "--float", "-q", "--filter", "box", *options)
    return pixels(picture)


def cycles(name: str) -> np.ndarray:
    scene = bpy.context.scene
    scene.render.filepath = str(FOLDER / f"{name}-cycles.exr")
    bpy.ops.render.render(write_still=True)
    return pixels(scene.render.filepath)


def pixels(path: str) -> np.ndarray:
    image = bpy.data.images.load(path)
    columns, rows = image.size
    values = np.empty(rows * columns * 4, np.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    return values.reshape(rows, columns, 4)[:, :, :3].astype(np.float64)


def texture(scene: bpy.types.Scene, texels: np.ndarray, strength: float) -> None:
    """Puts a panorama, the lower row first, around the scene."""
    rows, columns, _ = texels.shape
    image = bpy.data.images.new("world", columns, rows, float_buffer=True)
    image.pixels.foreach_set(texels.ravel())
    image.update()
    tree = with_nodes(scene.world)
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.name, node.image = "panorama", image
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    tree.nodes["Background"].inputs["Strength"].default_value = strength


def base_of(path: str, effect: str) -> ElementTree.Element:
    found = ElementTree.parse(path).find(f".//c:effect[@id='{effect}']/c:extra/c:technique[@profile='pellicle']", NAMES)
    assert found is not None, effect
    # Without the namespace, which our own names do not need.
    for element in found.iter():
        element.tag = element.tag.rpartition("}")[2]
    return found[0]


def element(path: str, place: str) -> ElementTree.Element:
    """The first of these elements of a scene file; their names begin with `c:`."""
    found = ElementTree.parse(path).find(place, NAMES)
    assert found is not None, place
    return found


def numbers(text: str | None) -> list[float]:
    return [float(word) for word in (text or "").split()]


def finish() -> None:
    """Runs the tests of the script and ends it."""
    print(f"Blender {bpy.app.version_string}")
    passed = unittest.main(exit=False).result.wasSuccessful()
    sys.stdout.flush()
    # Blender as a module may hang while Python takes it apart.
    os._exit(0 if passed else 1)
