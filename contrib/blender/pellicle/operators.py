"""File > Export, and the render that runs beside Blender."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import bpy
from bpy_extras.io_utils import ExportHelper

from .exporter import ExportError, Options, Report, export
from .preferences import program, render_options
from .program import ProgramMissing, Run, find, render_command

_INTERVAL_S = 0.2


class ExportScene(bpy.types.Operator, ExportHelper):
    """Write the scene for pellicle, as COLLADA with films, metals, lights and lenses"""

    bl_idname = "export_scene.pellicle"
    bl_label = "Export for pellicle"
    filename_ext = ".dae"
    filter_glob: bpy.props.StringProperty(default="*.dae", options={"HIDDEN"})
    animation: bpy.props.BoolProperty(name="Animation", description="Write all frames of the scene, not the current one alone")

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            report = export(context.scene, self.filepath, Options(self.animation, context.scene.pellicle.samples))
        except (ExportError, OSError) as fault:
            self.report({"ERROR"}, str(fault))
            return {"CANCELLED"}
        tell(self, report)
        return {"FINISHED"}


class RenderPicture(bpy.types.Operator):
    """Render the scene with pellicle and show the picture; Esc stops with what there is"""

    bl_idname = "render.pellicle"
    bl_label = "Render with pellicle"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if not self._start(context):
            return {"CANCELLED"}
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self._timer = manager.event_timer_add(_INTERVAL_S, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == "ESC":
            self._run.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        context.window_manager.progress_update(100.0 * self._run.share)
        context.workspace.status_text_set(f"pellicle: {100.0 * self._run.share:.0f} %, {self._run.state}; Esc stops")
        if self._run.running():
            return {"RUNNING_MODAL"}
        context.workspace.status_text_set(None)
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        return self._end()

    def execute(self, context: bpy.types.Context) -> set[str]:
        """For scripts: waits for the picture."""
        if not self._start(context):
            return {"CANCELLED"}
        while self._run.running():
            time.sleep(_INTERVAL_S)
        return self._end()

    def _start(self, context: bpy.types.Context) -> bool:
        self._folder = tempfile.TemporaryDirectory(prefix="pellicle-")
        scene = Path(self._folder.name) / "scene.dae"
        self._picture = scene.with_suffix(".exr")
        try:
            path = find(program())
            tell(self, export(context.scene, scene))
        except (ExportError, ProgramMissing, OSError) as fault:
            self.report({"ERROR"}, str(fault))
            return False
        self._run = Run(render_command(path, str(scene), str(self._picture), render_options(context.scene)))
        return True

    def _end(self) -> set[str]:
        code = self._run.finish()
        if not self._picture.is_file():
            self.report({"ERROR"}, "\n".join(self._run.messages) or f"pellicle ended with {code}")
            return {"CANCELLED"}
        image = bpy.data.images.load(str(self._picture))
        image.name = "pellicle"
        # The file goes with its folder: the image keeps the pixels.
        image.pack()
        self._folder.cleanup()
        show(image)
        self.report({"INFO"}, self._run.messages[-1] if self._run.messages else "rendered")
        return {"FINISHED"}


def tell(operator: bpy.types.Operator, report: Report) -> None:
    """Says what was written, and by name what was not."""
    print(report.summary())
    for line in report.notes:
        print(f"  {line}")
        operator.report({"WARNING"}, line)
    operator.report({"INFO"}, report.summary())


def show(image: bpy.types.Image) -> None:
    """In every image editor that is open."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                area.spaces.active.image = image


def menu(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    self.layout.operator(ExportScene.bl_idname, text="pellicle (.dae)")
