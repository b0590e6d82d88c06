"""Vectors as tuples, and repeatable noise."""

import functools
import math


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def scaled(a, s):
    return tuple(x * s for x in a)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(sum(x * x for x in a))
    return scaled(a, 1 / length) if length else a


def mix(a, b, t):
    return a + (b - a) * t


def smoothstep(low, high, x):
    t = min(max((x - low) / (high - low), 0), 1)
    return t * t * (3 - 2 * t)


def numbers(values, digits=4):
    """Numbers as short text: no trailing zeros, no minus zero."""
    return " ".join("%g" % (round(x, digits) + 0.0) for x in values)


# Noise

@functools.lru_cache(maxsize=1 << 18)
def lattice(x, y, z, seed):
    """A repeatable number in [-1, 1] for a lattice point."""
    h = (x * 374761393 + y * 668265263 + z * 2147483647 + seed * 974634777) & 0xFFFFFFFF
    h = ((h ^ (h >> 13)) * 1274126177) & 0xFFFFFFFF
    h = ((h ^ (h >> 16)) * 2246822519) & 0xFFFFFFFF
    return ((h ^ (h >> 15)) & 0xFFFF) / 32767.5 - 1


def noise(p, seed=0):
    """Smooth value noise in [-1, 1] at a 3-D point."""
    x, y, z = math.floor(p[0]), math.floor(p[1]), math.floor(p[2])
    u, v, w = p[0] - x, p[1] - y, p[2] - z
    u, v, w = u * u * (3 - 2 * u), v * v * (3 - 2 * v), w * w * (3 - 2 * w)
    row = lambda j, k: mix(lattice(x, y + j, z + k, seed), lattice(x + 1, y + j, z + k, seed), u)
    return mix(mix(row(0, 0), row(1, 0), v), mix(row(0, 1), row(1, 1), v), w)


def fractal(p, octaves, seed=0):
    """Octaves of noise, each twice as fine and half as strong as the one before."""
    return sum(noise(scaled(p, 2 ** i), seed + i) / 2 ** i for i in range(octaves))


def swirled(p, strength, octaves, seed):
    """Fractal noise at a point that other noise has pushed aside: the look of stirred liquid."""
    push = [strength * fractal(p, 3, seed + 10 * axis) for axis in (1, 2, 3)]
    return fractal(add(p, push), octaves, seed)
