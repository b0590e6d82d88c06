"""Images of Blender: where they lie on a surface, their texels, and files of them beside the scene."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote
from xml.etree.ElementTree import Element

import bpy
import numpy as np

from . import exr, png
from .graph import Input, Output
from .names import Names
from .notes import Notes
from .texcoord import TexCoord

# What the renderer reads as it is, by Blender's names.
_SUFFIXES = {
    "PNG": ".png", "JPEG": ".jpg", "TARGA": ".tga", "TARGA_RAW": ".tga", "BMP": ".bmp", "TIFF": ".tif",
    "HDR": ".hdr", "OPEN_EXR": ".exr",
}  # fmt: skip
_LINEAR_SPACES = ("Non-Color", "Linear Rec.709", "Linear", "Raw", "Generic Data")
_WRAPS = {"REPEAT": "wrap", "EXTEND": "clamp", "CLIP": "border", "MIRROR": "mirror"}


@dataclass(frozen=True)
class Picture:
    image: bpy.types.Image
    texcoord: TexCoord
    wrap: str

    def place(self) -> tuple[TexCoord, str]:
        return self.texcoord, self.wrap


def picture_of(output: Output) -> Picture | None:
    """The image of an Image Texture node; `None` where it has none, or coordinates that are not from a UV map."""
    node = output.node
    texcoord = _texcoord(output.input("Vector"))
    if node.image is None or node.projection != "FLAT" or texcoord is None:
        return None
    return Picture(node.image, texcoord, _WRAPS[node.extension])


def _texcoord(socket: Input | None) -> TexCoord | None:
    source = socket.source() if socket is not None else None
    if source is None or (source.kind == "ShaderNodeTexCoord" and source.socket.name == "UV"):
        return TexCoord()
    if source.kind == "ShaderNodeUVMap":
        return TexCoord(source.node.uv_map or None)
    if source.kind == "ShaderNodeMapping" and source.node.vector_type == "POINT":
        inner = _texcoord(source.input("Vector"))
        values = [source.input(name) for name in ("Location", "Rotation", "Scale")]
        if inner is None or any(value is None or value.source() is not None for value in values):
            return None
        location, turn, scale = (value.default() for value in values)
        if any(abs(angle) > 1e-6 for angle in turn[:2]):
            return None
        return inner.mapped(location[:2], turn[2], scale[:2])
    return None


def colorspace(image: bpy.types.Image, notes: Notes) -> str:
    """`srgb` or `linear`."""
    name = image.colorspace_settings.name
    if name == "sRGB":
        return "srgb"
    if name not in _LINEAR_SPACES:
        notes.add(f"image `{image.name}`", f"its colour space {name} is read as linear Rec. 709")
    return "linear"


def linear_pixels(image: bpy.types.Image) -> np.ndarray:
    """(rows, columns, 4), the upper row first; colours linear."""
    columns, rows = image.size
    pixels = np.empty(rows * columns * 4, np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(rows, columns, 4)[::-1].astype(np.float64)
    if not image.is_float and image.colorspace_settings.name == "sRGB":
        rgb = pixels[:, :, :3]
        pixels[:, :, :3] = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return pixels


class Pictures:
    """The folder of images beside a scene file. Nothing is written before the first image."""

    def __init__(self, scene: Path, notes: Notes) -> None:
        self._folder = scene.with_name(f"{scene.stem}.textures")
        self._notes = notes
        self._names = Names()
        self._written: dict[tuple[str, int], str] = {}

    def copy(self, image: bpy.types.Image) -> str:
        """Puts the image there as it is, if its format can be read, else as PNG; the URI for the scene."""
        key = (image.name_full, 0)
        if key not in self._written:
            self._written[key] = self._copy(image)
        return self._written[key]

    def _copy(self, image: bpy.types.Image) -> str:
        if image.source in ("MOVIE", "SEQUENCE", "TILED"):
            self._notes.add(f"image `{image.name}`", f"of a {image.source.lower()} only one picture is written")
        suffix = _SUFFIXES.get(image.file_format)
        # What Blender decodes from floating-point files is linear; others keep their bytes and their colour space.
        decoded = image.is_float and image.colorspace_settings.name not in _LINEAR_SPACES
        whole = image.source == "FILE" and not image.is_dirty and suffix is not None and not decoded
        if whole and image.packed_file is not None:
            path, uri = self._place(image.name, suffix)
            path.write_bytes(image.packed_file.data)
            return uri
        file = Path(bpy.path.abspath(image.filepath_raw, library=image.library)) if image.filepath_raw else None
        if whole and file is not None and file.is_file():
            path, uri = self._place(file.stem, suffix)
            shutil.copyfile(file, path)
            return uri
        if not image.has_data and not len(image.pixels):
            self._notes.add(f"image `{image.name}`", "its file is missing: white is written")
            return self.bake(image.name, np.ones((1, 1, 3)))
        if image.is_float:
            path, uri = self._place(image.name, ".exr")
            exr.write(path, linear_pixels(image)[:, :, :3])
            return uri
        columns, rows = image.size
        pixels = np.empty(rows * columns * 4, np.float32)
        image.pixels.foreach_get(pixels)
        return self.bake(image.name, pixels.reshape(rows, columns, 4)[::-1])

    def bake(self, name: str, pixels: np.ndarray) -> str:
        """Writes texels as 16-bit PNG; the URI for the scene."""
        key = (name, hash(pixels.tobytes()))
        if key not in self._written:
            path, uri = self._place(name, ".png")
            png.write(path, pixels)
            self._written[key] = uri
        return self._written[key]

    def _place(self, name: str, suffix: str) -> tuple[Path, str]:
        self._folder.mkdir(parents=True, exist_ok=True)
        file = self._names.of(len(self._written), Path(name).stem) + suffix
        return self._folder / file, quote(f"{self._folder.name}/{file}")


def refer(element: Element, uri: str, picture: Picture) -> Element:
    """Points an element of ours at an image."""
    element.set("image", uri)
    if picture.texcoord.name():
        element.set("texcoord", picture.texcoord.name())
    if picture.wrap != "wrap":
        element.set("wrap", picture.wrap)
    return element
