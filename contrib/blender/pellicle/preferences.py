"""Where the program is, and how a scene wants to be rendered."""

from __future__ import annotations

import bpy


class PelliclePreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: bpy.props.StringProperty(
        name="Program", description="Path of `pellicle`; empty: the one on PATH", subtype="FILE_PATH"
    )

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.prop(self, "program")


class PellicleSettings(bpy.types.PropertyGroup):
    samples: bpy.props.IntProperty(name="Samples", description="Most samples per pixel", default=128, min=1, max=1 << 20)
    noise: bpy.props.FloatProperty(
        name="Noise",
        description="Stop at this relative error of the picture; 0: take all samples",
        default=0.0,
        min=0.0,
        max=1.0,
        precision=3,
    )
    mode: bpy.props.EnumProperty(
        name="Colours",
        items=[
            ("auto", "Automatic", "RGB where it is exact enough for the scene, else spectral"),
            ("rgb", "RGB", "Three channels"),
            ("spectral", "Spectral", "Wavelengths"),
        ],
    )


def program() -> str:
    """The preferred path; empty for a script that is not installed as an extension."""
    addon = bpy.context.preferences.addons.get(__package__)
    return addon.preferences.program if addon is not None else ""


def render_options(scene: bpy.types.Scene) -> list[str]:
    """Options of `pellicle render`."""
    settings = scene.pellicle
    options = ["--spp", str(settings.samples), "--mode", settings.mode]
    return [*options, "--noise", f"{settings.noise:.4g}"] if settings.noise > 0.0 else options
