"""The eight small scenes to start from."""

import math
import random

from .collada import FOLDER, Scene, attributes, diffuse, film, png
from .meshes import arc, backdrop, cap, globe, joined, lathe, pebble, pillow, rectangle, smooth
from .vectors import add, cross, mix, noise, scaled, smoothstep, sub, swirled, unit


def knot_point(t, a):
    """A (2, 3) torus knot whose tube is a rope of three strands, wound with fine thread."""
    def spine(t):
        r = 1 + 0.42 * math.cos(3 * t)
        return (r * math.cos(2 * t), r * math.sin(2 * t), 0.52 * math.sin(3 * t))
    centre = spine(t)
    along = unit(sub(spine(t + 1e-4), spine(t - 1e-4)))
    side = unit(cross((math.cos(2 * t), math.sin(2 * t), 0), along))
    up = cross(along, side)
    strands = abs(math.cos(1.5 * a + 18 * t)) ** 0.7
    thread = math.cos(150 * t - 6 * a)
    radius = 0.235 + 0.075 * strands + 0.006 * thread * strands
    return add(centre, add(scaled(side, radius * math.cos(a)), scaled(up, radius * math.sin(a))))


def gold_knot():
    scene = Scene("Gold under a 550 nm film of index 1.33 that varies by 1/40, in a white Cornell box: "
                  "after the coated gold dragon of the 2020 report")
    white = diffuse(scene, "white", (0.73, 0.73, 0.73))
    varying = f"<noise{attributes(amplitude=0.025, frequency=2.5)}/>"
    gold = scene.material("gold", (1, 0.77, 0.34), f'<conductor metal="Au" roughness="0.2">{film(550, varying, ior=1.33)}</conductor>')
    wall = scene.mesh("wall", rectangle(55.6, 55.6))
    half = 27.8
    for name, *moves in (("floor",), ("ceiling", ("translate", 0, 2 * half, 0), ("rotate", 1, 0, 0, 180)),
                         ("back", ("translate", 0, half, -half), ("rotate", 1, 0, 0, 90)),
                         ("left", ("translate", -half, half, 0), ("rotate", 0, 0, 1, -90)),
                         ("right", ("translate", half, half, 0), ("rotate", 0, 0, 1, 90))):
        scene.place(wall, white, *moves, name=name)
    scene.softbox("light", (0, 2 * half - 0.1, 0), (0, 0, 0), 13, 10.5, (15, 15, 15))
    around, along = 40, 720
    rows = [[knot_point(2 * math.pi * (i % along) / along, 2 * math.pi * (j % around) / around) for j in range(around + 1)]
            for i in range(along + 1)]
    knot = scene.mesh("knot", smooth([[scaled(p, 11.5) for p in row] for row in rows]))
    scene.place(knot, gold, ("translate", 0, 16.6, 2), ("rotate", 0, 1, 0, 24), ("rotate", 0, 0, 1, 90))
    scene.camera((0, half, 107.8), (0, half, 0), 38, 1)
    scene.render(480, 480, spp=192, max_bounces=12, exposure_ev=0.8)
    scene.save_packed("gold_knot")


def soap(scene, name, top_nm, bottom_nm, exponent=1.0):
    """A soap film in air that has drained downwards."""
    drained = f"<drain{attributes(top_nm=top_nm, bottom_nm=bottom_nm, exponent=exponent)}/>"
    return scene.material(name, (0.8, 0.85, 0.9), f'<dielectric ior="1">{film(varying=drained, ior=1.33)}</dielectric>')


def stirred_thickness(u, v):
    """Thickness over a bubble: drained, and still swirling from when it was blown; 0..1 of the map's range."""
    turn, polar = 2 * math.pi * u, math.pi * v
    p = (math.sin(polar) * math.cos(turn), -math.cos(polar), math.sin(polar) * math.sin(turn))
    stir = swirled((2.2 * p[0], 3.6 * p[1], 2.2 * p[2]), 0.9, 5, 3)
    fallen = 0.5 - 0.5 * p[1]
    return fallen ** 0.9 + 0.16 * stir * math.sin(math.pi * min(max(fallen, 0), 1)) ** 0.7


