"""The pictures of docs/gallery.md, into gallery/."""

import math
import random

from .collada import FOLDER, Scene, diffuse, film, png
from .meshes import backdrop, joined, lathe, part_of, pebble, pillow, rectangle, sheet, smooth
from .vectors import add, cross, fractal, mix, noise, scaled, smoothstep, sub, unit

PLACE = FOLDER / "gallery"


def picture(name, *settings, **more):
    PLACE.mkdir(exist_ok=True)
    (PLACE / name).write_bytes(png(*settings, **more))


def save(scene, name, packed=False):
    PLACE.mkdir(exist_ok=True)
    (scene.save_packed if packed else scene.save)("gallery/" + name)


def varnished(scene, name, color, ior=1.5):
    """A matte body under a smooth clear surface."""
    return diffuse(scene, name, color, film(0, ior=ior), ior=ior)


def wheel(point, rings, sides):
    """A closed surface of revolution about y with texture coordinates: u around, v along point(v) = (radius, height)."""
    def at(u, v):
        r, y = point(v)
        return r * math.cos(2 * math.pi * u), y, -r * math.sin(2 * math.pi * u)
    positions, normals, uvs, triangles = sheet(at, sides, rings)
    # The seam, where differences are one-sided, has the normals of both sides.
    row = sides + 1
    for j in range(rings + 1):
        both = unit(add(normals[j * row], normals[j * row + sides]))
        normals[j * row] = normals[j * row + sides] = both
    return positions, normals, uvs, triangles


# Oil

def drops(u, v):
    """Rings of oil about drops that fell into a puddle, pulled by the flow."""
    x, y = 14 * u, 14 * v
    x += 0.34 * fractal((0.7 * x, 0.7 * y, 3), 4, 11)
    y += 0.34 * fractal((0.7 * x, 0.7 * y, 9), 4, 23)
    height = 0
    drops = ((6.8, 4.6, 2.1, 1.0), (9.3, 7.4, 1.5, 0.8), (4.0, 7.3, 1.7, 0.7), (10.4, 3.6, 1.1, 0.75), (6.6, 9.6, 1.6, 0.6),
             (3.2, 3.4, 1.0, 0.5))
    for cx, cy, size, peak in drops:
        height = max(height, peak * math.exp(-((x - cx) ** 2 + 1.5 * (y - cy) ** 2) / size ** 2))
    return height * (0.93 + 0.14 * fractal((1.3 * x, 1.3 * y, 5), 4, 5))


def grit(u, v):
    """Stones in tar; sRGB values."""
    stones = noise((400 * u, 400 * v, 0), 3) + 0.7 * noise((230 * u, 230 * v, 0), 8)
    return 0.06 + 0.34 * smoothstep(0.1, 0.9, stones) + 0.03 * noise((12 * u, 12 * v, 0), 5)


def overcast(u, v):
    """A grey sky that brightens upwards over dark houses; sRGB values."""
    turn, rise = 2 * math.pi * u, math.pi * (v - 0.5)
    roofs = 0.16 + 0.07 * noise((5 * math.cos(turn), 5 * math.sin(turn), 0), 4)
    bright = smoothstep(roofs - 0.03, roofs + 0.05, rise) * mix(0.74, 0.98, smoothstep(0.1, 1.2, rise))
    cloud = 0.10 * fractal((3 * math.cos(turn) * math.cos(rise), 3 * math.sin(turn) * math.cos(rise), 6 * rise), 4, 9)
    grey = 0.16 + bright * (0.84 + cloud)
    return grey * 0.96, grey * 0.985, grey


