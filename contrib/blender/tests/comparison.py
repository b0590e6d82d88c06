"""One scene by Cycles and by pellicle, side by side, with the numbers of docs/blender.md:

    PELLICLE_PROGRAM=pellicle python3 contrib/blender/tests/comparison.py docs/blender.png     (a Python with bpy)
"""

from __future__ import annotations

import math
import os
import sys
import time
from pathlib import Path

import bpy
import numpy as np

from studio import FOLDER, ball, cycles, empty, lamp, material, pixels, place, run, sheet, with_nodes, written

SIZE = (480, 270)
SAMPLES = int(os.environ.get("SAMPLES", "1024"))
# The balls from left to right: name, column and row of the middle in shares of the picture, found from the camera.
BALLS: list[tuple[str, bpy.types.Object]] = []


def build() -> bpy.types.Scene:
    scene = empty(*SIZE, samples=SAMPLES)
    scene.cycles.max_bounces = 16
    scene.cycles.transmission_bounces = scene.cycles.glossy_bounces = scene.cycles.diffuse_bounces = 16
    scene.cycles.caustics_reflective = scene.cycles.caustics_refractive = True
    scene.cycles.blur_glossy = 0.0
    surfaces = {
        "film on gold": material(
            "gold", "BsdfMetallic", fresnel_type="PHYSICAL_CONDUCTOR", IOR=(0.143, 0.375, 1.442), Extinction=(3.983, 2.386, 1.603),
            Roughness=0.15, Thin_Film_Thickness=550.0, Thin_Film_IOR=1.33,
        ),
        "film on glass": material("glass", "BsdfGlass", Color=(1, 1, 1), Roughness=0.0, IOR=1.5, Thin_Film_Thickness=400.0, Thin_Film_IOR=2.2),
        "metal by colour": material("copper", "BsdfPrincipled", Base_Color=(0.955, 0.638, 0.538), Metallic=1.0, Roughness=0.3),
        "matte": material("matte", "BsdfDiffuse", Color=(0.2, 0.4, 0.7)),
        "film on titanium": material(
            "titanium", "BsdfMetallic", fresnel_type="PHYSICAL_CONDUCTOR", IOR=(2.75, 2.54, 2.27), Extinction=(3.79, 3.43, 3.04),
            Roughness=0.25, Thin_Film_Thickness=120.0, Thin_Film_IOR=2.4,
        ),
    }  # fmt: skip
    for number, (name, surface) in enumerate(surfaces.items()):
        BALLS.append((name, ball(0.45, (number - 2.0, 0.25 * (number % 2), 0.45), surface, name)))
    sheet(12.0, (0, 0, 0), material("floor", "BsdfDiffuse", Color=(0.6, 0.6, 0.6)))
    lamp("AREA", (-2.0, -1.5, 3.0), (math.radians(30), math.radians(-25), 0), energy=120.0, shape="RECTANGLE", size=1.5, size_y=1.0)
    lamp("SUN", (0, 0, 5), (math.radians(35), math.radians(30), 0), energy=1.0, angle=math.radians(3.0))
    sky(scene)
    camera = scene.camera
    camera.location, camera.rotation_euler = (0.0, -6.0, 1.6), (math.radians(79.0), 0.0, 0.0)
    camera.data.lens, camera.data.dof.use_dof, camera.data.dof.aperture_fstop = 50.0, True, 0.7
    camera.data.dof.focus_object = BALLS[0][1]
    return scene


def sky(scene: bpy.types.Scene) -> None:
    """A dusky gradient with a bright window."""
    v = np.linspace(0.0, 1.0, 128)[:, None, None]
    texels = np.ones((128, 256, 4), np.float32)
    texels[..., :3] = np.where(v > 0.5, (0.25, 0.35, 0.55) + 0.5 * (1.0 - v), 0.1)
    texels[80:100, 150:170, :3] = 8.0
    image = bpy.data.images.new("sky", 256, 128, float_buffer=True)
    image.pixels.foreach_set(texels.ravel())
    image.update()
    tree = with_nodes(scene.world)
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = image
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    tree.nodes["Background"].inputs["Strength"].default_value = 0.6


def regions(scene: bpy.types.Scene) -> dict[str, tuple[slice, slice]]:
    """Squares of pixels within each ball, and some of the rest; the lower row first."""
    from bpy_extras.object_utils import world_to_camera_view

    found = {}
    for name, entity in BALLS:
        where = world_to_camera_view(scene, scene.camera, entity.location)
        found[name] = around(where.x * SIZE[0], where.y * SIZE[1], 22)
    found["floor"] = around(0.5 * SIZE[0], 0.12 * SIZE[1], 22)
    found["sky"] = around(0.5 * SIZE[0], 0.92 * SIZE[1], 15)
    return found


def around(x: float, y: float, half: int) -> tuple[slice, slice]:
    return slice(max(int(y) - half, 0), int(y) + half), slice(max(int(x) - half, 0), int(x) + half)


def main() -> int:
    scene = build()
    began = time.process_time()
    reference = cycles("comparison")
    cycles_s = time.process_time() - began
    path, report = written("comparison")
    print(report.summary(), *report.notes, sep="\n  ")
    picture = path.replace(".dae", ".exr")
    stats = str(FOLDER / "stats.json")
    run("render", path, "-o", picture, "--float", "-q", "--filter", "box", "--spp", str(SAMPLES), "--mode", "auto", "--stats", stats)
    found = pixels(picture)
    print(f"Cycles {cycles_s:.0f} CPU s; {Path(stats).read_text()[:600]}")
    print("| region | Cycles | pellicle | difference |")
    for name, (rows, columns) in regions(scene).items():
        a, b = reference[rows, columns].mean(axis=(0, 1)), found[rows, columns].mean(axis=(0, 1))
        shares = ", ".join(f"{100 * (y / x - 1):+.1f} %" for x, y in zip(a, b))
        triple = lambda values: " ".join(f"{value:.3f}" for value in values)  # noqa: E731
        print(f"| {name} | {triple(a)} | {triple(b)} | {shares} |")
    whole = found.mean() / reference.mean() - 1.0
    print(f"whole picture: {100 * whole:+.2f} % of brightness, mean |difference| {np.abs(found - reference).mean() / reference.mean():.4f}")
    np.savez(FOLDER / "pictures.npz", cycles=reference, pellicle=found)
    side_by_side(sys.argv[1], reference, found)
    sys.stdout.flush()
    os._exit(0)


def side_by_side(path: str, left: np.ndarray, right: np.ndarray) -> None:
    """Both through the same curve, Cycles on the left."""
    gap = np.ones((left.shape[0], 4, 3))
    linear = np.clip(np.concatenate([left, gap, right], axis=1), 0.0, 1.0)
    values = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    rows, columns, _ = values.shape
    image = bpy.data.images.new("both", columns, rows)
    image.pixels.foreach_set(np.concatenate([values, np.ones((rows, columns, 1))], 2).astype(np.float32).ravel())
    image.file_format = "PNG"
    image.save(filepath=os.path.abspath(path))


if __name__ == "__main__":
    main()