def double_bubble(scene, a, b, centre, turn_deg, tilt_deg):
    """Two bubbles of radii a > b with a wall between them; films meet at 120 degrees, as Plateau found."""
    wall = a * b / (a - b)
    apart = math.sqrt(a * a + b * b - a * b)
    plane = (apart * apart + a * a - b * b) / (2 * apart)
    ring = math.sqrt(a * a - plane * plane)
    pose = (("translate", *centre), ("rotate", 0, 1, 0, turn_deg), ("rotate", 0, 0, 1, tilt_deg))
    wall_centre = plane + math.sqrt(wall * wall - ring * ring)
    angle = lambda x, y: math.degrees(math.atan2(y, x))
    parts = (("large", a, 0, angle(-plane, ring), ("rotate", 0, 0, 1, 90), (90, 640)),
             ("small", b, apart, angle(plane - apart, ring), ("rotate", 0, 0, 1, -90), (140, 820)),
             ("wall", wall, wall_centre, angle(wall_centre - plane, ring), ("rotate", 0, 0, 1, 90), (180, 560)))
    for name, radius, x, cap_deg, axis, (top, bottom) in parts:
        mesh = scene.mesh(f"double-{name}", cap(radius, cap_deg, 48, 128))
        scene.place(mesh, soap(scene, f"soap-{name}", top, bottom), *pose, ("translate", x, 0, 0), axis)


def bright_room(u, v):
    """What lies around the bubbles: bright above and behind the camera, a faint glow behind the bubbles, dark below."""
    turn, rise = 2 * math.pi * u, math.pi * (v - 0.5)
    front = -math.cos(turn) * math.cos(rise)  # 1 behind the camera, which looks along -z
    sky = smoothstep(-0.05, 0.75, rise) * mix(0.10, 1, smoothstep(-0.8, 0.7, front))
    glow = math.exp(-9 * (turn - 2 * math.pi * round(u)) ** 2 - 14 * (rise - 0.06) ** 2)
    return 0.006 + 0.9 * sky + 0.028 * glow


def bubbles():
    scene = Scene("Soap bubbles by two windows: drained films in air, thin at the top and thick at the bottom")
    (FOLDER / "bubble_thickness.png").write_bytes(png(512, 256, stirred_thickness))
    swirl = '<map image="bubble_thickness.png" min_nm="60" max_nm="780"/>'
    hero = scene.material("soap-hero", (0.8, 0.85, 0.9), f'<dielectric ior="1">{film(varying=swirl, ior=1.33)}</dielectric>')
    scene.place(scene.mesh("hero", globe(6.4, 112, 56)), hero, ("translate", -4.6, 13.6, 0), ("rotate", 0, 1, 0, 70))
    double_bubble(scene, 4.4, 3.1, (7.4, 11.6, 1.0), -25, 34)
    scene.place(scene.mesh("dome", cap(4.6, 90, 40, 128)), soap(scene, "soap-dome", 100, 900, 1.2), ("translate", 1.6, 0, 3.0))
    free = (("a", 2.3, -13.4, 9.0, 2, 100, 600), ("b", 1.5, 4.4, 19.6, -2, 150, 750), ("c", 1.1, -12.8, 16.9, -3, 120, 520),
            ("d", 2.7, -7.6, 4.6, 2, 80, 700), ("e", 0.8, 13.3, 18.6, 1, 200, 600), ("f", 1.8, 11.6, 4.6, -2, 110, 860))
    for name, radius, x, y, z, top, bottom in free:
        scene.ball(f"bubble-{name}", soap(scene, f"soap-{name}", top, bottom), radius, x, y, z)
    table = diffuse(scene, "table", (0.004, 0.005, 0.007), film(0, ior=1.33), ior=1.33)
    scene.place(scene.mesh("table-top", rectangle(6000, 6000)), table)
    scene.window("window-left", (-75, 42, 50), (0, 10, 0), 64, 70, 2, 3, (7, 7.5, 8.2))
    scene.window("window-right", (95, 40, 12), (0, 12, 0), 46, 64, 2, 3, (4.5, 4.7, 5.2))
    (FOLDER / "bubbles_room.png").write_bytes(png(256, 128, bright_room))
    scene.environment((0.95, 1.03, 1.15), image="bubbles_room.png")
    scene.camera((0, 12.5, 64), (0, 8.9, 0), 33, 1.5, lens='<lens aperture_radius_m="0.007" focus_distance_m="0.625"/>')
    scene.render(720, 480, spp=64, max_bounces=16, exposure_ev=1)
    scene.save("bubbles")


