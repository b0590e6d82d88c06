"""Scenes that are built in Blender, written, read and rendered by pellicle; lights and lenses against Cycles."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import unittest
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import bpy
import numpy as np

from studio import FOLDER, ball, cycles, empty, lamp, material, ours, place, run, sheet, with_nodes, written

NAMES = {"c": "http://www.collada.org/2005/11/COLLADASchema"}
# Largest difference of irradiance to Cycles that passes.
TOLERANCE = 0.01


def base_of(path: str, effect: str) -> ElementTree.Element:
    found = ElementTree.parse(path).find(f".//c:effect[@id='{effect}']/c:extra/c:technique[@profile='pellicle']", NAMES)
    assert found is not None, effect
    # Without the namespace, which our own names do not need.
    for element in found.iter():
        element.tag = element.tag.rpartition("}")[2]
    return found[0]


def numbers(text: str | None) -> list[float]:
    return [float(word) for word in (text or "").split()]


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
            tree.links.new(mapping.outputs[0], tree.nodes["sky"].inputs["Vector"])

        self.check("turned-world", turn)


def sky(scene: bpy.types.Scene) -> None:
    """A smooth environment without a seam."""
    image = bpy.data.images.new("sky", 256, 128, float_buffer=True)
    v, u = np.mgrid[0:128, 0:256]
    texels = np.ones((128, 256, 4), np.float32)
    texels[..., 0] = 0.5 + 0.4 * np.sin(2 * np.pi * u / 256)
    texels[..., 1] = v / 127
    texels[..., 2] = 0.5 + 0.4 * np.cos(2 * np.pi * u / 256)
    image.pixels.foreach_set(texels.ravel())
    image.update()
    tree = scene.world.node_tree
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.name, node.image = "sky", image
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    tree.nodes["Background"].inputs["Strength"].default_value = 1.5


class Lens(unittest.TestCase):
    def test_focus_object_and_f_stop(self):
        scene = empty()
        scene.unit_settings.scale_length = 0.1
        camera = scene.camera.data
        scene.camera.location, scene.camera.rotation_euler = (0, -4, 1), (math.radians(90.0), 0, 0)
        camera.lens, camera.dof.use_dof, camera.dof.aperture_fstop, camera.dof.aperture_blades = 80.0, True, 2.0, 6
        camera.dof.focus_object = ball(0.2, (0.5, 3, 1), None)
        path, _ = written("lens")
        lens = ElementTree.parse(path).find(".//c:lens", NAMES)
        self.assertAlmostEqual(float(lens.get("aperture_radius_m")), 0.080 / (2.0 * 2.0) * 0.1)
        self.assertAlmostEqual(float(lens.get("focus_distance_m")), 7.0 * 0.1, places=5)
        self.assertEqual(lens.get("blades"), "6")


class Materials(unittest.TestCase):
    def setUp(self) -> None:
        self.scene = empty()
        self.scene.camera.location.z = 5.0

    def base(self, made: bpy.types.Material) -> tuple[ElementTree.Element, list[str]]:
        ball(1.0, (0, 0, 0), made)
        path, report = written(made.name)
        run("check", path)
        return base_of(path, made.name), report.notes

    def test_film_on_glass(self):
        inputs = {"Transmission_Weight": 1.0, "IOR": 1.5, "Roughness": 0.0, "Thin_Film_Thickness": 420.0, "Thin_Film_IOR": 1.4}
        base, notes = self.base(material("glass", "BsdfPrincipled", Base_Color=(1, 1, 1), **inputs))
        self.assertEqual((base.tag, base.get("ior"), base.get("roughness")), ("dielectric", "1.5", None))
        self.assertEqual((base[0].get("thickness_nm"), base[0].get("ior")), ("420", "1.4"))
        self.assertEqual(notes, [])

    def test_bubble(self):
        inputs = {"Transmission_Weight": 1.0, "IOR": 1.0, "Roughness": 0.0, "Thin_Film_Thickness": 300.0, "Thin_Film_IOR": 1.33}
        base, _ = self.base(material("bubble", "BsdfPrincipled", Base_Color=(1, 1, 1), **inputs))
        self.assertEqual((base.tag, base.get("ior"), base[0].get("thickness_nm")), ("dielectric", "1", "300"))

    def test_film_on_metal_by_colour(self):
        inputs = {"Metallic": 1.0, "Roughness": 0.3, "Thin_Film_Thickness": 550.0}
        base, _ = self.base(material("gold", "BsdfPrincipled", Base_Color=(0.95, 0.77, 0.34), **inputs))
        self.assertEqual(base.tag, "conductor")
        self.assertAlmostEqual(float(base.get("roughness")), 0.09, places=6)
        self.assertEqual((len(numbers(base.get("eta"))), len(numbers(base.get("k")))), (3, 3))
        self.assertEqual(base[0].get("thickness_nm"), "550")

    def test_metals_have_their_colour(self):
        background = self.scene.world.node_tree.nodes["Background"]
        background.inputs["Strength"].default_value, background.inputs["Color"].default_value = 1.0, (1, 1, 1, 1)
        self.scene.camera.data.type, self.scene.camera.data.ortho_scale = "ORTHO", 0.1
        for colour in ((0.95, 0.64, 0.54), (0.9, 0.75, 0.4), (0.6, 0.6, 0.65)):
            ball(1.0, (0, 0, 0), material("metal", "BsdfPrincipled", Metallic=1.0, Roughness=0.0, Base_Color=colour))
            for mode in ("rgb", "spectral"):
                found = ours("metal", "--mode", mode, "--spp", "64").mean(axis=(0, 1))
                self.assertLess(np.abs(found - colour).max(), 0.02, (mode, found))
            bpy.data.objects.remove(bpy.context.object)
            bpy.data.materials.remove(bpy.data.materials["metal"])

    def test_metal_by_index(self):
        values = {"IOR": (0.2, 0.9, 1.2), "Extinction": (3.9, 2.4, 2.3), "Roughness": 0.0}
        base, notes = self.base(material("copper", "BsdfMetallic", fresnel_type="PHYSICAL_CONDUCTOR", **values))
        self.assertTrue(np.allclose(numbers(base.get("eta")), values["IOR"]))
        self.assertTrue(np.allclose(numbers(base.get("k")), values["Extinction"]))
        self.assertEqual(notes, [])

    def test_tinted_glass_absorbs_by_its_mean_chord(self):
        base, notes = self.base(material("bottle", "BsdfGlass", Color=(0.25, 0.5, 1.0), Roughness=0.0))
        # The mean chord of a sphere is 4/3 of its radius; Cycles tints at both crossings.
        found = numbers(base.get("absorption_per_m"))
        for value, tint in zip(found, (0.25, 0.5, 1.0)):
            self.assertAlmostEqual(value, -2.0 * math.log(tint) / (4.0 / 3.0), delta=0.02)
        self.assertEqual(len(notes), 1)

    def test_what_is_not_translated_is_said_by_name(self):
        made = material("odd", "BsdfPrincipled", Metallic=0.4, Anisotropic=0.5, Sheen_Weight=1.0, Roughness=0.5)
        tree = made.node_tree
        noise = tree.nodes.new("ShaderNodeTexVoronoi")
        tree.links.new(noise.outputs["Color"], tree.nodes["shader"].inputs["Base Color"])
        bump = tree.nodes.new("ShaderNodeBump")
        tree.links.new(bump.outputs[0], tree.nodes["shader"].inputs["Normal"])
        _, notes = self.base(made)
        text = "\n".join(notes)
        for expected in ("Metallic", "Anisotropic", "Sheen Weight", "Voronoi", "Bump"):
            self.assertIn(expected, text)
        self.assertTrue(all("`odd`" in line for line in notes), notes)

    def test_groups_reroutes_and_alpha(self):
        made = material("grouped", "BsdfDiffuse")
        group = bpy.data.node_groups.new("inner", "ShaderNodeTree")
        group.interface.new_socket("Tint", in_out="INPUT", socket_type="NodeSocketColor")
        group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
        start, end, inside = (group.nodes.new(kind) for kind in ("NodeGroupInput", "NodeGroupOutput", "ShaderNodeBsdfDiffuse"))
        group.links.new(start.outputs[0], inside.inputs["Color"])
        group.links.new(inside.outputs[0], end.inputs[0])
        tree = made.node_tree
        tree.nodes.remove(tree.nodes["shader"])
        node, clear, mix, knot = (
            tree.nodes.new(kind) for kind in ("ShaderNodeGroup", "ShaderNodeBsdfTransparent", "ShaderNodeMixShader", "NodeReroute")
        )
        node.node_tree = group
        node.inputs["Tint"].default_value = (0.1, 0.2, 0.3, 1.0)
        mix.inputs[0].default_value = 0.75
        output = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeOutputMaterial")
        for source, target in ((node, knot), (clear, mix), (knot, None), (mix, output)):
            into = mix.inputs[2] if target is None else mix.inputs[1] if target is mix else target.inputs[0]
            tree.links.new(source.outputs[0], into)
        base, notes = self.base(made)
        self.assertTrue(np.allclose(numbers(base.get("reflectance")), (0.1, 0.2, 0.3)))
        self.assertAlmostEqual(float(base.find("opacity").get("value")), 0.75)
        self.assertEqual(notes, [])


class Textures(unittest.TestCase):
    def setUp(self) -> None:
        self.scene = empty(32, 32)
        self.scene.camera.location.z = 3.0
        self.scene.camera.data.type, self.scene.camera.data.ortho_scale = "ORTHO", 2.0
        lamp("SUN", energy=math.pi, angle=0.0)

    def image(self, name: str, texels: np.ndarray, space: str) -> bpy.types.Image:
        rows, columns, _ = texels.shape
        image = bpy.data.images.new(name, columns, rows)
        image.colorspace_settings.name = space
        image.pixels.foreach_set(np.concatenate([texels, np.ones((rows, columns, 1))], 2).astype(np.float32).ravel())
        image.update()
        image.pack()
        return image

    def test_packed_colour_by_a_second_uv_map_turned_by_a_mapping(self):
        v, u = np.mgrid[0:64, 0:64] / 63.0
        made = material("painted", "BsdfDiffuse")
        tree = made.node_tree
        texture, mapping, layer = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexImage", "Mapping", "UVMap"))
        texture.image = self.image("paint", np.stack([u, v, 0.5 + 0 * u], 2), "sRGB")
        texture.extension = "EXTEND"
        layer.uv_map = "second"
        mapping.inputs["Rotation"].default_value = (0.0, 0.0, 0.5)
        mapping.inputs["Scale"].default_value = (0.5, 0.5, 1.0)
        mapping.inputs["Location"].default_value = (0.3, 0.1, 0.0)
        tree.links.new(layer.outputs[0], mapping.inputs[0])
        tree.links.new(mapping.outputs[0], texture.inputs[0])
        tree.links.new(texture.outputs[0], tree.nodes["shader"].inputs["Color"])
        plane = sheet(2.0, (0, 0, 0), made)
        second = plane.data.uv_layers.new(name="second")
        for corner in second.uv:
            corner.vector = (1.0 - corner.vector.y, corner.vector.x)
        reference, found = cycles("painted"), ours("painted", "--spp", "64", "--mode", "rgb")
        self.assertGreater(np.ptp(reference[:, :, 0]), 0.1)
        self.assertLess(np.abs(reference - found).max(), 0.01)

    def test_film_thickness_from_an_image(self):
        made = material("mapped", "BsdfPrincipled", Base_Color=(1, 1, 1), Transmission_Weight=1.0, Roughness=0.0, IOR=1.5)
        tree = made.node_tree
        texture, scale = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeMapRange")
        ramp = np.repeat(np.linspace(0.0, 1.0, 64)[None, :, None], 3, axis=2).repeat(8, axis=0)
        texture.image = self.image("ramp", ramp, "Non-Color")
        scale.inputs["To Min"].default_value, scale.inputs["To Max"].default_value = 100.0, 600.0
        tree.links.new(texture.outputs[0], scale.inputs["Value"])
        tree.links.new(scale.outputs[0], tree.nodes["shader"].inputs["Thin Film Thickness"])
        sheet(2.0, (0, 0, 0), made)
        path, _ = written("mapped")
        chart = base_of(path, "mapped").find("film/map")
        self.assertAlmostEqual(float(chart.get("min_nm")), 100.0, delta=1.0)
        self.assertAlmostEqual(float(chart.get("max_nm")), 600.0, delta=1.0)
        picture = path.replace(".dae", ".exr")
        run("render", path, "-o", picture, "-q", "--aov", "film", "--spp", "4")


class Command(unittest.TestCase):
    def test_a_blend_file_is_written_without_a_window(self):
        empty(24, 16)
        ball(0.5, (0, 0, -3), None)
        blend, path = str(FOLDER / "saved.blend"), str(FOLDER / "saved.dae")
        bpy.ops.wm.save_as_mainfile(filepath=blend)
        script = str(Path(__file__).parents[1] / "export.py")
        done = subprocess.run([sys.executable, script, blend, path], capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("2 nodes, 1 meshes", done.stdout)
        run("check", path)
        done = subprocess.run([sys.executable, script, blend, "/nowhere/a.dae"], capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 1)
        self.assertIn("/nowhere/a.dae", done.stderr)


class Placement(unittest.TestCase):
    def test_instances_share_meshes(self):
        empty()
        first = ball(0.2, (0, 0, 0.3), None)
        place(first.data, (0.5, 0, 0.3), name="twin")
        collection = bpy.data.collections.new("set")
        collection.objects.link(first)
        holder = place(None, (0, 1, 0), name="holder")
        holder.instance_type, holder.instance_collection = "COLLECTION", collection
        path, report = written("placed")
        self.assertEqual((report.meshes, report.nodes), (1, 4))
        found = run("check", path)
        self.assertIn("placed 3x", found)
        # Blender's z is the world's y.
        nodes = ElementTree.parse(path).findall(".//c:node[@name='ball']/c:matrix", NAMES)
        places = sorted([numbers(node.text)[column] for column in (3, 7, 11)] for node in nodes)
        self.assertTrue(np.allclose(places, [[0, 0, 0.3], [0, 1, 0.3]]), places)

    def test_modifiers_count_at_render_level(self):
        empty()
        bpy.ops.mesh.primitive_cube_add()
        modifier = bpy.context.object.modifiers.new("smooth", "SUBSURF")
        modifier.levels, modifier.render_levels = 1, 3
        hidden = ball(1.0, (3, 0, 0), None)
        hidden.hide_render = True
        _, report = written("modified")
        self.assertEqual((report.meshes, report.triangles), (1, 6 * 4**3 * 2))

    def test_sharp_edges_stay_sharp(self):
        empty()
        bpy.ops.mesh.primitive_cube_add()
        data = bpy.context.object.data
        data.shade_smooth()
        path, _ = written("round-cube")
        count = lambda: ElementTree.parse(path).find(".//c:mesh/c:source[2]/c:float_array", NAMES).get("count")  # noqa: E731
        self.assertEqual(count(), "24")
        data.edges[0].use_edge_sharp = True
        data.shade_flat()
        written("round-cube")
        self.assertEqual(count(), "18")

    def test_missing_camera_is_an_error_that_helps(self):
        from pellicle.exporter import ExportError

        scene = empty()
        scene.camera = None
        with self.assertRaisesRegex(ExportError, "has no camera"):
            written("none")


class Time(unittest.TestCase):
    def test_what_moves_gets_keys_at_every_frame(self):
        scene = empty()
        scene.frame_end, scene.render.fps = 5, 25
        scene.camera.location.z = 5.0
        moving = ball(0.5, (0, 0, 0), material("film", "BsdfPrincipled", Transmission_Weight=1.0, Base_Color=(1, 1, 1)))
        light = lamp("POINT", energy=100.0).data
        thickness = moving.active_material.node_tree.nodes["shader"].inputs["Thin Film Thickness"]
        for frame, value in ((1, 0.0), (5, 400.0)):
            moving.location.x, light.energy, scene.camera.data.lens = value / 200.0, 100.0 + value, 40.0 + value / 20.0
            thickness.default_value = value
            for owner, name in ((moving, "location"), (light, "energy"), (scene.camera.data, "lens"), (thickness, "default_value")):
                owner.keyframe_insert(name, frame=frame)
        scene.frame_set(3)
        path, report = written("moving", animation=True)
        self.assertEqual(report.notes, [])
        self.assertEqual(scene.frame_current, 3)
        keys = {}
        root = ElementTree.parse(path)
        for element in root.iterfind(".//c:animation", NAMES):
            target = element.find("c:channel", NAMES).get("target")
            times, values = (numbers(array.text) for array in list(element.iterfind(".//c:float_array", NAMES))[:2])
            keys[target] = (times, values)
        self.assertEqual(
            set(keys), {"ball/transform", "film/film/thickness_nm", "point-light/color", "camera-camera/xfov", "camera-camera/yfov"}
        )
        self.assertTrue(np.allclose(keys["film/film/thickness_nm"][0], [frame / 25.0 for frame in range(1, 6)]))
        # What Blender itself has at each frame.
        for number, frame in enumerate(range(1, 6)):
            scene.frame_set(frame)
            self.assertAlmostEqual(keys["ball/transform"][1][16 * number + 3], moving.matrix_world.translation.x, places=5)
            self.assertAlmostEqual(keys["film/film/thickness_nm"][1][number], thickness.default_value, delta=1e-3)
            self.assertAlmostEqual(keys["point-light/color"][1][3 * number], light.energy / (4.0 * math.pi), places=4)
            xfov = math.degrees(2.0 * math.atan(18.0 / scene.camera.data.lens))
            self.assertAlmostEqual(keys["camera-camera/xfov"][1][number], xfov, places=4)
        self.assertIn("animation: 5 channels, 0.040 to 0.200 s", run("check", path))


class Engine(unittest.TestCase):
    def test_blender_renders_by_pellicle(self):
        scene = empty(24, 16)
        scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.5
        scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.4, 0.8, 1.0)
        scene.render.engine = "PELLICLE"
        scene.pellicle.samples = 4
        found = cycles("engine")
        self.assertEqual(found.shape, (16, 24, 3))
        self.assertTrue(np.allclose(found, (0.1, 0.2, 0.4), atol=1e-3), found.mean(axis=(0, 1)))

    def test_a_missing_program_is_said(self):
        scene = empty(24, 16)
        scene.render.engine = "PELLICLE"
        path, os.environ["PATH"] = os.environ["PATH"], "/nowhere"
        try:
            with self.assertRaisesRegex(RuntimeError, "not on PATH"):
                cycles("missing")
            with self.assertRaisesRegex(RuntimeError, "not on PATH"):
                bpy.ops.render.pellicle()
        finally:
            os.environ["PATH"] = path

    def test_the_operator_loads_the_picture(self):
        scene = empty(24, 16)
        scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 1.0
        scene.pellicle.samples = 4
        self.assertEqual(bpy.ops.render.pellicle(), {"FINISHED"})
        image = bpy.data.images["pellicle"]
        self.assertEqual(tuple(image.size), (24, 16))
        self.assertGreater(min(image.pixels[:3]), 0.01)
        self.assertEqual(scene.render.engine, "CYCLES")

    def test_the_menu_writes_a_file(self):
        scene = empty()
        path, _ = written("menu")
        os.remove(path)
        self.assertEqual(bpy.ops.export_scene.pellicle(filepath=path), {"FINISHED"})
        run("check", path)
        self.assertEqual(scene.render.engine, "CYCLES")


if __name__ == "__main__":
    print(f"Blender {bpy.app.version_string}")
    passed = unittest.main(exit=False, verbosity=1).result.wasSuccessful()
    sys.stdout.flush()
    # Blender as a module may hang while Python takes it apart.
    os._exit(0 if passed else 1)
