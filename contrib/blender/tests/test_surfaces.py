"""Materials and their images: what is written of them, and how it looks."""

from __future__ import annotations

import math
import unittest
from xml.etree import ElementTree

import bpy
import numpy as np

from studio import ball, base_of, cycles, empty, finish, lamp, material, numbers, ours, run, sheet, written


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
        kinds = ("ShaderNodeGroup", "ShaderNodeBsdfTransparent", "ShaderNodeMixShader", "NodeReroute")
        node, clear, mix, knot = (tree.nodes.new(kind) for kind in kinds)
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


if __name__ == "__main__":
    finish()