def oil_thickness(u, v):
    """Puddles of oil that thin out towards their rims; 0..1 of the map's range."""
    p = (11 * u, 11 * v, 0.5)
    spread = swirled(p, 0.8, 3, 21)
    stir = swirled(scaled(p, 1.7), 1.4, 4, 57)
    return smoothstep(-0.5, 1.2, spread) * (0.8 + 0.45 * stir)


def asphalt(u, v):
    """Grit of stones between which the tar is dark; sRGB values."""
    grit = noise((420 * u, 420 * v, 0), 3) + 0.6 * noise((190 * u, 190 * v, 0), 4)
    return 0.10 + 0.16 * smoothstep(-0.2, 0.9, grit) + 0.05 * noise((14 * u, 14 * v, 0), 5)


def oil():
    scene = Scene("Oil on a wet road under an overcast sky: a film whose thickness is drawn in a picture")
    (FOLDER / "oil_thickness.png").write_bytes(png(512, 512, oil_thickness))
    (FOLDER / "asphalt.png").write_bytes(png(512, 512, asphalt, bits=8))
    varying = '<map image="oil_thickness.png" min_nm="0" max_nm="900"/>'
    grit = '<map for="reflectance" image="asphalt.png"/>'
    road = scene.material("wet-road", (0.03, 0.03, 0.03), f'<diffuse ior="1.33">{grit}{film(varying=varying, ior=1.47)}</diffuse>')
    scene.place(scene.mesh("road", rectangle(200, 200)), road, ("translate", 0, 0, -60))
    stone = diffuse(scene, "stone", (0.13, 0.125, 0.115))
    scene.place(scene.mesh("kerb", pillow(70, 16, 60, 24)), stone, ("translate", -34, -2, -86), ("rotate", 0, 1, 0, 14))
    scene.place("kerb", stone, ("translate", 37.3, -2.2, -101), ("rotate", 0, 1, 0, 10), name="kerb-2")
    shades = ((0.10, 0.09, 0.085), (0.20, 0.17, 0.14), (0.06, 0.06, 0.065))
    wet = [diffuse(scene, f"pebble-{i}", shade, film(0, ior=1.33), ior=1.33) for i, shade in enumerate(shades)]
    draw = random.Random(5)
    pebbles = ((3.0, 13, -19), (1.7, 17.6, -15.5), (2.2, -16, -30), (1.1, -12.6, -27), (1.3, 25, -36), (0.8, 3, -6))
    for i, (radius, x, z) in enumerate(pebbles):
        mesh = scene.mesh(f"stone-{i}", pebble(radius, 11 * i, 0.62))
        scene.place(mesh, wet[i % 3], ("translate", x, radius * 0.35, z), ("rotate", 0, 1, 0, draw.uniform(0, 360)))
    scene.softbox("bright-cloud", (-80, 190, 60), (0, 0, -30), 160, 160, (1.6, 1.6, 1.6))
    scene.environment((0.85, 0.92, 1.0))
    scene.camera((0, 26, 30), (0, 1, -24), 42, 1.5)
    scene.render(720, 480, spp=128, max_bounces=6, exposure_ev=1.7)
    scene.save("oil")


def bauble_cap(scene):
    """The metal crown of a bauble, its ring included."""
    crown = lathe([(1.0, 0), (1.0, 0.9)], [(1.0, 0.9), (0.9, 1.0), (0, 1.0)], sides=48)
    wire = lambda t, r: (r * math.cos(t), 1.45 + r * math.sin(t))
    turns = [2 * math.pi * (i % 32) / 32 for i in range(33)]
    around = [-2 * math.pi * (i % 12) / 12 for i in range(13)]
    ring = [[(*wire(t, 0.55 + 0.1 * math.cos(a)), 0.1 * math.sin(a)) for t in turns] for a in around]
    return scene.mesh("crown", joined([crown, smooth(ring)]))


