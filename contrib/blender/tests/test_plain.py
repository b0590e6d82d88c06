"""What needs neither Blender nor NumPy: ids, metals, watts, the program's messages."""

from __future__ import annotations

import math
import sys
import types
import unittest
from pathlib import Path

# The package itself imports Blender; its parts do not.
_package = types.ModuleType("pellicle")
_package.__path__ = [str(Path(__file__).parents[1] / "pellicle")]
sys.modules.setdefault("pellicle", _package)

from pellicle import metal, program, watts  # noqa: E402
from pellicle.names import Names, legal  # noqa: E402
from pellicle.notes import Notes  # noqa: E402


class Ids(unittest.TestCase):
    def test_ids_are_legal_unique_and_stay(self):
        names = Names()
        self.assertEqual(legal("1 a/ß.001"), "_1_a_ß_001")
        self.assertEqual([names.of("x", "a b"), names.of("y", "a.b"), names.of("x", "other")], ["a_b", "a_b_2", "a_b"])

    def test_notes_are_said_once(self):
        notes = Notes()
        for _ in range(2):
            notes.add("light `a`", "is left out")
        self.assertEqual(notes.lines(), ["light `a`: is left out"])


class Metals(unittest.TestCase):
    def test_colours_come_back_from_the_index(self):
        for f0 in (0.05, 0.3, 0.56, 0.77, 0.92, 0.97):
            f82 = metal.schlick(f0, metal.COS_82)
            n, k = metal.index(f0, f82)
            self.assertAlmostEqual(metal.reflectance(n, k, 1.0), f0, places=6)
            self.assertLess(abs(metal.reflectance(n, k, metal.COS_82) - f82), 0.011, f0)

    def test_gold_is_found_from_its_colour(self):
        # Green of gold: n = 0.43, k = 2.46 at 549 nm reflects 0.77.
        f0 = metal.reflectance(0.4283, 2.4599, 1.0)
        n, k = metal.index(f0, metal.reflectance(0.4283, 2.4599, metal.COS_82))
        self.assertLess(abs(n - 0.43), 0.06)
        self.assertLess(abs(k - 2.46), 0.15)

    def test_fresnel_at_known_places(self):
        self.assertAlmostEqual(metal.reflectance(1.5, 0.0, 1.0), 0.04)
        self.assertAlmostEqual(metal.index_of_dielectric(0.04), 1.5)
        brewster = math.cos(math.atan(1.5))
        self.assertAlmostEqual(metal.reflectance(1.5, 0.0, brewster), 0.0739645, places=6)


class Watts(unittest.TestCase):
    def test_a_sphere_and_a_point_shine_alike(self):
        self.assertAlmostEqual(watts.sphere_radiance(10.0, 0.3) * math.pi * 0.3**2, watts.point_intensity(10.0))
        self.assertAlmostEqual(watts.disc_area(2.0, 2.0), math.pi)
        self.assertAlmostEqual(watts.aperture_radius(50.0, 2.0), 0.0125)


class Program(unittest.TestCase):
    def test_progress_lines_are_told_from_messages(self):
        line = '{"done":0.2500,"spp":8.0,"noise":0.1,"elapsed_s":1.0,"left_s":3.0}'
        self.assertEqual(program.parse(line)["done"], 0.25)
        for other in ("mode: rgb", "{broken", '{"other": 1}'):
            self.assertIsNone(program.parse(other))

    def test_a_run_is_heard_and_ends(self):
        progress = '{"done":1,"spp":4,"left_s":0}'
        script = f"import sys; print('hello', file=sys.stderr); print({progress!r}, file=sys.stderr); sys.exit(3)"
        run = program.Run([sys.executable, "-c", script])
        self.assertEqual(run.finish(), 3)
        self.assertEqual((run.share, run.messages, run.running()), (1.0, ["hello"], False))

    def test_a_missing_program_is_an_error_that_helps(self):
        with self.assertRaisesRegex(program.ProgramMissing, "preferences"):
            program.find("/nowhere/pellicle")


if __name__ == "__main__":
    unittest.main()
