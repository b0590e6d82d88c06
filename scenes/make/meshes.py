"""Meshes: (positions, normals, texture coordinates or [], triangles)."""

import math

from .vectors import add, cross, fractal, mix, noise, scaled, sub, unit


def smooth(rows, normal=None):
    """A surface through a grid of points. Equal points are welded, so closed directions and poles need no care.
    Counter-clockwise seen from outside means: along a row, then to the next row."""
    index, positions, triangles = {}, [], []
    for row in rows:
        for point in row:
            key = tuple(round(x, 5) + 0.0 for x in point)
            if key not in index:
                index[key] = len(positions)
                positions.append(key)
    ids = [[index[tuple(round(x, 5) + 0.0 for x in point)] for point in row] for row in rows]
    for low, high in zip(ids, ids[1:]):
        for a, b, c, d in zip(low, low[1:], high[1:], high):
            triangles += [t for t in ((a, b, c), (a, c, d)) if len(set(t)) == 3]
    if normal:
        return positions, [unit(normal(p)) for p in positions], [], triangles
    sums = [(0, 0, 0)] * len(positions)
    for t in triangles:
        a, b, c = (positions[i] for i in t)
        face = cross(sub(b, a), sub(c, a))
        for i in t:
            sums[i] = add(sums[i], face)
    return positions, [unit(s) for s in sums], [], triangles


def joined(meshes):
    """Several meshes as one, edges between them staying sharp."""
    positions, normals, triangles = [], [], []
    for mesh in meshes:
        triangles += [tuple(i + len(positions) for i in t) for t in mesh[3]]
        positions += mesh[0]
        normals += mesh[1]
    return positions, normals, [], triangles


def lathe(*profiles, sides=96):
    """Profiles of (radius, height), upwards on the outside, turned about y; an edge is sharp between two profiles."""
    turns = [-2 * math.pi * (i % sides) / sides for i in range(sides + 1)]
    ring = lambda r, y: [(r * math.cos(t), y, r * math.sin(t)) for t in turns]
    return joined([smooth([ring(r, y) for r, y in profile]) for profile in profiles])


def arc(centre, radius, start_deg, end_deg, steps):
    """Points on a circle in the plane, for profiles."""
    angles = [math.radians(mix(start_deg, end_deg, i / steps)) for i in range(steps + 1)]
    return [(centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in angles]


def cap(radius, angle_deg, rings=64, sides=160):
    """The part of a sphere about the origin within an angle of +y."""
    profile = [(max(r, 0), y) for r, y in arc((0, 0), radius, 90 - angle_deg, 90, rings)]
    turns = [-2 * math.pi * (i % sides) / sides for i in range(sides + 1)]
    return smooth([[(r * math.cos(t), y, r * math.sin(t)) for t in turns] for r, y in profile], normal=lambda p: p)


def globe(radius, columns=128, rows=64):
    """A sphere with texture coordinates: u around y, v from bottom to top."""
    directions, uvs, triangles = [], [], []
    for j in range(rows + 1):
        for i in range(columns + 1):
            polar, turn = math.pi * j / rows, -2 * math.pi * (i % columns) / columns
            directions.append((math.sin(polar) * math.cos(turn), -math.cos(polar), math.sin(polar) * math.sin(turn)))
            uvs.append((i / columns, j / rows))
    for j in range(rows):
        for i in range(columns):
            a = j * (columns + 1) + i
            c = a + columns + 2
            triangles += ([] if j == 0 else [(a, a + 1, c)]) + ([] if j == rows - 1 else [(a, c, c - 1)])
    return [scaled(d, radius) for d in directions], directions, uvs, triangles


def rectangle(width, depth):
    """Flat, in the xz plane, facing up."""
    x, z = width / 2, depth / 2
    corners = [(-x, 0, z), (x, 0, z), (x, 0, -z), (-x, 0, -z)]
    return corners, [(0, 1, 0)] * 4, [(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)]


def backdrop(width, depth, height, bend):
    """A floor that curves up into a wall, as in a photographer's studio."""
    curve = [(0, 0)] + arc((depth - bend, bend), bend, -90, 0, 24) + [(depth, height)]
    return smooth([[(-width / 2, y, -z), (width / 2, y, -z)] for z, y in curve])


def pillow(width, height, depth, power, columns=96, rows=48):
    """A box rounded to |x|^power + |y|^power + |z|^power = 1: 2 is an ellipsoid, more comes nearer to the box."""
    halves = (width / 2, height / 2, depth / 2)
    directions, uvs, triangles = globe(1, columns, rows)[1:]
    points = [scaled(d, sum(abs(x) ** power for x in d) ** (-1 / power)) for d in directions]
    slope = lambda x, half: math.copysign(abs(x) ** (power - 1), x) / half
    normals = [unit(tuple(map(slope, p, halves))) for p in points]
    return [tuple(x * half for x, half in zip(p, halves)) for p in points], normals, uvs, triangles


def pebble(radius, seed, squash, columns=48, rows=24):
    """A rounded stone resting near y = 0."""
    def point(direction):
        bump = 1 + 0.22 * noise(scaled(direction, 1.3), seed) + 0.05 * fractal(scaled(direction, 4), 3, seed + 5)
        x, y, z = scaled(direction, radius * bump)
        return x, y * squash, z
    directions = globe(1, columns, rows)[1]
    per_row = columns + 1
    return smooth([[point(d) for d in directions[j * per_row:(j + 1) * per_row]] for j in range(rows + 1)])


def sheet(point, columns, rows, flip=False):
    """A surface from point(u, v), both 0..1, with texture coordinates. It faces the side from which u x v points."""
    def normal(u, v):
        e = 1e-4
        # Differences that stay inside, one-sided at the borders.
        du = sub(point(min(u + e, 1), v), point(max(u - e, 0), v))
        dv = sub(point(u, min(v + e, 1)), point(u, max(v - e, 0)))
        return unit(cross(dv, du) if flip else cross(du, dv))

    places = [(i / columns, j / rows) for j in range(rows + 1) for i in range(columns + 1)]
    triangles = []
    for j in range(rows):
        for i in range(columns):
            a = j * (columns + 1) + i
            b, c, d = a + 1, a + columns + 2, a + columns + 1
            triangles += [(a, c, b), (a, d, c)] if flip else [(a, b, c), (a, c, d)]
    return [point(u, v) for u, v in places], [normal(u, v) for u, v in places], places, triangles


def part_of(mesh, triangles):
    """Some triangles of a mesh with the points that they need."""
    used = sorted({corner for triangle in triangles for corner in triangle})
    new = {old: i for i, old in enumerate(used)}
    *points, _ = mesh
    return (*([values[old] for old in used] for values in points), [tuple(new[corner] for corner in triangle) for triangle in triangles])
