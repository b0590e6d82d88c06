"""A dragon of about 100 000 triangles: swept, scaled, with legs, claws, horns, spines and whiskers.

Everything is swept along curves through points (x, y, z, radius). The dragon looks along -x and stands on y = 0; it is some
ten units long.
"""

import math

from .meshes import joined, smooth
from .vectors import add, cross, mix, scaled, smoothstep, sub, unit

# From the tip of the tail to the head.
SPINE = ((5.2, 4.75, -0.5, 0.02), (5.95, 4.0, -0.75, 0.12), (6.2, 2.75, -1.0, 0.21), (5.7, 1.4, -1.05, 0.31), (4.65, 0.68, -0.8, 0.45),
         (3.35, 0.86, -0.2, 0.64), (2.25, 1.75, 0.42, 0.84), (1.05, 2.62, 0.72, 0.98), (-0.35, 2.42, 0.45, 1.06),
         (-1.55, 1.76, -0.1, 1.10), (-2.75, 1.80, -0.42, 1.04), (-3.65, 2.70, -0.45, 0.88), (-3.68, 3.80, -0.2, 0.72),
         (-3.10, 4.75, 0.1, 0.62), (-2.95, 5.65, 0.3, 0.56), (-3.45, 6.35, 0.45, 0.52), (-4.2, 6.5, 0.6, 0.46))
Z = (0, 0, 1)


def curve(points, t):
    """A Catmull-Rom curve through the points; t runs from 0 to 1."""
    spans = len(points) - 1
    i = min(int(t * spans), spans - 1)
    u = t * spans - i
    a, b, c, d = (points[min(max(i + k, 0), spans)] for k in (-1, 0, 1, 2))
    weights = (-u + 2 * u ** 2 - u ** 3, 2 - 5 * u ** 2 + 3 * u ** 3, u + 4 * u ** 2 - 3 * u ** 3, u ** 3 - u ** 2)
    return tuple(sum(w * p[k] for w, p in zip(weights, (a, b, c, d))) / 2 for k in range(len(b)))


def frame(points, t, side=Z):
    """Point, radius, and the directions along, to the side and up, at t."""
    *here, radius = curve(points, t)
    ahead, behind = curve(points, min(t + 1e-3, 1)), curve(points, max(t - 1e-3, 0))
    along = unit(sub(ahead[:3], behind[:3]))
    up = unit(cross(along, side))
    return tuple(here), max(radius, 0.001), along, cross(up, along), up


def sweep(points, rings, sides, shape=lambda t, a: (1, 1), side=Z):
    """`shape(t, a)` scales width and height at the angle a, which is 0 at the side and a quarter turn on the back. The ends
    are closed to a point."""
    rows = []
    for i in range(rings + 1):
        here, radius, along, out, up = frame(points, i / rings, side)
        row = []
        for j in range(sides + 1):
            a = 2 * math.pi * (j % sides) / sides
            width, height = shape(i / rings, a)
            row.append(add(here, add(scaled(out, radius * width * math.cos(a)), scaled(up, radius * height * math.sin(a)))))
        rows.append(row)
    first, last = frame(points, 0, side)[0], frame(points, 1, side)[0]
    return smooth([[first] * (sides + 1), *rows, [last] * (sides + 1)])


def scale(along, around):
    """Height of overlapping scales, in rows that are shifted by half: 0 at a scale's root, 1 at its rounded tip."""
    row = math.floor(along)
    best = 0
    for r in (row, row - 1):
        x = around + 0.5 * (r % 2)
        x -= math.floor(x) + 0.5
        y = (along - r) / 1.55
        edge = math.sqrt(max(0, 1 - (1.9 * x) ** 2))
        if 0 <= y <= edge:
            best = max(best, 0.35 + 0.65 * y / max(edge, 0.3) - 1.1 * x * x)
    return best


def body():
    rows, columns = 76, 16

    def shape(t, a):
        back = math.sin(a)
        belly = smoothstep(-0.55, -0.75, back)
        scales = scale(rows * (1 - t), columns * a / (2 * math.pi))
        plates = (52 * (1 - t)) % 1
        relief = mix(0.13 * scales, 0.09 * plates ** 0.7, belly)
        ridge = 0.10 * math.exp(-((a - math.pi / 2) / 0.16) ** 2)
        size = 0.91 + relief * smoothstep(0, 0.2, t) + ridge
        return 0.9 * size, size * mix(1, 0.86, belly)

    return sweep(SPINE, 660, 64, shape)


def spike(root, tip, width, bend=(0, 0, 0), flat=1.0, side=Z, rings=8, sides=8):
    """A horn or a claw: from root to tip, bent at the middle."""
    middle = add(scaled(add(root, tip), 0.5), bend)
    return sweep(((*root, width), (*middle, 0.62 * width), (*tip, 0.01 * width)), rings, sides, lambda t, a: (flat, 1), side)


