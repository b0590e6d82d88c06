"""Lights, worlds and cameras against Cycles, pixel by pixel."""

from __future__ import annotations

import math
import unittest
from collections.abc import Callable

import bpy
import numpy as np

from studio import ball, cycles, element, empty, finish, lamp, material, ours, sheet, texture, written

# Largest difference of irradiance to Cycles that passes.
TOLERANCE = 0.01


class Lights(unittest.TestCase):
    """A white matte plane under each kind of light: what it reflects, pixel by pixel."""

    def check(self, name: str, prepare: Callable[[], object], mean_only: bool = False) -> None:
        scene = empty()
        sheet(4.0, (0, 0, 0), material("white", "BsdfDiffuse", Color=(1, 1, 1)))
        scene.camera.location.z = 1.0
        scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 1.0
        prepare()
        reference, found = cycles(name), ours(name, "--spp", "256", "--mode", "rgb")
        self.assertGreater(reference.mean(), 0.01)
        ratio = found.mean(axis=(0, 1)) / reference.mean(axis=(0, 1))
        print(f"{name}: {ratio.round(5)} of Cycles")
        self.assertLess(np.abs(ratio - 1.0).max(), TOLERANCE, name)
        if not mean_only:
            self.assertLess(np.abs(found / reference - 1.0).mean(), TOLERANCE, name)

    def test_point(self):
        self.check("point", lambda: lamp("POINT", energy=100.0, color=(1.0, 0.5, 0.25), shadow_soft_size=0.0))

    def test_sphere(self):
        self.check("sphere", lambda: lamp("POINT", energy=100.0, shadow_soft_size=0.3, use_soft_falloff=False))

    def test_sun(self):
        self.check("sun", lambda: lamp("SUN", energy=3.0, angle=0.0, rotation=(0.3, 0.2, 0.0)))

    def test_wide_sun(self):
        self.check("wide-sun", lambda: lamp("SUN", energy=3.0, angle=0.3, rotation=(0.5, 0.2, 0.0)))

    def test_spot(self):
        self.check("spot", lambda: lamp("SPOT", energy=100.0, spot_size=1.0, spot_blend=0.5, shadow_soft_size=0.0))

    def test_areas(self):
        for shape in ("SQUARE", "RECTANGLE", "DISK", "ELLIPSE"):

            def area(shape: str = shape) -> None:
                entity = lamp("AREA", energy=100.0, shape=shape, size=0.5, size_y=0.8, rotation=(0.2, 0.1, 0.4))
                entity.scale = (1.5, 1.0, 1.0)

            self.check(f"area-{shape.lower()}", area)

    def test_centimetres(self):
        def small() -> None:
            bpy.context.scene.unit_settings.scale_length = 0.01
            lamp("POINT", energy=100.0, shadow_soft_size=0.0)

        self.check("centimetres", small)

    def test_shining_mesh(self):
        def square() -> None:
            sheet(1.0, (0, 0, 2), material("shining", "Emission", Color=(1.0, 0.5, 0.25), Strength=5.0))

        self.check("shining-mesh", square, mean_only=True)

    def test_constant_world(self):
        def grey() -> None:
            background = bpy.context.scene.world.node_tree.nodes["Background"]
            background.inputs["Color"].default_value = (1.0, 0.5, 0.2, 1.0)
            background.inputs["Strength"].default_value = 0.7

        self.check("world", grey)


class Views(unittest.TestCase):
    """What the camera sees of a world that has another colour in every direction."""

    def check(self, name: str, prepare: Callable[[bpy.types.Scene], object], size: tuple[int, int] = (48, 32)) -> None:
        scene = empty(*size, samples=16)
        sky(scene)
        scene.camera.rotation_euler = (math.radians(80.0), 0.0, 0.5)
        prepare(scene)
        reference, found = cycles(name), ours(name, "--spp", "64", "--mode", "rgb")
        self.assertEqual(reference.shape, found.shape)
        self.assertLess(np.abs(reference - found).max(), 0.02, name)

    def test_landscape(self):
        self.check("landscape", lambda scene: None)

    def test_portrait_with_shift(self):
        def shift(scene: bpy.types.Scene) -> None:
            scene.camera.data.shift_x, scene.camera.data.shift_y = 0.1, -0.2

        self.check("portrait", shift, (32, 48))

    def test_vertical_fit_and_wide_pixels(self):
        def wide(scene: bpy.types.Scene) -> None:
            scene.camera.data.sensor_fit = "VERTICAL"
            scene.camera.data.shift_x = 0.1
            scene.render.pixel_aspect_x = 2.0

        self.check("wide-pixels", wide)

    def test_turned_world(self):
        def turn(scene: bpy.types.Scene) -> None:
            tree = scene.world.node_tree
            mapping = tree.nodes.new("ShaderNodeMapping")
            mapping.inputs["Rotation"].default_value = (0.0, 0.0, 0.7)
            coordinates = tree.nodes.new("ShaderNodeTexCoord")
            tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
            tree.links.new(mapping.outputs[0], tree.nodes["panorama"].inputs["Vector"])

        self.check("turned-world", turn)


def sky(scene: bpy.types.Scene) -> None:
    """A smooth environment without a seam."""
    v, u = np.mgrid[0:128, 0:256]
    texels = np.ones((128, 256, 4), np.float32)
    texels[..., 0] = 0.5 + 0.4 * np.sin(2 * np.pi * u / 256)
    texels[..., 1] = v / 127
    texels[..., 2] = 0.5 + 0.4 * np.cos(2 * np.pi * u / 256)
    texture(scene, texels, 1.5)


class Lens(unittest.TestCase):
    def test_focus_object_and_f_stop(self):
        scene = empty()
        scene.unit_settings.scale_length = 0.1
        camera = scene.camera.data
        scene.camera.location, scene.camera.rotation_euler = (0, -4, 1), (math.radians(90.0), 0, 0)
        camera.lens, camera.dof.use_dof, camera.dof.aperture_fstop, camera.dof.aperture_blades = 80.0, True, 2.0, 6
        camera.dof.focus_object = ball(0.2, (0.5, 3, 1), None)
        path, _ = written("lens")
        lens = element(path, ".//c:lens")
        self.assertAlmostEqual(float(lens.get("aperture_radius_m")), 0.080 / (2.0 * 2.0) * 0.1)
        self.assertAlmostEqual(float(lens.get("focus_distance_m")), 7.0 * 0.1, places=5)
        self.assertEqual(lens.get("blades"), "6")


if __name__ == "__main__":
    finish()
