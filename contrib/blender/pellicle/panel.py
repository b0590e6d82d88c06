"""Render properties > pellicle."""

from __future__ import annotations

import bpy

from .operators import RenderPicture


class PelliclePanel(bpy.types.Panel):
    bl_idname = "RENDER_PT_pellicle"
    bl_label = "pellicle"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.pellicle
        self.layout.use_property_split = True
        for name in ("samples", "noise", "mode"):
            self.layout.prop(settings, name)
        self.layout.operator(RenderPicture.bl_idname, icon="RENDER_STILL")
