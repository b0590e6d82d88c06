"""One moment of a scene as elements of the file, from what Blender would render then."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree.ElementTree import Element

import bpy
import numpy as np
from mathutils import Matrix

from . import camera, collada, light, material, mesh, world
from .collada import Mesh
from .names import Names
from .notes import Notes
from .picture import Pictures
from .texcoord import TexCoord

# An object's name, and the numbers of the instancers that brought it here.
Key = tuple

_SHAPES = ("MESH", "CURVE", "SURFACE", "META", "FONT")
_UNTRANSLATED = {
    "CURVES": "hair curves are", "POINTCLOUD": "point clouds are", "VOLUME": "volumes are", "LIGHT_PROBE": "light probes are",
    "GPENCIL": "grease pencil is", "GREASEPENCIL": "grease pencil is",
}  # fmt: skip


@dataclass
class Geometry:
    """A mesh in the file."""

    identity: str
    name: str
    mesh: Mesh
    digest: bytes


@dataclass
class Snapshot:
    """What a frame holds."""

    nodes: dict[Key, Element] = field(default_factory=dict)
    effects: dict[str, Element] = field(default_factory=dict)
    lights: dict[str, Element] = field(default_factory=dict)
    cameras: dict[str, Element] = field(default_factory=dict)
    environment: Element | None = None

    def elements(self) -> Iterator[Element]:
        """All that has numbers which may change."""
        yield from self.nodes.values()
        yield from self.effects.values()
        yield from self.lights.values()
        yield from self.cameras.values()
        scene = Element("visual_scene", id=collada.VISUAL_SCENE)
        if self.environment is not None:
            collada.technique(scene, [self.environment])
        yield scene


class Collector:
    """Takes snapshots; remembers ids, meshes and images between them."""

    def __init__(self, scene_file: Path, meter: float, notes: Notes) -> None:
        self.meter = meter
        self.notes = notes
        self.names = Names()
        self.pictures = Pictures(scene_file, notes)
        self.geometries: dict[str, Geometry] = {}
        self.materials: dict[str, str] = {}
        self._effects: dict[str, tuple[Element, set[TexCoord]]] = {}
        # The mesh of each node of the first snapshot.
        self._placed: dict[Key, str] = {}
        self._first = True

    def take(self, depsgraph: bpy.types.Depsgraph) -> Snapshot:
        """Meshes are read in the first snapshot only; later ones look whether they have changed."""
        shot = Snapshot()
        # Of this moment: meshes and their digests by where Blender keeps them, effects that are up to date.
        self._shared: dict[tuple, str] = {}
        self._digests: dict[int, bytes] = {}
        self._slots: dict[int, list[int]] = {}
        self._fresh: set[str] = set()
        for instance in depsgraph.object_instances:
            self._add(shot, instance, depsgraph.scene)
        shot.environment = world.translate(depsgraph.scene.world, self.pictures, self.notes)
        self._first = False
        return shot

    def _add(self, shot: Snapshot, instance: bpy.types.DepsgraphObjectInstance, scene: bpy.types.Scene) -> None:
        entity = instance.object
        if not instance.show_self:
            return
        key = (entity.original.name_full, *_ancestry(instance))
        matrix = instance.matrix_world
        if entity.type == "MESH":
            self._shape(shot, key, entity, matrix)
        elif entity.type == "LIGHT":
            self._lamp(shot, key, entity, matrix, scene)
        elif entity.type == "CAMERA" and not instance.is_instance:
            rigid = _rigid(matrix)
            identity = self.names.of(("camera", entity.original.name_full), f"{entity.name}-camera")
            shot.cameras[identity] = camera.translate(identity, entity.data, rigid, scene, self.meter, self.notes)
            self._place(shot, key, entity.name, rigid, Element("instance_camera", url=f"#{identity}"))
        elif entity.type in _UNTRANSLATED:
            self.notes.add(f"object `{entity.name}`", f"{_UNTRANSLATED[entity.type]} not translated")

    def _place(self, shot: Snapshot, key: Key, name: str, matrix: Matrix, content: Element, size: tuple[float, ...] = ()) -> str:
        identity = self.names.of(("node", key), name)
        shot.nodes[key] = collada.node(identity, name, np.array(matrix), content, size)
        return identity

    def _shape(self, shot: Snapshot, key: Key, entity: bpy.types.Object, matrix: Matrix) -> None:
        data = entity.data
        if not data.polygons:
            return
        self._remarks(entity)
        pointer = data.as_pointer()
        if pointer not in self._slots:
            self._slots[pointer] = mesh.slots(data)
        used = _materials(entity, self._slots[pointer])
        effects = {slot: self._material(shot, owner, entity, matrix) for slot, owner in used.items()}
        if self._first:
            self._placed[key] = self._geometry(data, effects)
        elif key in self._placed:
            self._compare(self.geometries[self._placed[key]], data)
        else:
            self.notes.add(f"object `{entity.name}`", "is not there in the first frame: it is left out")
            return
        geometry = self._placed[key]
        bindings = {mesh.symbol(slot): f"{effect}-material" for slot, effect in effects.items()}
        uv_names = [name for name, _ in self.geometries[geometry].mesh.uv_sets]
        self._place(shot, key, entity.name, matrix, collada.instance_geometry(geometry, bindings, uv_names))

    def _geometry(self, data: bpy.types.Mesh, effects: dict[int, str]) -> str:
        """The id of a mesh, which is read once however often it is placed."""
        texcoords = tuple(sorted(set().union(*(self._effects[effect][1] for effect in effects.values())), key=TexCoord.name))
        shared = (data.as_pointer(), texcoords)
        if shared not in self._shared:
            identity = self.names.of(("mesh", shared), f"{data.name}-mesh")
            self.geometries[identity] = Geometry(identity, data.name, mesh.read(data, texcoords), mesh.digest(data))
            self._shared[shared] = identity
        return self._shared[shared]

    def _compare(self, geometry: Geometry, data: bpy.types.Mesh) -> None:
        pointer = data.as_pointer()
        if pointer not in self._digests:
            self._digests[pointer] = mesh.digest(data)
        if self._digests[pointer] != geometry.digest:
            self.notes.add(f"mesh `{data.name}`", "changes its form over time: it stays as at the first frame")

    def _material(self, shot: Snapshot, owner: bpy.types.Material | None, entity: bpy.types.Object, matrix: Matrix) -> str:
        """The id of a material's effect. Only materials that may have changed are read again."""
        name = owner.original.name_full if owner is not None else ""
        identity = self.names.of(("effect", name), owner.name if owner is not None else "default")
        animated = owner is not None and owner.node_tree is not None and owner.node_tree.animation_data is not None
        if identity not in self._effects or (animated and identity not in self._fresh):
            chord = lambda: mesh.mean_chord(entity.data, abs(matrix.determinant()) ** (1.0 / 3.0))  # noqa: E731
            effect = material.translate(identity, owner, self.pictures, self.notes, chord, self.meter)
            self._effects[identity] = effect
            self._fresh.add(identity)
            self.materials[f"{identity}-material"] = identity
        shot.effects[identity] = self._effects[identity][0]
        return identity

    def _lamp(self, shot: Snapshot, key: Key, entity: bpy.types.Object, matrix: Matrix, scene: bpy.types.Scene) -> None:
        scale = tuple(round(matrix.col[axis].length, 6) for axis in (0, 1))
        hidden = not (entity.visible_camera or entity.visible_glossy or entity.visible_transmission)
        linking = entity.light_linking
        if linking.receiver_collection is not None or linking.blocker_collection is not None:
            self.notes.add(f"light `{entity.name}`: light linking", "it shines on everything here")
        identity = self.names.of(("light", entity.data.original.name_full, scale, hidden), f"{entity.data.name}-light")
        lamp = light.translate(identity, entity.data, scale, hidden, self.notes)
        if lamp.width > 0.0 and not entity.visible_camera and not hidden and _in_view(matrix, lamp.width, scene):
            self.notes.add(f"light `{entity.name}`", "is in the picture: hiding it from the camera alone is not possible here")
        shot.lights[identity] = lamp.element
        # Blender's lamps shine alike whatever their scale is; an area's is part of its size.
        place = matrix if entity.data.type == "AREA" else _rigid(matrix)
        self._place(shot, key, entity.name, place, Element("instance_light", url=f"#{identity}"), lamp.size)

    def _remarks(self, entity: bpy.types.Object) -> None:
        for name in ("visible_camera", "visible_diffuse", "visible_glossy", "visible_transmission", "visible_shadow"):
            if not getattr(entity, name):
                self.notes.add(f"object `{entity.name}`: `{name}` is off", "all rays see it here")
        for name in ("is_holdout", "is_shadow_catcher"):
            if getattr(entity, name):
                self.notes.add(f"object `{entity.name}`: `{name}`", "it is an ordinary object here")
        for system in entity.particle_systems:
            if system.settings.render_type in ("PATH", "HALO", "LINE"):
                self.notes.add(f"object `{entity.name}`: the strands or points of `{system.name}`", "are not translated")


