"""What needs NumPy but not Blender: numbers as text, image files, texture coordinates, channels."""

from __future__ import annotations

import math
import sys
import tempfile
import types
import unittest
import zlib
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import numpy as np

# The package itself imports Blender; its parts do not.
_package = types.ModuleType("pellicle")
_package.__path__ = [str(Path(__file__).parents[1] / "pellicle")]
sys.modules.setdefault("pellicle", _package)

from pellicle import animation, collada, exr, numerals, png  # noqa: E402
from pellicle.notes import Notes  # noqa: E402
from pellicle.texcoord import TexCoord  # noqa: E402


class Numerals(unittest.TestCase):
    def test_every_float_comes_back(self):
        values = np.random.default_rng(1).normal(size=40_000).astype(np.float32) * np.float32(1e3)
        read = np.array(numerals.reals(values).split(), np.float32)
        self.assertTrue(np.array_equal(read, values))
        self.assertEqual(numerals.wholes(np.array([[1, 2], [3, 40]])), "1 2 3 40")


class Images(unittest.TestCase):
    def test_png_holds_sixteen_bits(self):
        pixels = np.linspace(0.0, 1.0, 2 * 3 * 3).reshape(2, 3, 3)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.png"
            png.write(path, pixels)
            data = path.read_bytes()
        begin = data.index(b"IDAT") + 4
        length = int.from_bytes(data[begin - 8 : begin - 4], "big")
        rows = np.frombuffer(zlib.decompress(data[begin : begin + length]), np.uint8).reshape(2, -1)[:, 1:].copy()
        rows[1] += rows[0]
        found = rows.copy().view(">u2").reshape(2, 3, 3) / 65535.0
        self.assertLess(np.abs(found - pixels).max(), 1e-5)

    def test_exr_comes_back_and_is_as_long_as_it_says(self):
        pixels = np.random.default_rng(2).normal(size=(4, 5, 3)).astype(np.float32)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.exr"
            exr.write(path, pixels)
            data, found = path.read_bytes(), exr.read(path)
        # The last line: its number, its length, and 5 times 3 floats.
        self.assertEqual(np.frombuffer(data[-68:-60], "<i4").tolist(), [3, 60])
        self.assertTrue(np.array_equal(found[:, :, :3], pixels))
        self.assertTrue((found[:, :, 3] == 1.0).all())


class TexCoords(unittest.TestCase):
    def test_mapping_scales_turns_and_moves(self):
        turned = TexCoord("UVMap").mapped((0.5, 0.0), math.pi / 2.0, (2.0, 1.0))
        found = turned.apply(np.array([[1.0, 0.0], [0.0, 1.0]]))
        self.assertTrue(np.allclose(found, [[0.5, 2.0], [-0.5, 0.0]]))
        self.assertEqual((TexCoord().name(), TexCoord("a b").name()), ("", "a_b"))
        self.assertFalse(turned.is_plain())


class Channels(unittest.TestCase):
    @staticmethod
    def effect(thickness: float, frequency: float, films: int = 1) -> Element:
        base = Element("conductor", metal="Au", roughness="0.2")
        for _ in range(films):
            film = SubElement(base, "film", ior="1.33", thickness_nm=str(thickness))
            SubElement(film, "noise", amplitude="0.1", frequency=str(frequency))
        return collada.effect("gold", base, (1.0, 1.0, 1.0))

    def test_targets_are_found_by_the_renderers_paths(self):
        found = animation.values(self.effect(300.0, 4.0, 2))
        self.assertEqual(found["gold/film/thickness_nm"], (300.0,))
        self.assertEqual(found["gold/film(1)/noise/amplitude"], (0.1,))
        self.assertNotIn("gold/metal", found)

    def test_what_changes_gets_a_channel_or_a_remark(self):
        notes = Notes()
        frames = [animation.values(self.effect(300.0 + 10.0 * max(frame, 2), 4.0 + frame)) for frame in range(6)]
        [element] = animation.channels(frames, [frame / 24.0 for frame in range(6)], notes)
        channel = element.find("channel")
        self.assertEqual(channel is not None and channel.get("target"), "gold/film/thickness_nm")
        arrays = [array.text for array in element.iter("float_array")]
        # The key between two equal ones is left out.
        self.assertEqual(arrays[1], "320 320 330 340 350")
        self.assertEqual(len(notes.lines()), 1)
        self.assertIn("gold/film/noise/frequency", notes.lines()[0])

    def test_what_comes_and_goes_is_said(self):
        notes = Notes()
        frames = [animation.values(self.effect(300.0, 4.0, films)) for films in (2, 1)]
        self.assertEqual(animation.channels(frames, [0.0, 1.0], notes), [])
        self.assertTrue(any("film(1)" in line for line in notes.lines()))


if __name__ == "__main__":
    unittest.main()