def oil_on_asphalt():
    scene = Scene("Oil that dripped on a wet road: rings of one thickness each under a grey sky")
    picture("drops.png", 512, 512, drops)
    picture("grit.png", 1024, 1024, grit, bits=8)
    layer = film(varying='<map image="drops.png" min_nm="0" max_nm="1050"/>', ior=1.47)
    stones = '<map for="reflectance" image="grit.png"/>'
    road = scene.material("wet-road", (0.05, 0.05, 0.05), f'<diffuse reflectance="0.55" ior="1.33">{stones}{layer}</diffuse>')
    scene.place(scene.mesh("road", rectangle(110, 110)), road, ("translate", 0, 0, -12))
    paint = varnished(scene, "paint", (0.26, 0.24, 0.19))
    line = scene.mesh("line", rectangle(7, 120))
    scene.place(line, paint, ("translate", 24, 0.05, -10), ("rotate", 0, 1, 0, 12))
    draw = random.Random(8)
    shades = ((0.10, 0.09, 0.085), (0.17, 0.145, 0.12), (0.05, 0.05, 0.055))
    wet = [diffuse(scene, f"stone-{i}", shade, film(0, ior=1.33), ior=1.33) for i, shade in enumerate(shades)]
    stones = [scene.mesh(f"pebble-{i}", pebble(1, 7 * i, 0.6, 32, 16)) for i in range(3)]
    for i in range(34):
        x, z, size = draw.uniform(-34, 34), draw.uniform(-55, 16), 0.25 + 1.1 * draw.random() ** 3
        scene.place(stones[i % 3], wet[draw.randrange(3)], ("translate", x, 0.3 * size, z), ("rotate", 0, 1, 0, draw.uniform(0, 360)),
                    ("scale", size, size, size), name=f"stone-{i}-node")
    picture("overcast.png", 128, 64, overcast, channels=3)
    scene.environment((1, 1, 1), image="overcast.png", strength=1.6)
    scene.camera((0, 30, 42), (0, 0, -7), 40, 1.5, lens='<lens aperture_radius_m="0.004" focus_distance_m="0.56"/>')
    scene.render(900, 600, spp=48, max_bounces=6, exposure_ev=1.2)
    save(scene, "oil_on_asphalt")


# Metals

def studio(scene, color, width=240, depth=70, height=90):
    felt = diffuse(scene, "felt", color)
    scene.place(scene.mesh("studio", backdrop(width, depth, height, 30)), felt, ("translate", 0, 0, 45))


def volts(u, v):
    """Oxide from the root of the ribbon to its tip."""
    return u


def titanium_ribbon():
    scene = Scene("A ribbon of anodised titanium: 20 to 180 nm of oxide from one end to the other, drawn through the bath slowly")
    picture("ramp.png", 256, 4, volts)
    oxide = film(varying='<map image="ramp.png" min_nm="18" max_nm="185" wrap="clamp"/>', material="TiO2")
    metal = scene.material("titanium", (0.6, 0.5, 0.7), f'<conductor metal="Ti" roughness="0.12">{oxide}</conductor>')

    def spiral(t):
        a = 2 * math.pi * (2.6 * t + 0.08)
        r = mix(4.2, 15.5, t)
        return r * math.cos(a), 5.2 + 1.4 * math.sin(2 * a), -r * math.sin(a) * 0.62

    def ribbon(u, v):
        here = spiral(u)
        along = unit(sub(spiral(u + 1e-3), spiral(u - 1e-3)))
        lean = 0.55 * math.sin(2 * math.pi * 2.6 * u)
        across = unit((lean * along[2], 1, -lean * along[0]))
        return add(here, scaled(across, 5.0 * (v - 0.5)))

    scene.place(scene.mesh("ribbon", sheet(ribbon, 520, 16)), metal, ("translate", 0, 0, 0))
    studio(scene, (0.66, 0.66, 0.67))
    scene.softbox("key", (-60, 34, 40), (0, 6, 0), 50, 60, (3.4, 3.4, 3.4))
    scene.softbox("rim", (64, 26, 6), (0, 6, 0), 40, 50, (3, 3, 3))
    scene.softbox("front", (6, 14, 90), (0, 6, 0), 120, 26, (1.8, 1.8, 1.8))
    scene.softbox("ceiling", (0, 80, 0), (0, 4, 0), 90, 60, (2, 2, 2))
    scene.environment((0.4, 0.4, 0.41))
    scene.camera((0, 30, 44), (0.5, 5.0, 0), 36, 1.5)
    scene.render(900, 600, spp=96, max_bounces=10, exposure_ev=-0.15)
    save(scene, "titanium_ribbon")