def _ancestry(instance: bpy.types.DepsgraphObjectInstance) -> tuple:
    """What tells instances of one object apart, alike in every frame."""
    if not instance.is_instance:
        return ()
    return (instance.parent.original.name_full, *(number for number in instance.persistent_id if number != 0x7FFFFFFF))


def _materials(entity: bpy.types.Object, indices: list[int]) -> dict[int, bpy.types.Material | None]:
    """The material of each slot that polygons use: the object's own where a slot says so, else the mesh's."""
    data = entity.data
    slots = entity.material_slots
    used = {}
    for index in indices:
        if index < len(slots) and slots[index].link == "OBJECT":
            used[index] = slots[index].material
        else:
            # Polygons of a slot that is not there take the last one.
            used[index] = data.materials[min(index, len(data.materials) - 1)] if len(data.materials) else None
    return used


def _rigid(matrix: Matrix) -> Matrix:
    """Without scale: neither view nor light of a camera or lamp depends on it."""
    location, rotation, _ = matrix.decompose()
    return Matrix.LocRotScale(location, rotation, None)


def _in_view(matrix: Matrix, width: float, scene: bpy.types.Scene) -> bool:
    """Whether a square thing of this width may be seen by the camera."""
    if scene.camera is None:
        return False
    here = _rigid(scene.camera.matrix_world).inverted() @ matrix.translation
    depth = -here.z
    low, high = camera.frame(scene.camera.data, scene)
    spread = 1.0 if scene.camera.data.type == "ORTHO" else depth
    reach = width * 0.5**0.5
    return depth > 0.0 and all(low[axis] * spread - reach < here[axis] < high[axis] * spread + reach for axis in (0, 1))
