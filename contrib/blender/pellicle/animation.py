"""What changes from frame to frame, as COLLADA channels.

Every frame is a list of all numbers that the renderer lets animations drive, found in the finished elements by the paths
that its channels use. Those that change get a channel; whatever else changes is noted.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from .collada import PROFILE, VISUAL_SCENE, matrix_source, name_source, source
from .names import legal
from .notes import Notes

# Paths below an element's id that channels may drive.
_DRIVEN = re.compile(
    r"transform|color|xfov|yfov|xmag|ymag|lens/(focus_distance_m|aperture_radius_m)"
    r"|roughness|reflectance|absorption_per_m|radiance"
    r"|film(\(\d+\))?/(thickness_nm|weight|ior|noise/amplitude|map/(min_nm|max_nm))"
    r"|environment/(radiance|strength|rotation_deg)"
)

Values = dict[str, tuple[float, ...]]


def values(element: Element) -> Values:
    """All numbers of a node, light, camera, effect or visual scene, by target."""
    identity = element.get("id", "")
    found: Values = {}
    for child in element.iter():
        if child.tag in ("matrix", "color", "xfov", "yfov", "xmag", "ymag", "shiftx", "shifty"):
            name = child.get("sid") or child.tag
            found[f"{identity}/{name}"] = _numbers(child.text or "")
    for technique in element.findall(f"extra/technique[@profile='{PROFILE}']"):
        for child in technique:
            # The base of an effect has no name of its own in a target.
            prefix = identity if element.tag == "effect" else f"{identity}/{child.tag}"
            found.update(_attributes(child, prefix))
    return found


def _attributes(element: Element, prefix: str) -> Iterator[tuple[str, tuple[float, ...]]]:
    for name, text in element.attrib.items():
        numbers = _numbers(text)
        if numbers:
            yield f"{prefix}/{name}", numbers
    films = 0
    for child in element:
        name = child.tag
        if name == "film":
            name = f"film({films})" if films else "film"
            films += 1
        yield from _attributes(child, f"{prefix}/{name}")


def _numbers(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(word) for word in text.split())
    except ValueError:
        return ()


def channels(frames: Sequence[Values], times_s: Sequence[float], notes: Notes) -> list[Element]:
    """One `<animation>` for every target that changes."""
    animations = []
    for target, first in frames[0].items():
        rows = [frame.get(target) for frame in frames]
        present = [row for row in rows if row is not None and len(row) == len(first)]
        if len(present) < len(rows):
            notes.add(f"`{target}`", "is not there in every frame: the film or object stays as at the first one")
        elif any(row != first for row in present):
            path = target.split("/", 1)[1]
            if _DRIVEN.fullmatch(path) and not (target.startswith(VISUAL_SCENE) and "image" in path):
                animations.append(_animation(target, np.asarray(times_s), np.asarray(present)))
            else:
                notes.add(f"`{target}`", "changes over time, which the renderer cannot do: it stays as at the first frame")
    return animations


def _animation(target: str, times_s: np.ndarray, rows: np.ndarray) -> Element:
    # A key between two equal ones says nothing.
    same = np.all(rows[1:] == rows[:-1], axis=1)
    kept = np.ones(len(rows), bool)
    kept[1:-1] = ~(same[:-1] & same[1:])
    times_s, rows = times_s[kept], rows[kept]
    identity = legal(target.replace("/", "-"))
    element = Element("animation", id=f"{identity}-animation")
    element.append(source(f"{identity}-input", times_s, ["TIME"], 9))
    if rows.shape[1] == 16:
        element.append(matrix_source(f"{identity}-output", rows))
    else:
        element.append(source(f"{identity}-output", rows, "RGBA"[: rows.shape[1]], 9))
    element.append(name_source(f"{identity}-interpolation", ["LINEAR"] * len(times_s)))
    sampler = SubElement(element, "sampler", id=f"{identity}-sampler")
    for semantic in ("INPUT", "OUTPUT", "INTERPOLATION"):
        SubElement(sampler, "input", semantic=semantic, source=f"#{identity}-{semantic.lower()}")
    SubElement(element, "channel", source=f"#{identity}-sampler", target=target)
    return element
