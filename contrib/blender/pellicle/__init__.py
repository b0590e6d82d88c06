"""pellicle in Blender: File > Export > pellicle (.dae), Render properties > pellicle, and a render engine."""

from __future__ import annotations

import bpy

from .engine import PellicleEngine
from .operators import ExportScene, RenderPicture, menu
from .panel import PelliclePanel
from .preferences import PelliclePreferences, PellicleSettings

_CLASSES = (PelliclePreferences, PellicleSettings, PellicleEngine, ExportScene, RenderPicture, PelliclePanel)


def register() -> None:
    for each in _CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.pellicle = bpy.props.PointerProperty(type=PellicleSettings)
    bpy.types.TOPBAR_MT_file_export.append(menu)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_export.remove(menu)
    del bpy.types.Scene.pellicle
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