def back_spines():
    parts = []
    count = 42
    for i in range(count):
        t = mix(0.07, 0.93, i / (count - 1))
        here, radius, along, _, up = frame(SPINE, t)
        size = (0.34 + 0.42 * radius) * (0.85 + 0.15 * (i % 2))
        root = add(here, scaled(up, 0.93 * radius))
        tip = add(root, add(scaled(up, size), scaled(along, -0.75 * size)))
        parts.append(spike(root, tip, 0.42 * size, scaled(along, 0.10 * size), flat=0.30, rings=7, sides=10))
    return parts


def leg(points, turn_deg, scaled_by=1.0):
    """A leg through its joints; four toes with claws at the end, spread about a direction in the ground plane."""
    def shape(t, a):
        size = 1 + 0.09 * scale(18 * (1 - t), 10 * a / (2 * math.pi))
        return size, size

    parts = [sweep(points, 64, 30, shape)]
    *foot, radius = points[-1]
    for k in (-1.5, -0.5, 0.5, 1.5):
        turn = math.radians(turn_deg + 30 * k)
        ahead = (-math.cos(turn), 0, math.sin(turn))
        reach = 0.62 * scaled_by
        root = add(tuple(foot), scaled(ahead, 0.02))
        knuckle = add(tuple(foot), add(scaled(ahead, 0.5 * reach), (0, 0.10, 0)))
        end = add(tuple(foot), add(scaled(ahead, reach), (0, -foot[1] + 0.11, 0)))
        sideways = (math.sin(turn), 0, math.cos(turn))
        toe = ((*root, 0.6 * radius), (*knuckle, 0.19 * scaled_by), (*end, 0.12 * scaled_by))
        parts.append(sweep(toe, 16, 12, lambda t, a: (1 + 0.05 * math.sin(28 * t), 1 + 0.05 * math.sin(28 * t)), sideways))
        claw = add(end, add(scaled(ahead, 0.34 * scaled_by), (0, -0.09, 0)))
        parts.append(spike(add(end, scaled(ahead, -0.02)), claw, 0.10 * scaled_by, (0, 0.09, 0), side=sideways, rings=8, sides=8))
    return parts


def legs():
    near, far = 1, -1
    parts = []
    for z, turn, x in ((near, 24, 0.0), (far, -20, -0.35)):
        front = ((-2.35 + x, 1.75, -0.35 + 0.45 * z, 0.55), (-2.1 + x, 1.25, -0.3 + 1.08 * z, 0.42),
                 (-2.6 + x, 0.72, -0.3 + 1.3 * z, 0.27), (-2.95 + x, 0.22, -0.3 + 1.28 * z, 0.21))
        hind = ((2.2 + x, 1.75, 0.45 + 0.35 * z, 0.66), (1.65 + x, 1.35, 0.45 + 0.98 * z, 0.55),
                (2.15 + x, 0.72, 0.45 + 1.2 * z, 0.29), (1.75 + x, 0.22, 0.45 + 1.24 * z, 0.22))
        parts += leg(front, turn) + leg(hind, turn)
    return parts


