"""One scene by Cycles and by pellicle, side by side, with the numbers of docs/blender.md:

    PELLICLE_PROGRAM=pellicle python3 contrib/blender/tests/comparison.py docs/blender.png

with a Python that has bpy. Without a picture it compares films alone, on flat sheets.
"""

from __future__ import annotations

import json
import math
import os
import sys
import time
from pathlib import Path

import bpy
import numpy as np

from studio import ball, cycles, empty, lamp, material, ours, pixels, run, sheet, texture, written

SIZE = (480, 270)
SAMPLES = int(os.environ.get("SAMPLES", "256"))
ANGLES_DEG = (20, 60, 80)
BALLS: list[tuple[str, bpy.types.Object]] = []
GOLD = {"fresnel_type": "PHYSICAL_CONDUCTOR", "IOR": (0.143, 0.375, 1.442), "Extinction": (3.983, 2.386, 1.603)}
TITANIUM = {"fresnel_type": "PHYSICAL_CONDUCTOR", "IOR": (2.75, 2.54, 2.27), "Extinction": (3.79, 3.43, 3.04)}
COPPER = {"Base_Color": (0.955, 0.638, 0.538), "Metallic": 1.0}


def build() -> bpy.types.Scene:
    scene = empty(*SIZE, samples=SAMPLES)
    scene.cycles.max_bounces = 16
    scene.cycles.transmission_bounces = scene.cycles.glossy_bounces = scene.cycles.diffuse_bounces = 16
    scene.cycles.caustics_reflective = scene.cycles.caustics_refractive = True
    scene.cycles.blur_glossy = 0.0
    surfaces = {
        "film on gold": film("BsdfMetallic", 550.0, 1.33, **GOLD, Roughness=0.15),
        "film on glass": film("BsdfGlass", 400.0, 2.2, Color=(1, 1, 1), Roughness=0.0, IOR=1.5),
        "metal by colour": material("copper", "BsdfPrincipled", **COPPER, Roughness=0.3),
        "matte": material("matte", "BsdfDiffuse", Color=(0.2, 0.4, 0.7)),
        "film on titanium": film("BsdfMetallic", 120.0, 2.4, **TITANIUM, Roughness=0.25),
    }
    for number, (name, surface) in enumerate(surfaces.items()):
        BALLS.append((name, ball(0.45, (number - 2.0, -0.9 + 0.45 * number, 0.45), surface, name)))
    sheet(80.0, (0, 0, 0), material("floor", "BsdfDiffuse", Color=(0.6, 0.6, 0.6)))
    window = {"energy": 120.0, "shape": "RECTANGLE", "size": 1.5, "size_y": 1.0}
    lamp("AREA", (-2.0, -1.5, 3.0), (math.radians(30), math.radians(-25), 0), **window)
    lamp("SUN", (0, 0, 5), (math.radians(35), math.radians(30), 0), energy=1.0, angle=math.radians(3.0))
    sky(scene)
    camera = scene.camera
    camera.location, camera.rotation_euler = (0.0, -6.0, 1.7), (math.radians(78.0), 0.0, 0.0)
    camera.data.lens, camera.data.dof.use_dof, camera.data.dof.aperture_fstop = 38.0, True, 0.5
    camera.data.dof.focus_object = BALLS[2][1]
    return scene


def film(shader: str, thickness_nm: float, ior: float, **inputs: object) -> bpy.types.Material:
    return material("film", shader, Thin_Film_Thickness=thickness_nm, Thin_Film_IOR=ior, **inputs)


def films() -> None:
    """Flat smooth sheets under a white upper half of the world: what they reflect at three angles."""
    cases = {
        "bare gold by n, k": lambda: material("gold", "BsdfMetallic", **GOLD, Roughness=0.0),
        "550 nm of 1.33 on it": lambda: film("BsdfMetallic", 550.0, 1.33, **GOLD, Roughness=0.0),
        "120 nm of 2.4 on titanium": lambda: film("BsdfMetallic", 120.0, 2.4, **TITANIUM, Roughness=0.0),
        "copper by colour": lambda: material("copper", "BsdfPrincipled", **COPPER, Roughness=0.0),
        "300 nm of 1.5 on it": lambda: film("BsdfPrincipled", 300.0, 1.5, **COPPER, Roughness=0.0),
        "400 nm of 2.2 on glass": lambda: film("BsdfGlass", 400.0, 2.2, Color=(1, 1, 1), Roughness=0.0, IOR=1.5),
    }
    print("| surface | angle | Cycles | pellicle, RGB | pellicle, spectral |")
    for name, surface in cases.items():
        for angle_deg in ANGLES_DEG:
            scene = empty(16, 16, samples=1024)
            half(scene)
            sheet(4.0, (0, 0, 0), surface())
            angle = math.radians(angle_deg)
            scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 0.05
            scene.camera.rotation_euler = (angle, 0, 0)
            scene.camera.location = (0, -3.0 * math.sin(angle), 3.0 * math.cos(angle))
            rows = [cycles("film"), *(ours("film", "--mode", mode, "--spp", "1024") for mode in ("rgb", "spectral"))]
            print(f"| {name} | {angle_deg} | {' | '.join(triple(row.mean(axis=(0, 1))) for row in rows)} |", flush=True)


def half(scene: bpy.types.Scene) -> None:
    """A world that is white above and black below."""
    texels = np.ones((64, 8, 4), np.float32)
    texels[:32, :, :3] = 0.0
    texture(scene, texels, 1.0)


def triple(values: np.ndarray) -> str:
    return " ".join(f"{value:.3f}" for value in values)


def sky(scene: bpy.types.Scene) -> None:
    """A dusky gradient with a bright window."""
    v = np.linspace(0.0, 1.0, 128)[:, None, None]
    texels = np.ones((128, 256, 4), np.float32)
    texels[..., :3] = (0.25, 0.35, 0.55) + 0.5 * (1.0 - np.maximum(v, 0.5))
    texels[80:100, 150:170, :3] = 8.0
    texture(scene, texels, 0.6)


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


def main() -> None:
    if len(sys.argv) < 2:
        films()
        return
    scene = build()
    began = time.process_time()
    reference = cycles("comparison")
    cycles_s = time.process_time() - began
    path, report = written("comparison")
    print(report.summary(), *report.notes, sep="\n  ")
    picture, stats = path.replace(".dae", ".exr"), path.replace(".dae", ".json")
    run("render", path, "-o", picture, "--float", "-q", "--filter", "box", "--spp", str(SAMPLES), "--stats", stats)
    found, figures = pixels(picture), json.loads(Path(stats).read_text())
    print(f"{SAMPLES} samples: Cycles {cycles_s:.0f} CPU s, pellicle {figures['render_cpu_s']:.0f} CPU s, {figures['mode']}")
    print("| region | Cycles | pellicle | difference |")
    for name, (rows, columns) in regions(scene).items():
        a, b = reference[rows, columns].mean(axis=(0, 1)), found[rows, columns].mean(axis=(0, 1))
        shares = ", ".join(f"{100 * (y / x - 1):+.1f} %" for x, y in zip(a, b))
        print(f"| {name} | {triple(a)} | {triple(b)} | {shares} |")
    print(f"the whole picture: {100 * (found.mean() / reference.mean() - 1.0):+.2f} %")
    side_by_side(sys.argv[1], reference, found)


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
    sys.stdout.flush()
    # Blender as a module may hang while Python takes it apart.
    os._exit(0)
