"""Puts the frames of a scene into a file."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree.ElementTree import Element

import bpy

from . import animation, collada
from .notes import Notes
from .snapshot import Collector, Snapshot


class ExportError(Exception):
    """A scene that cannot be written as it is; the message says what to do."""


@dataclass
class Options:
    animation: bool = False
    # Samples per pixel that the file asks for; `None` leaves it to the renderer.
    samples: int | None = None


@dataclass
class Report:
    path: Path
    meshes: int = 0
    triangles: int = 0
    nodes: int = 0
    channels: int = 0
    notes: list[str] = field(default_factory=list)

    def summary(self) -> str:
        animated = f", {self.channels} animated values" if self.channels else ""
        return f"{self.path}: {self.nodes} nodes, {self.meshes} meshes, {self.triangles} triangles{animated}"


class Writer:
    """Collects snapshots, then writes the file."""

    def __init__(self, scene: bpy.types.Scene, path: Path, options: Options) -> None:
        self._path = path
        self._options = options
        self._notes = Notes()
        self._collector = Collector(path, scene.unit_settings.scale_length or 1.0, self._notes)
        self._first: Snapshot | None = None
        self._times_s: list[float] = []
        self._values: list[animation.Values] = []
        self._render: dict[str, str] = {}

    def add(self, depsgraph: bpy.types.Depsgraph) -> None:
        """The next frame."""
        scene = depsgraph.scene
        shot = self._collector.take(depsgraph)
        if self._first is None:
            self._first = shot
            self._render = self._hints(scene)
            _note_scene(scene, self._notes)
        render = scene.render
        self._times_s.append(scene.frame_current_final * render.fps_base / render.fps)
        values: animation.Values = {}
        for element in shot.elements() if self._options.animation else ():
            values.update(animation.values(element))
        self._values.append(values)

    def _hints(self, scene: bpy.types.Scene) -> dict[str, str]:
        render = scene.render
        width, height = picture_size(scene)
        hints = {"width": str(width), "height": str(height)}
        pixel_aspect = render.pixel_aspect_x / render.pixel_aspect_y
        if pixel_aspect != 1.0:
            hints["pixel_aspect"] = f"{pixel_aspect:.7g}"
        if self._options.samples is not None:
            hints["spp"] = str(self._options.samples)
        cycles = getattr(scene, "cycles", None)
        exposure_ev = scene.view_settings.exposure
        if cycles is not None:
            hints["max_bounces"] = str(cycles.max_bounces)
            exposure_ev += math.log2(max(cycles.film_exposure, 1e-6))
        if exposure_ev != 0.0:
            hints["exposure_ev"] = f"{exposure_ev:.7g}"
        hints["camera"] = self._collector.names.of(("node", (scene.camera.original.name_full,)), scene.camera.name)
        return hints

    def write(self) -> Report:
        collector, first = self._collector, self._first
        if first is None:
            raise ExportError("Blender rendered no frame: is the view layer used for rendering?")
        channels = animation.channels(self._values, self._times_s, self._notes)
        visual_scene = Element("visual_scene", id=collada.VISUAL_SCENE)
        visual_scene.extend(first.nodes.values())
        if first.environment is not None:
            collada.technique(visual_scene, [first.environment])
        geometries = [collada.geometry(each.identity, each.name, each.mesh) for each in collector.geometries.values()]
        libraries = {
            "cameras": list(first.cameras.values()),
            "lights": list(first.lights.values()),
            "effects": list(first.effects.values()),
            "materials": [collada.material(*pair, pair[1]) for pair in collector.materials.items() if pair[1] in first.effects],
            "geometries": geometries,
            "animations": channels,
            "visual_scenes": [visual_scene],
        }
        tool = f"pellicle add-on in Blender {bpy.app.version_string}"
        collada.write(collada.document(tool, collector.meter, libraries, self._render), str(self._path))
        triangles = sum(len(group.positions) // 3 for each in collector.geometries.values() for group in each.mesh.groups)
        return Report(
            self._path, len(geometries), triangles, len(first.nodes), len(channels), self._notes.lines()
        )


def picture_size(scene: bpy.types.Scene) -> tuple[int, int]:
    """Columns and rows."""
    render = scene.render
    width, height = (size * render.resolution_percentage // 100 for size in (render.resolution_x, render.resolution_y))
    return max(width, 1), max(height, 1)


def _note_scene(scene: bpy.types.Scene, notes: Notes) -> None:
    render = scene.render
    facts = [
        (render.use_motion_blur, "motion blur", "`pellicle animate --shutter` blurs; it is not in the file"),
        (render.use_border, "the render region", "the whole picture is rendered (`--crop` renders a part)"),
        (render.film_transparent, "a transparent film", "the world is seen behind"),
        (render.use_multiview, "stereo views", "only the camera itself is written"),
    ]
    for is_so, what, advice in facts:
        if is_so:
            notes.add(f"scene `{scene.name}`: {what}", advice)
