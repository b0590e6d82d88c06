"""The camera: what its frame holds, and its lens."""

from __future__ import annotations

import math
from collections.abc import Callable
from xml.etree.ElementTree import Element, SubElement

import bpy
import numpy as np
from mathutils import Matrix

from . import watts
from .collada import technique, text
from .notes import Notes
from .numerals import real

# Directions between which the corners of an aperture cannot be told apart, radians.
_SAME_TURN = 0.01


def translate(
    identity: str, camera: bpy.types.Camera, matrix: Matrix, scene: bpy.types.Scene, meter: float, notes: Notes
) -> Element:
    """`matrix`: of its object, without scale."""
    note = lambda what, advice: notes.add(f"camera `{camera.name}`: {what}", advice)  # noqa: E731
    element = Element("camera", id=identity, name=camera.name)
    optics = SubElement(SubElement(element, "optics"), "technique_common")
    low, high = frame(camera, scene)
    half = 0.5 * (high - low)
    if camera.type == "ORTHO":
        projection = SubElement(optics, "orthographic")
        text(projection, "xmag", real(half[0]), sid="xmag")
        text(projection, "ymag", real(half[1]), sid="ymag")
    else:
        if camera.type == "PANO":
            note("a panorama", "is written as a perspective picture")
        projection = SubElement(optics, "perspective")
        text(projection, "xfov", real(math.degrees(2.0 * math.atan(half[0]))), sid="xfov")
        text(projection, "yfov", real(math.degrees(2.0 * math.atan(half[1]))), sid="yfov")
    text(projection, "znear", real(camera.clip_start))
    text(projection, "zfar", real(camera.clip_end))
    _shift(element, low + half, half, scene)
    if camera.dof.use_dof and camera.type != "ORTHO":
        technique(element, [_lens(camera, matrix, meter, note)])
    elif camera.dof.use_dof:
        note("depth of field of a parallel projection", "everything is sharp")
    return element


def frame(camera: bpy.types.Camera, scene: bpy.types.Scene) -> tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right of the picture at unit distance (perspective) or in units, by Blender's own account of
    sensor, fit, shift, size and pixel aspect."""
    corners = np.array([corner[:] for corner in camera.view_frame(scene=scene)])
    flat = corners[:, :2] if camera.type == "ORTHO" else corners[:, :2] / -corners[:, 2:]
    return flat.min(axis=0), flat.max(axis=0)


def _shift(element: Element, middle: np.ndarray, half: np.ndarray, scene: bpy.types.Scene) -> None:
    """The renderer takes shifts as shares of the longer side, counted in pixels."""
    size = np.array([scene.render.resolution_x, scene.render.resolution_y], np.float64)
    shift = middle / (2.0 * half) * size / size.max()
    if np.abs(shift).max() > 1e-7:
        children = [Element("shiftx"), Element("shifty")]
        for child, value in zip(children, shift):
            child.text = real(value)
        technique(element, children, "blender")


def _lens(camera: bpy.types.Camera, matrix: Matrix, meter: float, note: Callable[[str, str], None]) -> Element:
    dof = camera.dof
    distance = dof.focus_distance
    if dof.focus_object is not None:
        target = dof.focus_object.matrix_world.translation
        distance = abs((matrix.inverted() @ target).z)
    lens = Element("lens")
    lens.set("aperture_radius_m", real(watts.aperture_radius(camera.lens, dof.aperture_fstop) * meter))
    lens.set("focus_distance_m", real(max(distance, 1e-5) * meter))
    blades = dof.aperture_blades
    if blades >= 3:
        lens.set("blades", str(min(blades, 64)))
        # The renderer's apertures have a corner at the top, Blender's one at the right.
        turn = (dof.aperture_rotation - 0.5 * math.pi) / (2.0 * math.pi / blades)
        if abs(turn - round(turn)) > _SAME_TURN:
            note("the direction of the aperture's corners", "one is at the top")
    if dof.aperture_ratio != 1.0:
        note(f"an aperture of ratio {dof.aperture_ratio:.3g}", "is written round")
    return lens