def christmas_balls():
    scene = Scene("Christmas balls: coloured lacquer under a film of index 2.2, 80 to 300 nm")
    silver = scene.material("silver", (0.8, 0.8, 0.8), '<conductor metal="Ag" roughness="0.18"/>')
    crown = bauble_cap(scene)
    balls = ((5.0, -9.8, 0.5, 25, 80, (0.55, 0.02, 0.03)), (6.0, 1.2, -3.5, -10, 140, (0.02, 0.10, 0.30)),
             (4.4, 11.4, 0.5, 40, 200, (0.02, 0.22, 0.06)), (3.2, -3.3, 7.2, -60, 250, (0.5, 0.24, 0.02)),
             (3.6, 5.9, 7.6, 75, 300, (0.22, 0.02, 0.24)), (2.9, -12.9, 7.2, 50, 110, (0.45, 0.45, 0.45)))
    for i, (radius, x, z, tilt, nm, color) in enumerate(balls):
        swirl = f"<noise{attributes(amplitude=0.12, frequency=0.22, octaves=2, seed=i)}/>"
        lacquer = diffuse(scene, f"lacquer-{i}", color, film(nm, swirl, ior=2.2), ior=1.5)
        scene.ball(f"ball-{i}", lacquer, radius, x, radius, z)
        size = 0.17 * radius
        scene.place(crown, silver, ("translate", x, radius, z), ("rotate", 0, 1, 0, 3 * tilt), ("rotate", 0, 0, 1, tilt),
                    ("translate", 0, 0.975 * radius, 0), ("scale", size, size, size), name=f"crown-{i}")
    table = diffuse(scene, "table", (0.16, 0.075, 0.035), film(0, ior=1.5))
    scene.place(scene.mesh("table-top", rectangle(160, 70)), table, ("translate", 0, 0, 5))
    wall = diffuse(scene, "wall", (0.10, 0.055, 0.04))
    scene.place(scene.mesh("wall-mesh", rectangle(260, 120)), wall, ("translate", 0, 30, -60), ("rotate", 1, 0, 0, 90))
    glow = scene.material("fairy", (1, 0.7, 0.3), '<emitter radiance="14 7.5 2.6"/>')
    draw = random.Random(12)
    for i in range(16):
        x = mix(-34, 34, i / 15)
        scene.ball(f"fairy-{i}", glow, 0.5, x + draw.uniform(-1.5, 1.5), 17 + 5 * math.cos(0.16 * x) + draw.uniform(-1.5, 1.5), -45)
    scene.window("window", (-42, 38, 34), (0, 4, 0), 36, 36, 2, 2, (7.5, 6.1, 4.4))
    scene.softbox("lamp", (36, 30, 10), (0, 4, 0), 16, 16, (9, 5.6, 2.8))
    scene.softbox("ceiling", (0, 70, 20), (0, 0, 0), 120, 90, (0.75, 0.6, 0.42))
    scene.environment((0.05, 0.04, 0.03))
    scene.camera((0, 13.5, 45), (-0.8, 4.4, 0), 40, 1.5, lens='<lens aperture_radius_m="0.004" focus_distance_m="0.415"/>')
    scene.render(600, 400, spp=128, max_bounces=8, exposure_ev=0.7)
    scene.save("christmas_balls")


def titanium():
    scene = Scene("Anodised titanium: the same plate and ring under 20, 40, ... 200 nm of oxide")
    plate = scene.mesh("plate", pillow(5.3, 11, 1.1, 4, 64, 32))
    outside = arc((1.55, 0), 1.05, -58, 58, 12)
    inside = [(1.75, 0.9), (1.75, -0.9)]
    ring = scene.mesh("ring", lathe([inside[1], (2.1, -0.9)], outside, [(2.1, 0.9), inside[0]], inside))
    for i in range(10):
        nm = 20 * (i + 1)
        oxide = scene.material(f"titanium-{nm}nm", (0.5, 0.5, 0.5),
                               f'<conductor metal="Ti" roughness="0.15">{film(nm, material="TiO2")}</conductor>')
        x = 5.9 * (i - 4.5)
        scene.place(plate, oxide, ("translate", x, 4.6, -3), ("rotate", 1, 0, 0, -38), name=f"plate-{nm}nm")
        scene.place(ring, oxide, ("translate", x, 0.9, 7), name=f"ring-{nm}nm")
    felt = diffuse(scene, "felt", (0.16, 0.16, 0.17))
    scene.place(scene.mesh("studio", backdrop(300, 60, 80, 25)), felt, ("translate", 0, 0, 40))
    scene.window("front-box", (0, 62, 50), (0, 3, 0), 130, 44, 1, 2, (2.2, 2.2, 2.2), bar=0.12)
    scene.softbox("rear-box", (0, 60, -14), (0, 3, 0), 130, 20, (2, 2, 2))
    scene.softbox("side-box", (-70, 24, 30), (0, 3, 0), 30, 40, (2.5, 2.5, 2.5))
    scene.environment((0.10, 0.10, 0.11))
    scene.camera((0, 32, 80), (0, 2.4, 0.5), 42.5, 2.5)
    scene.render(960, 384, spp=128, max_bounces=8, exposure_ev=0.2)
    scene.save("titanium")


