"""Writes a .blend as a scene for pellicle, without a window:

    blender -b scene.blend --python contrib/blender/export.py -- scene.dae [--animation] [--frame N]
    python3 contrib/blender/export.py scene.blend scene.dae          (with `pip install bpy`)
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))

import pellicle  # noqa: E402
from pellicle.exporter import ExportError, Options, export  # noqa: E402


def main() -> int:
    inside = "--" in sys.argv
    parser = argparse.ArgumentParser(prog="export.py", description="Write a .blend as a scene for pellicle.")
    if not inside:
        parser.add_argument("blend", help="the .blend file")
    parser.add_argument("scene", help="the .dae to write; images go into a folder beside it")
    parser.add_argument("--animation", action="store_true", help="write all frames of the scene")
    parser.add_argument("--frame", type=int, help="the frame to write")
    arguments = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :] if inside else None)
    if not inside:
        bpy.ops.wm.open_mainfile(filepath=arguments.blend)
    if not hasattr(bpy.types.Scene, "pellicle"):
        pellicle.register()
    if arguments.frame is not None:
        bpy.context.scene.frame_set(arguments.frame)
    try:
        report = export(bpy.context.scene, arguments.scene, Options(arguments.animation))
    except (ExportError, OSError) as fault:
        print(f"error: {fault}", file=sys.stderr)
        return 1
    print(report.summary())
    for line in report.notes:
        print(f"  {line}")
    return 0


if __name__ == "__main__":
    status = main()
    if bpy.app.module:
        # Blender as a module may hang while Python takes it apart.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)
    sys.exit(status)
