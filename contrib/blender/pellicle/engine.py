"""pellicle as a render engine: Blender hands it scenes as they are rendered, with all that `render` settings change.

The exporter reads scenes through it too. There is no other way to the evaluated scene at render level: what scripts get
elsewhere has the viewport's subdivision and visibility.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import bpy

from . import exr
from .preferences import program, render_options
from .program import ProgramMissing, Run, find, render_command
from .writer import Options, Writer, picture_size

# Seconds between looks at the program.
_INTERVAL_S = 0.1


class PellicleEngine(bpy.types.RenderEngine):
    bl_idname = "PELLICLE"
    bl_label = "pellicle"
    bl_use_preview = False
    bl_use_eevee_viewport = True

    # Who gets the scene instead of the renderer, while the exporter is at work.
    _visitor: Callable[[bpy.types.Depsgraph], None] | None = None
    _fault: Exception | None = None

    @classmethod
    def visit(cls, scene: bpy.types.Scene, visitor: Callable[[bpy.types.Depsgraph], None]) -> None:
        """Calls `visitor` with the scene at its current frame as it would be rendered. Raises what it raises."""
        render = scene.render
        kept = {name: getattr(render, name) for name in ("engine", "use_compositing", "use_sequencer")}
        layer = bpy.context.view_layer if bpy.context.scene == scene else scene.view_layers[0]
        cls._visitor, cls._fault = visitor, None
        try:
            render.engine, render.use_compositing, render.use_sequencer = cls.bl_idname, False, False
            bpy.ops.render.render(scene=scene.name, layer=layer.name)
        finally:
            cls._visitor = None
            for name, value in kept.items():
                setattr(render, name, value)
        if cls._fault is not None:
            raise cls._fault

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Blender's call."""
        visitor = PellicleEngine._visitor
        try:
            if visitor is not None:
                visitor(depsgraph)
            else:
                self._picture(depsgraph)
        except Exception as fault:
            # Blender prints what its engines raise and goes on: the exporter has to hear of it.
            PellicleEngine._fault = fault
            if visitor is None:
                # Without a result Blender crashes when it is to write one.
                self.end_result(self.begin_result(0, 0, *picture_size(depsgraph.scene)))
                self.report({"ERROR"}, str(fault))

    def _picture(self, depsgraph: bpy.types.Depsgraph) -> None:
        scene = depsgraph.scene
        with tempfile.TemporaryDirectory(prefix="pellicle-") as folder:
            path = Path(folder) / "scene.dae"
            writer = Writer(scene, path, Options())
            writer.add(depsgraph)
            for line in writer.write().notes:
                print(f"pellicle: {line}")
            picture = str(path.with_suffix(".exr"))
            run = Run(render_command(find(program()), str(path), picture, render_options(scene)))
            self._watch(run)
            if run.finish() not in (0, 130) or not Path(picture).is_file():
                raise ProgramMissing("\n".join(run.messages[-4:]))
            self._show(picture)

    def _watch(self, run: Run) -> None:
        while run.running():
            if self.test_break():
                run.cancel()
            self.update_progress(run.share)
            self.update_stats("pellicle", run.state)
            time.sleep(_INTERVAL_S)

    def _show(self, picture: str) -> None:
        pixels = exr.read(Path(picture))
        height, width, _ = pixels.shape
        result = self.begin_result(0, 0, width, height)
        result.layers[0].passes["Combined"].rect.foreach_set(pixels[::-1].ravel())
        self.end_result(result)