def heat(u, v):
    """How far the oxide has grown beside three welds: most in the middle of each."""
    from_weld = min(abs(v - c) for c in (0.19, 0.5, 0.81))
    ragged = 0.014 * fractal((9 * math.cos(2 * math.pi * u), 9 * math.sin(2 * math.pi * u), 6 * v), 3, 2)
    return smoothstep(0.15, 0.015, from_weld + ragged)


def tempered_steel():
    scene = Scene("Temper colours of steel: pipes with welds, straw to brown, purple and blue as the oxide grows from 22 to 75 nm")
    picture("heat.png", 128, 512, heat)
    oxide = film(varying='<map image="heat.png" min_nm="4" max_nm="62"/>', material="Fe3O4")
    steel = scene.material("steel", (0.6, 0.6, 0.6), f'<conductor metal="Fe" roughness="0.13">{oxide}</conductor>')
    bead = scene.material("bead", (0.4, 0.4, 0.4), f'<conductor metal="Fe" roughness="0.3">{film(60, material="Fe3O4")}</conductor>')
    pipe = scene.mesh("pipe", wheel(lambda v: (3.4, 44 * (v - 0.5)), 8, 96))

    def seam(u, v):
        a, b = 2 * math.pi * u, 2 * math.pi * v
        ripple = 0.08 * math.cos(46 * a + 1.2 * math.cos(b))
        r = 3.42 + (0.30 + ripple) * math.cos(b)
        return r * math.cos(a), 0.62 * math.sin(b), -r * math.sin(a)

    weld = scene.mesh("weld", sheet(seam, 460, 10))
    for i, (x, z, turn) in enumerate(((-0.5, 9.5, 4), (1.5, 0.5, -3), (-1, -8.5, 2))):
        pose = (("translate", x, 3.4, z), ("rotate", 0, 1, 0, turn), ("rotate", 0, 0, 1, -90), ("rotate", 0, 1, 0, 90 * i))
        scene.place(pipe, steel, *pose, name=f"pipe-{i}")
        for k, v in enumerate((0.19, 0.5, 0.81)):
            scene.place(weld, bead, *pose, ("translate", 0, 44 * (v - 0.5), 0), name=f"weld-{i}-{k}")
    studio(scene, (0.06, 0.06, 0.065))
    scene.softbox("key", (-20, 60, 10), (0, 3, 0), 90, 22, (4.5, 4.5, 4.5))
    scene.softbox("front", (16, 24, 70), (0, 3, 0), 100, 16, (2.6, 2.6, 2.6))
    scene.environment((0.22, 0.22, 0.23))
    scene.camera((7, 25, 44), (0, 2.4, 0.5), 36, 1.5, lens='<lens aperture_radius_m="0.005" focus_distance_m="0.44"/>')
    scene.render(900, 600, spp=64, max_bounces=8, exposure_ev=0.5)
    save(scene, "tempered_steel")


# Glass

def element(front, back, radius, thick):
    """A lens about y with its rim at radius: front and back are radii of curvature, above 0 where they bulge outwards."""
    def side(curve, start):
        if curve == 0:
            return [(radius * (1 - i / 24), start) for i in range(25)]
        return [(r, start + math.copysign(math.sqrt(curve * curve - r * r) - math.sqrt(curve * curve - radius * radius), curve))
                for r in (radius * (1 - i / 24) for i in range(25))]
    top = side(front, thick / 2)
    bottom = [(r, -y) for r, y in side(back, thick / 2)][::-1]
    return lathe(bottom, [(radius, -thick / 2), (radius, thick / 2)], top, sides=128)


