"""Writes a scene file: one frame, or all frames of an animation."""

from __future__ import annotations

from pathlib import Path

import bpy

from .engine import PellicleEngine
from .writer import ExportError, Options, Report, Writer


def export(scene: bpy.types.Scene, path: str | Path, options: Options = Options()) -> Report:
    """Writes `scene` as Blender would render it, from its current frame on."""
    if scene.camera is None:
        raise ExportError(f"the scene `{scene.name}` has no camera: add one (Add > Camera)")
    writer = Writer(scene, Path(path), options)
    frames = [scene.frame_current]
    if options.animation:
        frames = list(range(scene.frame_start, scene.frame_end + 1))
    current, subframe = scene.frame_current, scene.frame_subframe
    try:
        for frame in frames:
            scene.frame_set(frame, subframe=0.0 if options.animation else subframe)
            PellicleEngine.visit(scene, writer.add)
    finally:
        scene.frame_set(current, subframe=subframe)
    return writer.write()
