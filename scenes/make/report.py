"""The scenes of docs/report.md, into report/."""

import math

from .collada import FOLDER, Scene, attributes, diffuse, film
from .dragon import dragon
from .meshes import rectangle, smooth

HALF = 27.8


def box(title, walls):
    """Cornell's box, all of one grey."""
    scene = Scene(title)
    white = diffuse(scene, "white", (walls, walls, walls))
    wall = scene.mesh("wall", rectangle(2 * HALF, 2 * HALF))
    for name, *moves in (("floor",), ("ceiling", ("translate", 0, 2 * HALF, 0), ("rotate", 1, 0, 0, 180)),
                         ("back", ("translate", 0, HALF, -HALF), ("rotate", 1, 0, 0, 90)),
                         ("left", ("translate", -HALF, HALF, 0), ("rotate", 0, 0, 1, -90)),
                         ("right", ("translate", HALF, HALF, 0), ("rotate", 0, 0, 1, 90))):
        scene.place(wall, white, *moves, name=name)
    scene.softbox("light", (0, 2 * HALF - 0.1, 0), (0, 0, 0), 20, 16, (9, 9, 9))
    scene.camera((0, HALF, 107.8), (0, HALF, 0), 38, 1)
    return scene


def save(scene, name):
    (FOLDER / "report").mkdir(exist_ok=True)
    scene.save_packed("report/" + name)


def report_dragon():
    scene = box("The coated dragon of the 2020 report: a film of index 1.33 on chromium in a white box. Frames of its animation: "
                      "0 550 nm and varying by 1/40, 1 the same without variation, 2 250 nm, 3 750 nm", 0.73)
    noise = f"<noise{attributes(amplitude=0.025, frequency=2.5)}/>"
    metal = scene.material("metal", (0.9, 0.9, 0.9), f'<conductor metal="Cr" roughness="0.2">{film(550, noise, ior=1.33)}</conductor>')
    scene.steps("metal-fx/film/thickness_nm", (550, 550, 250, 750))
    scene.steps("metal-fx/film/noise/amplitude", (0.025, 0, 0.025, 0.025))
    scene.place(scene.mesh("dragon", dragon(3.8)), metal, ("translate", 0.85, 0, -1.9), ("rotate", 0, 1, 0, 24))
    scene.render(480, 480, spp=128, max_bounces=8, exposure_ev=0.6)
    save(scene, "dragon")


def report_transparent():
    scene = box("Films on transparent things in a dark box: a ring and a ball of glass under 550 nm of soap, and a bubble of "
                "550 nm. Frames of its animation: 0 varying by 1/10, 1 without variation", 0.10)
    soap = film(550, f"<noise{attributes(amplitude=0.1, frequency=0.25, octaves=3)}/>", ior=1.33)
    glass = scene.material("glass", (0.9, 0.9, 0.9), f'<dielectric ior="1.5">{soap}</dielectric>')
    bubble = scene.material("bubble", (0.8, 0.85, 0.9), f'<dielectric ior="1">{soap}</dielectric>')
    for name in ("glass", "bubble"):
        scene.steps(f"{name}-fx/film/noise/amplitude", (0.1, 0))
    turns = lambda n: [2 * math.pi * (i % n) / n for i in range(n + 1)]
    ring = [[((6.2 + 2.6 * math.cos(b)) * math.cos(a), (6.2 + 2.6 * math.cos(b)) * math.sin(a), 2.6 * math.sin(b)) for a in turns(96)]
            for b in [-b for b in turns(48)]]
    scene.place(scene.mesh("ring", smooth(ring)), glass, ("translate", -13, 8.8, -2), ("rotate", 0, 1, 0, 28))
    scene.ball("ball", glass, 7.4, 12, 7.4, 8)
    scene.ball("soap", bubble, 11, 3, 30, -6)
    for name, x in (("left", -1), ("right", 1)):
        scene.softbox(name + "-panel", (26.5 * x, 30, 6), (0, 22, 0), 26, 30, (4.5, 4.5, 4.5))
    scene.render(480, 480, spp=256, max_bounces=16, exposure_ev=0.6)
    save(scene, "transparent")


SCENES = (report_dragon, report_transparent)