def camera_lens():
    scene = Scene("The front of a camera's lens: elements under one, two and three layers against reflections, each with its own tint")
    black = varnished(scene, "barrel", (0.022, 0.022, 0.022))
    matte = diffuse(scene, "baffle", (0.012, 0.012, 0.012))
    ring = scene.material("ring", (0.6, 0.1, 0.05), '<conductor metal="Cu" roughness="0.2"/>')
    mark = scene.material("mark", (0.8, 0.8, 0.8), '<diffuse reflectance="0.7"/>')
    grooves = [(7.8 + 0.14 * (i % 2), mix(-7.5, -1.5, i / 60)) for i in range(61)]
    barrel = lathe([(7.8, -14), (7.8, -7.5)], grooves, [(7.8, -1.5), (7.8, 0.2)], [(7.8, 0.2), (7.45, 0.6), (6.5, 0.6)],
                   [(6.5, 0.6), (6.3, -0.9), (5.9, -1.0)], [(5.9, -1.0), (5.75, -5), (4.6, -5.2), (4.5, -12), (0, -12)], sides=160)
    pose = (("translate", 0, 8.2, 0), ("rotate", 0, 1, 0, -24), ("rotate", 1, 0, 0, 74))
    scene.place(scene.mesh("barrel-mesh", barrel), black, *pose)
    trim = [(7.83 + 0.1 * math.cos(t), -0.75 + 0.22 * math.sin(t)) for t in [math.pi * (i / 8 - 0.5) for i in range(9)]]
    scene.place(scene.mesh("trim", lathe(trim, sides=160)), ring, *pose)
    blades = lathe([(4.6, -7.6), (2.2, -7.4)], sides=9)
    scene.place(scene.mesh("iris", blades), matte, *pose)
    scene.mesh("tick", pillow(0.10, 0.06, 0.2, 8, 12, 6))
    for i in range(48):
        turn = 360 * i / 48
        if i % 16 < 9:
            scene.place("tick", mark, *pose, ("rotate", 0, 1, 0, turn), ("translate", 6.95, 0.61, 0), name=f"tick-{i}")
    coats = {"magenta": film(128, material="MgF2"),
             "green": film(72, material="MgF2") + film(118, ior=2.05) + film(66, ior=1.7),
             "blue": film(150, material="MgF2"),
             "amber": film(98, material="MgF2")}
    stack = (("magenta", 15, 30, 5.85, 1.2, -0.6), ("green", 13, -9, 5.0, 0.9, -2.7), ("amber", 11, 18, 4.4, 1.0, -4.6),
             ("blue", 14, 14, 4.2, 1.2, -9.0))
    for name, front, back, radius, thick, y in stack:
        glass = scene.material("glass-" + name, (0.8, 0.85, 0.9), f'<dielectric ior="1.62">{coats[name]}</dielectric>')
        scene.place(scene.mesh("lens-" + name, element(front, back, radius, thick)), glass, *pose, ("translate", 0, y, 0))
    table = varnished(scene, "table", (0.035, 0.036, 0.04))
    scene.place(scene.mesh("table-top", backdrop(300, 120, 90, 40)), table, ("translate", 0, 0, 60))
    scene.window("window", (-44, 44, 56), (0, 8, 0), 80, 70, 2, 2, (2.6, 2.7, 2.85))
    scene.softbox("strip", (64, 26, 34), (0, 8, 0), 40, 60, (2.2, 2.1, 2.0))
    scene.softbox("behind", (0, 56, -30), (0, 6, 0), 90, 26, (2.4, 2.4, 2.4))
    scene.environment((0.2, 0.2, 0.21))
    scene.camera((0, 14, 52), (0.3, 7.6, 0), 30, 1.5, lens='<lens aperture_radius_m="0.003" focus_distance_m="0.47"/>')
    scene.render(900, 600, spp=96, max_bounces=24, exposure_ev=1.1)
    save(scene, "camera_lens", packed=True)