def lens_mesh(radius, curve, edge):
    """A biconvex lens about the z = 0 plane, standing upright on y = -radius."""
    sag = curve - math.sqrt(curve * curve - radius * radius)
    half_deg = math.degrees(math.asin(radius / curve))
    lower = [(max(r, 0), y) for r, y in arc((0, curve - sag - edge / 2), curve, -90, half_deg - 90, 24)]
    upper = [(max(r, 0), y) for r, y in arc((0, sag - curve + edge / 2), curve, 90 - half_deg, 90, 24)]
    positions, normals, uvs, triangles = lathe(lower, [(radius, -edge / 2), (radius, edge / 2)], upper, sides=128)
    turned = lambda p: (p[0], -p[2], p[1])
    return [turned(p) for p in positions], [turned(n) for n in normals], uvs, triangles


def coated_glass():
    scene = Scene("Glass lenses: bare, with an antireflection film, and with dichroic stacks that split white light in two")
    stack = lambda nm: film(nm / 10, material="TiO2") + film(nm / 5.84, material="SiO2") + film(nm / 10, material="TiO2")
    coatings = (("bare", ""), ("antireflection", film(100, material="MgF2")),
                ("dichroic-gold", stack(610)), ("dichroic-blue", stack(450)))
    lens = scene.mesh("lens", lens_mesh(4, 11, 0.5))
    for i, (name, films) in enumerate(coatings):
        glass = scene.material(name, (0.9, 0.9, 0.9), f'<dielectric ior="1.517">{films}</dielectric>')
        scene.place(lens, glass, ("translate", 10 * (i - 1.5), 4, 0), ("rotate", 0, 1, 0, -22), name=name + "-lens")
    white = diffuse(scene, "white", (0.8, 0.8, 0.8))
    scene.place(scene.mesh("floor", rectangle(220, 120)), white, ("translate", 0, 0, 30))
    wall = diffuse(scene, "wall", (0.10, 0.11, 0.13))
    scene.place(scene.mesh("wall-mesh", rectangle(300, 120)), wall, ("translate", 0, 50, -30), ("rotate", 1, 0, 0, 90))
    scene.softbox("key", (-30, 44, 34), (0, 2, 0), 34, 34, (6, 6, 6))
    scene.window("window", (34, 20, 46), (0, 4, 0), 26, 26, 2, 3, (1.2, 1.2, 1.2))
    scene.environment((0.14, 0.14, 0.15))
    scene.camera((0, 16, 54), (0, 2.6, 0), 40, 2)
    scene.render(640, 320, spp=256, max_bounces=12, exposure_ev=0.2)
    scene.save("coated_glass")


def facing_films():
    scene = Scene("Two films that face each other: oxide on titanium and a film on gold, where three colour channels fail")
    leaf = scene.mesh("leaf", rectangle(9, 9))
    oxide = scene.material("oxide-on-titanium", (0.5, 0.4, 0.6),
                           f'<conductor metal="Ti" roughness="0.06">{film(180, material="TiO2")}</conductor>')
    coated = scene.material("film-on-gold", (0.8, 0.6, 0.2),
                            f'<conductor metal="Au" roughness="0.06">{film(150, ior=2.2)}</conductor>')
    for name, material, side in (("titanium", oxide, -1), ("gold", coated, 1)):
        scene.place(leaf, material, ("rotate", 0, 1, 0, -58 * side), ("translate", side * 4.52, 4.52, 0),
                    ("rotate", 1, 0, 0, 90), name=name + "-leaf")
    felt = diffuse(scene, "felt", (0.25, 0.25, 0.25))
    scene.place(scene.mesh("studio", backdrop(160, 60, 50, 20)), felt, ("translate", 0, 0, 30))
    for name, side in (("left", -1), ("right", 1)):
        scene.softbox(name + "-box", (38 * side, 12, 30), (0, 4, 4), 34, 34, (1.6, 1.6, 1.6))
    scene.softbox("ceiling", (0, 48, 16), (0, 0, 4), 40, 40, (1.2, 1.2, 1.2))
    scene.environment((0.2, 0.2, 0.2))
    scene.camera((0, 11, 34), (0, 4.3, 2), 29, 1.5)
    scene.render(480, 320, spp=128, max_bounces=12, exposure_ev=1.2)
    scene.save("facing_films")