def head():
    """The head looks along -x from its own origin, which is where skull and neck meet."""
    def skull_shape(t, a):
        back = math.sin(a)
        eye = math.exp(-((t - 0.40) / 0.10) ** 2)
        brow = 0.30 * eye * math.exp(-((abs(math.cos(a)) - 0.72) / 0.22) ** 2) * (back > 0)
        nostril = 0.34 * math.exp(-((t - 0.92) / 0.055) ** 2) * math.exp(-((abs(math.cos(a)) - 0.62) / 0.25) ** 2) * (back > 0)
        wrinkle = 0.025 * math.sin(46 * t) * smoothstep(0.5, 0.6, t) * (back > -0.2)
        bumps = 0.05 * scale(15 * (1 - t), 16 * a / (2 * math.pi)) * smoothstep(0.62, 0.4, t)
        size = 1 + brow + nostril + wrinkle + bumps
        return 1.05 * size, size * (0.72 if back < 0 else 1.0)

    skull = ((0.55, -0.05, 0, 0.34), (0.0, 0.05, 0, 0.56), (-0.45, 0.10, 0, 0.58), (-0.85, 0.06, 0, 0.46), (-1.3, 0.0, 0, 0.35),
             (-1.75, 0.02, 0, 0.33), (-2.02, 0.0, 0, 0.20))
    jaw = ((0.25, -0.25, 0, 0.30), (-0.2, -0.48, 0, 0.36), (-0.7, -0.66, 0, 0.31), (-1.2, -0.80, 0, 0.25), (-1.62, -0.84, 0, 0.19),
           (-1.78, -0.80, 0, 0.08))
    tongue = ((-0.3, -0.32, 0, 0.16), (-0.9, -0.46, 0, 0.16), (-1.5, -0.55, 0, 0.13), (-1.95, -0.42, 0, 0.05))
    parts = [sweep(skull, 100, 48, skull_shape), sweep(jaw, 50, 30, lambda t, a: (1.0, 0.55 + 0.03 * math.sin(40 * t))),
             sweep(tongue, 24, 16, lambda t, a: (1.0, 0.30))]
    for z in (-1, 1):
        # Eyes under the brows, teeth of both jaws, horns, ears, and a beard of barbs along the jaw.
        eye = (-0.42, 0.30, 0.44 * z)
        parts.append(sweep(((eye[0] + 0.15, *eye[1:], 0.02), (*eye, 0.15), (eye[0] - 0.15, *eye[1:], 0.02)), 16, 20))
        for i in range(9):
            x = mix(-0.72, -1.86, i / 8)
            size = 0.30 if i in (6, 7) else 0.17
            wide = 0.36 * smoothstep(-2.15, -1.0, x) + 0.02
            parts.append(spike((x, -0.16, wide * z), (x + 0.03, -0.18 - size, 0.98 * wide * z), 0.055, rings=5, sides=7))
            if i < 8:
                y = mix(-0.58, -0.76, i / 8)
                tip = (x + 0.04, y + 0.8 * size, 0.76 * wide * z)
                parts.append(spike((x + 0.07, y, 0.78 * wide * z), tip, 0.05, rings=5, sides=7))
        horn = ((0.0, 0.42, 0.28 * z, 0.17), (0.55, 0.85, 0.50 * z, 0.15), (1.25, 1.05, 0.72 * z, 0.115), (1.85, 1.38, 0.78 * z, 0.07),
                (2.2, 1.85, 0.74 * z, 0.012))
        parts.append(sweep(horn, 80, 14, lambda t, a: (1 + 0.09 * math.sin(120 * t), 1 + 0.09 * math.sin(120 * t))))
        branch = ((1.05, 1.0, 0.66 * z, 0.09), (1.3, 1.35, 0.86 * z, 0.06), (1.42, 1.72, 0.92 * z, 0.008))
        parts.append(sweep(branch, 24, 12))
        ear = ((0.2, 0.22, 0.46 * z, 0.10), (0.55, 0.34, 0.86 * z, 0.19), (0.98, 0.52, 1.12 * z, 0.02))
        parts.append(sweep(ear, 24, 16, lambda t, a: (0.35, 1.0)))
        for i in range(7):
            root = (mix(-0.45, 0.5, i / 6), mix(-0.5, 0.0, i / 6), 0.42 * z)
            tip = add(root, (0.55 + 0.12 * (i % 2), -0.22 + 0.05 * i, (0.26 + 0.05 * i) * z))
            parts.append(spike(root, tip, 0.10, (0, 0.06, 0.05 * z), flat=0.5, rings=9, sides=8))
        for i in range(5):
            root = (0.42, mix(-0.1, 0.42, i / 4), mix(0.48, 0.15, i / 4) * z)
            tip = add(root, (1.0 + 0.2 * (i % 2), 0.1 + 0.12 * i, mix(0.5, 0.1, i / 4) * z))
            parts.append(spike(root, tip, 0.13, (0, 0.12, 0.03 * z), flat=0.5, rings=10, sides=8))
        whisker = ((-1.72, 0.0, 0.26 * z, 0.055), (-1.95, -0.05, 0.75 * z, 0.048), (-1.6, 0.35, 1.3 * z, 0.04), (-0.9, 0.55, 1.7 * z, 0.03),
                   (-0.35, 0.15, 2.0 * z, 0.018), (0.25, 0.3, 2.25 * z, 0.003))
        parts.append(sweep(whisker, 70, 10, side=(0.3, 0.9, 0.2)))
    parts.append(spike((-1.2, 0.28, 0), (-1.32, 0.62, 0), 0.11, (0.06, 0, 0), flat=0.6))
    return parts


def turned(mesh, origin, yaw_deg, pitch_deg, size):
    """The mesh, scaled, then turned about y and tilted, at its place."""
    y, p = math.radians(yaw_deg), math.radians(pitch_deg)

    def turn(v):
        v = (v[0] * math.cos(p) - v[1] * math.sin(p), v[0] * math.sin(p) + v[1] * math.cos(p), v[2])
        return v[0] * math.cos(y) + v[2] * math.sin(y), v[1], -v[0] * math.sin(y) + v[2] * math.cos(y)

    positions, normals, uvs, triangles = mesh
    return [add(origin, scaled(turn(v), size)) for v in positions], [turn(n) for n in normals], uvs, triangles


def tail_fan():
    """Flat spikes about the tip of the tail."""
    here, _, along, _, up = frame(SPINE, 0.03)
    parts = []
    for k in range(-3, 4):
        turn = math.radians(24 * k)
        out = add(scaled(along, -math.cos(turn)), scaled(up, math.sin(turn)))
        size = 1.25 - 0.2 * abs(k)
        parts.append(spike(here, add(here, scaled(out, size)), 0.2, scaled(up, 0.03 * k), flat=0.35, rings=14, sides=12))
    return parts


def dragon(size=1.0):
    """The whole mesh."""
    looking = [turned(part, (-4.2, 6.5, 0.6), 32, 10, 1.12) for part in head()]
    positions, normals, uvs, triangles = joined([body(), *back_spines(), *tail_fan(), *legs(), *looking])
    return [scaled(p, size) for p in positions], normals, uvs, triangles