def dichroic():
    scene = Scene("Disks with eleven quarter waves of TiO2 and SiO2, before a bright wall: what one lets through the next divides again")
    colours = ((440, -13.5, 8.6, 2, 16), (500, -7.8, 5.8, 7, -22), (545, -2.6, 9.4, 0, 28), (590, 3.2, 5.6, 6, -12), (640, 8.4, 8.9, 1, 24),
               (690, 13.8, 5.9, 8, -26), (470, 0.6, 4.2, 13, 40), (615, -13.2, 4.0, 12, -38), (520, 17.6, 9.4, -3, 10))
    turns = [2 * math.pi * (i % 128) / 128 for i in range(129)]
    disk = lathe([(4.6, -0.05), (4.6, 0.05)], sides=160)
    face = smooth([[(r * math.cos(t), 0, -r * math.sin(t)) for t in turns] for r in (4.6, 2.3, 0)], normal=lambda p: (0, 1, 0))
    rim = scene.material("rim", (0.3, 0.3, 0.3), '<conductor metal="Ag" roughness="0.15"/>')
    scene.mesh("face", face)
    scene.mesh("rim-mesh", disk)
    for i, (nm, x, y, z, turn) in enumerate(colours):
        high, low = film(nm / 4 / 2.45, material="TiO2"), film(nm / 4 / 1.46, material="SiO2")
        # Of the glass between its two faces only the coated one matters to the colour: the stack stands in air.
        glass = scene.material(f"dichroic-{nm}", (0.8, 0.8, 0.8), f'<dielectric ior="1">{(high + low) * 5 + high}</dielectric>')
        pose = (("translate", x, y, z), ("rotate", 0, 1, 0, turn), ("rotate", 1, 0, 0, 90))
        scene.place("face", glass, *pose, name=f"disk-{nm}")
        scene.place("rim-mesh", rim, *pose, name=f"rim-{nm}")
        if y > 4.61:
            post = scene.mesh(f"post-{nm}", lathe([(0.12, 0), (0.12, y - 4.6)], sides=24))
            scene.place(post, rim, ("translate", x, 0, z))
    table = varnished(scene, "table", (0.02, 0.02, 0.02))
    scene.place(scene.mesh("table-top", rectangle(400, 400)), table)
    scene.softbox("wall", (0, 30, -90), (0, 26, 0), 300, 70, (0.85, 0.87, 0.9))
    scene.softbox("front", (-50, 50, 70), (0, 6, 0), 60, 60, (2.2, 2.2, 2.2))
    scene.softbox("side", (70, 20, 40), (0, 6, 0), 30, 60, (1.6, 1.55, 1.5))
    scene.environment((0.06, 0.06, 0.065))
    scene.camera((0, 15, 62), (1.6, 6.4, 0), 41, 1.5, lens='<lens aperture_radius_m="0.003" focus_distance_m="0.58"/>')
    scene.render(900, 600, spp=48, max_bounces=24, exposure_ev=0, mode="spectral")
    save(scene, "dichroic")


# Shells and wings