def wine():
    scene = Scene("Wine in a coated glass, water and ice in a tumbler: bodies that overlap, told apart by their priorities")
    crystal = lambda films: f'<dielectric ior="1.55" priority="3">{films}</dielectric>'
    coated = scene.material("coated-crystal", (0.9, 0.9, 0.9), crystal(film(110, material="MgF2")))
    plain = scene.material("crystal", (0.9, 0.9, 0.9), crystal(""))
    red = scene.material("wine", (0.4, 0.02, 0.05), '<dielectric ior="1.345" priority="1" absorption_per_m="6 70 50"/>')
    water = scene.material("water", (0.8, 0.9, 0.9), '<dielectric ior="1.333" priority="1"/>')
    ice = scene.material("ice", (0.9, 0.9, 0.9), '<dielectric ior="1.31" priority="2"/>')

    # The wine reaches to the middle of the wall, where the glass takes its place.
    bowl = lambda radius, top_deg: [(max(r, 0), y) for r, y in arc((0, 12), radius, -90, top_deg, 40)]
    foot = [(0, 0), (3.3, 0), (3.4, 0.1), (3.3, 0.22), (1.2, 0.55), (0.45, 1.2), (0.33, 2.5), (0.33, 5.8), (0.5, 7)]
    rim = arc((4.5 * math.cos(math.radians(48)), 12 + 4.5 * math.sin(math.radians(48))), 0.1, 48 - 60, 48 + 180, 8)
    outside = [p for p in bowl(4.6, 48) if p[0] > 0.8]
    goblet = lathe(foot + outside + rim + bowl(4.4, 48)[::-1], sides=72)
    scene.place(scene.mesh("goblet", goblet), coated, ("translate", -5.2, 0, 0))
    level = 4.5 * math.cos(math.radians(4))
    fill = lathe(bowl(4.5, 4), [(level, 12 + 4.5 * math.sin(math.radians(4))), (0, 12 + 4.5 * math.sin(math.radians(4)))])
    scene.place(scene.mesh("wine-body", fill), red, ("translate", -5.2, 0, 0))

    tumbler = lathe([(0, 0), (3.4, 0)], [(3.4, 0), (3.7, 9)], arc((3.58, 9), 0.12, 0, 180, 8), [(3.46, 9), (3.2, 0.8)],
                    [(3.2, 0.8), (0, 0.8)])
    scene.place(scene.mesh("tumbler", tumbler), plain, ("translate", 5.2, 0, 1))
    drink = lathe([(0, 0.4), (3.3, 0.4)], [(3.3, 0.4), (3.48, 6.2)], [(3.48, 6.2), (0, 6.2)])
    scene.place(scene.mesh("water-body", drink), water, ("translate", 5.2, 0, 1))
    cube = scene.mesh("cube", pillow(2.6, 2.6, 2.6, 8, 48, 24))
    for i, (turn, tilt, *place) in enumerate(((20, 15, 4.1, 5.6, 1.4), (65, -20, 6.4, 5.4, 0.2))):
        scene.place(cube, ice, ("translate", *place), ("rotate", 0, 1, 0, turn), ("rotate", 1, 0, 0, tilt), name=f"cube-{i}")

    cloth = diffuse(scene, "cloth", (0.55, 0.54, 0.52))
    scene.place(scene.mesh("studio", backdrop(160, 50, 60, 20)), cloth, ("translate", 0, 0, 30))
    scene.window("window", (-40, 30, 10), (0, 6, 0), 40, 40, 2, 3, (5, 5.2, 5.6))
    scene.softbox("strip", (34, 24, 20), (0, 6, 0), 10, 40, (3, 2.9, 2.7))
    scene.environment((0.35, 0.36, 0.38))
    scene.camera((0, 15, 48), (0, 7.2, 0), 30, 1.25)
    scene.render(500, 400, spp=256, max_bounces=24, exposure_ev=0.3)
    scene.save("wine")


SCENES = (gold_knot, bubbles, oil, christmas_balls, titanium, coated_glass, facing_films, wine)
