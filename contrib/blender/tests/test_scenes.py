"""What is placed, what moves, and the add-on's ways to write and to render."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import unittest
from pathlib import Path
from xml.etree import ElementTree

import bpy
import numpy as np

from studio import FOLDER, NAMES, ball, cycles, element, empty, finish, lamp, material, numbers, place, run, written


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

    def test_curves_text_and_metaballs_are_meshes(self):
        empty()
        text = bpy.data.curves.new("text", "FONT")
        text.body = "n"
        place(text)
        bpy.ops.object.metaball_add(type="BALL", location=(3, 0, 0))
        bpy.ops.surface.primitive_nurbs_surface_sphere_add(location=(6, 0, 0))
        _, report = written("curved")
        self.assertEqual((report.meshes, report.nodes, report.notes), (3, 4, []))

    def test_sharp_edges_stay_sharp(self):
        empty()
        bpy.ops.mesh.primitive_cube_add()
        data = bpy.context.object.data
        data.shade_smooth()
        path, _ = written("round-cube")
        count = lambda: element(path, ".//c:mesh/c:source[2]/c:float_array").get("count")  # noqa: E731
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
            animated = ((moving, "location"), (light, "energy"), (scene.camera.data, "lens"), (thickness, "default_value"))
            for owner, name in animated:
                owner.keyframe_insert(name, frame=frame)
        scene.frame_set(3)
        path, report = written("moving", animation=True)
        self.assertEqual(report.notes, [])
        self.assertEqual(scene.frame_current, 3)
        keys = {}
        root = ElementTree.parse(path)
        for channel in root.iterfind(".//c:animation", NAMES):
            target = channel.find("c:channel", NAMES).get("target")
            times, values = (numbers(array.text) for array in list(channel.iterfind(".//c:float_array", NAMES))[:2])
            keys[target] = (times, values)
        camera = {"camera-camera/xfov", "camera-camera/yfov"}
        self.assertEqual(set(keys), {"ball/transform", "film/film/thickness_nm", "point-light/color"} | camera)
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


    def test_what_changes_its_form_or_comes_later_is_said(self):
        scene = empty()
        scene.frame_end = 3
        waving, late = ball(0.5, (0, 0, -4), None, "waving"), ball(0.5, (1, 0, -4), None, "late")
        waving.modifiers.new("wave", "WAVE")
        for frame, hidden in ((1, True), (2, False)):
            late.hide_render = hidden
            late.keyframe_insert("hide_render", frame=frame)
        _, report = written("changing", animation=True)
        self.assertEqual(report.nodes, 2)
        text = "\n".join(report.notes)
        self.assertIn("changes its form", text)
        self.assertIn("`late`: is not there in the first frame", text)


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
    finish()