def abalone():
    scene = Scene("The inside of an abalone's shell, and pearls: sixteen tablets of aragonite with chitin between them, on dark shell")
    nacre = lambda tablet_nm: (film(tablet_nm, material="aragonite") + film(30, material="chitin")) * 16

    def shell(u, v):
        a = 2 * math.pi * u
        r = 11 * v ** 0.85 * (1 + 0.10 * math.cos(a - 0.6) + 0.025 * math.cos(3 * a))
        x, z = 1.35 * r * math.cos(a), r * math.sin(a)
        bumps = 0.5 * fractal((0.22 * x, 0.22 * z, 2.0), 3, 31) + 0.03 * math.sin(44 * a) * v ** 4
        return x, 0.6 + 3.6 * v ** 2.4 + bumps * (0.5 + 0.5 * v), -z

    def tablet_nm(u, v):
        """Bands of growth, drawn out of shape as the shell's muscle and its bumps made them."""
        x, _, z = shell(u, v)
        swirl = fractal((0.15 * x, 0.15 * z, 7.0), 2, 12)
        return 300 + 30 * math.sin(9 * v + 3.5 * swirl) + 16 * math.sin(21 * v - 5 * swirl + 1)

    # Every cell of the shell goes to the nearest of so many thicknesses that no step between them is seen.
    columns, rows, step_nm = 360, 70, 2
    inside = sheet(lambda u, v: shell(u, mix(0.004, 1, v)), columns, rows)
    cells = {}
    for k, triangle in enumerate(inside[3]):
        u, v = (k // 2 % columns + 0.5) / columns, mix(0.004, 1, (k // 2 // columns + 0.5) / rows)
        cells.setdefault(step_nm * round(tablet_nm(u, v) / step_nm), []).append(triangle)
    for nm, triangles in sorted(cells.items()):
        body = diffuse(scene, f"nacre-{nm}", (0.05, 0.06, 0.06), nacre(nm), ior=1.6)
        scene.place(scene.mesh(f"shell-{nm}", part_of(inside, triangles)), body, ("translate", -1.5, 3.2, 0), ("rotate", 1, 0, 0, 16),
                    ("rotate", 0, 1, 0, 18))
    draw = random.Random(3)
    pearls = ((15.2, 9, 1.7, 330), (18.4, 5, 1.2, 300), (12.2, 12.6, 1.3, 365), (18.2, 10.8, 1.0, 350), (-14, 13.6, 1.4, 315))
    for i, (x, z, radius, nm) in enumerate(pearls):
        pearl = diffuse(scene, f"pearl-{i}", (0.55, 0.53, 0.5), nacre(nm), ior=1.6)
        scene.ball(f"pearl-{i}-ball", pearl, radius, x, radius, z + draw.uniform(-0.5, 0.5))
    cloth = diffuse(scene, "cloth", (0.13, 0.14, 0.17))
    scene.place(scene.mesh("table", rectangle(400, 400)), cloth)
    # A white tent: what mirrors in all directions is seen best where all directions are bright.
    scene.softbox("key", (-40, 74, -30), (0, 3, 0), 40, 40, (4.5, 4.5, 4.5))
    scene.environment((1.15, 1.17, 1.2))
    scene.camera((3, 48, 46), (1.9, 2.0, 1.2), 37, 1.5)
    scene.render(900, 600, spp=64, max_bounces=8, exposure_ev=0.5)
    save(scene, "abalone", packed=True)


def jewel_beetle():
    scene = Scene("A jewel beetle: sixteen layers of cuticle that reflect green at 530 nm, stripes at 650 nm")
    coat = lambda name, nm: scene.material(name, (0.1, 0.6, 0.2), f'<preset name="jewel-beetle" peak_nm="{nm}"/>')
    green, copper, neck = coat("green", 535), coat("copper", 660), coat("neck", 560)
    dark = varnished(scene, "dark", (0.02, 0.018, 0.015), ior=1.56)

    def case(side, low, high):
        """A strip of one wing case: from the middle (0) outwards (1), head at v = 1."""
        def at(u, v):
            w = mix(low, high, u)
            t = math.pi * mix(0.03, 0.97, v)
            length = -7.4 * math.cos(t)
            girth = math.sin(t) ** 0.55 * (1 - 0.16 * math.cos(t) ** 3 + 0.05 * math.cos(t))
            a = math.pi / 2 * w
            groove = 0.045 * math.cos(2 * math.pi * 7 * w) + 0.025 * noise((26 * w, 60 * v, side), 7)
            r = 1 + groove * math.sin(t)
            return side * (0.05 + 3.1 * girth * r * math.sin(a)), 2.5 * girth * r * math.cos(a) ** 0.85, -length
        return sheet(at, 40 if high - low > 0.3 else 24, 150, flip=side < 0)

    pose = (("translate", 0, 1.5, 0), ("rotate", 0, 1, 0, 32))
    for side in (-1, 1):
        for name, material, low, high in (("inner", green, 0.0, 0.46), ("stripe", copper, 0.46, 0.66), ("outer", green, 0.66, 1.0)):
            scene.place(scene.mesh(f"{name}{side}", case(side, low, high)), material, *pose, ("translate", 0, 0, 2.6))
    scene.place(scene.mesh("thorax", pillow(5.5, 3.5, 3.4, 2.6, 72, 40)), neck, *pose, ("translate", 0, 0.75, -6.0), ("rotate", 1, 0, 0, -8))
    scene.place(scene.mesh("head", pillow(3.3, 2.4, 2.4, 2.3, 56, 32)), neck, *pose, ("translate", 0, 0.45, -8.3))
    scene.place(scene.mesh("belly", pillow(5.4, 2.2, 14, 2.4, 48, 24)), dark, *pose, ("translate", 0, -0.25, 1.8))
    for side in (-1, 1):
        scene.place("eye" if side > 0 else scene.sphere("eye", 0.72), dark, *pose, ("translate", 1.25 * side, 0.7, -8.7), name=f"eye{side}")
        for i, (z, reach) in enumerate(((-5.6, -2.6), (-2.6, 0.4), (2.0, 3.4))):
            joints = ((1.6 * side, -0.2, z), (3.9 * side, 1.0, z + 0.35 * reach), (4.9 * side, -0.7, z + 0.8 * reach),
                      (5.9 * side, -1.42, z + 1.25 * reach))
            limb = [limb_part(a, b, r) for a, b, r in zip(joints, joints[1:], (0.34, 0.26, 0.14))]
            scene.place(scene.mesh(f"leg-{i}{side}", joined(limb)), neck, *pose)
        feeler = [(0.7 * side, 0.5, -9.2), (1.5 * side, 0.9, -10.6), (2.7 * side, 0.6, -11.8), (4.0 * side, 0.0, -12.3)]
        parts = [limb_part(a, b, 0.12) for a, b in zip(feeler, feeler[1:])]
        scene.place(scene.mesh(f"feeler{side}", joined(parts)), dark, *pose)

    leaf = diffuse(scene, "leaf", (0.045, 0.10, 0.018))

    def blade(u, v):
        u, across = mix(0.01, 0.99, u), v - 0.5
        veins = -0.175 * math.cos(40 * math.pi * abs(u - 0.5 + 0.28 * abs(across))) * abs(across) ** 0.6
        height = veins + 5.5 * across ** 2 - 1.1 * math.exp(-900 * across ** 2) + 1.5 * (u - 0.5) ** 2
        return 62 * (u - 0.5), height, -36 * across * math.sin(math.pi * u) ** 0.6

    scene.place(scene.mesh("leaf-mesh", sheet(blade, 260, 80)), leaf, ("translate", 0, -0.55, 0), ("rotate", 0, 1, 0, 20))
    ground = diffuse(scene, "ground", (0.035, 0.03, 0.02))
    scene.place(scene.mesh("soil", rectangle(300, 300)), ground, ("translate", 0, -16, -40))
    scene.softbox("sky", (-26, 64, 16), (0, 0, 0), 84, 70, (3.2, 3.3, 3.5))
    scene.softbox("sun", (44, 50, -34), (0, 0, 0), 24, 24, (10, 9.3, 8))
    scene.environment((0.42, 0.46, 0.48))
    scene.camera((-5, 21, 33), (0, 0.6, -0.8), 36, 1.5, lens='<lens aperture_radius_m="0.004" focus_distance_m="0.37"/>')
    scene.render(900, 600, spp=64, max_bounces=8, exposure_ev=0.7)
    save(scene, "jewel_beetle", packed=True)


def limb_part(a, b, radius):
    """A limb from a to b, thicker in the middle, with rounded ends."""
    along = unit(sub(b, a))
    side = unit(cross(along, (0.2, 1, 0.1)))
    up = cross(side, along)
    rows = []
    for i in range(13):
        t = i / 12
        r = radius * math.sqrt(max(0, 1 - (2 * t - 1) ** 4)) * (1 - 0.3 * t)
        centre = add(a, scaled(sub(b, a), t))
        turns = [2 * math.pi * (j % 12) / 12 for j in range(13)]
        rows.append([add(centre, add(scaled(side, r * math.cos(x)), scaled(up, r * math.sin(x)))) for x in turns])
    return smooth(rows)


SCENES = (oil_on_asphalt, titanium_ribbon, tempered_steel, camera_lens, dichroic, abalone, jewel_beetle)
