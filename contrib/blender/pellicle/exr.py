"""Plain OpenEXR, for two things that Blender cannot do.

Its writer encodes by the image's colour space, and images that were painted or generated cannot have another one for a
moment. Its render engines can only load pictures with its own names of layers.
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np

_FLOAT, _UNCOMPRESSED, _TOP_FIRST = 2, 0, 0
_KINDS = {1: np.dtype("<f2"), 2: np.dtype("<f4")}
# Lines of a block, by the number of the compression: none, ZIPS, ZIP.
_BLOCK_LINES = {0: 1, 2: 1, 3: 16}


def write(path: Path, pixels: np.ndarray) -> None:
    """`pixels`: (height, width, 3), linear, the upper row first."""
    height, width, _ = pixels.shape
    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    channels = b"".join(name + b"\0" + struct.pack("<iiii", _FLOAT, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    attributes = [
        (b"channels", b"chlist", channels),
        (b"compression", b"compression", bytes([_UNCOMPRESSED])),
        (b"dataWindow", b"box2i", window),
        (b"displayWindow", b"box2i", window),
        (b"lineOrder", b"lineOrder", bytes([_TOP_FIRST])),
        (b"pixelAspectRatio", b"float", struct.pack("<f", 1.0)),
        (b"screenWindowCenter", b"v2f", struct.pack("<ff", 0.0, 0.0)),
        (b"screenWindowWidth", b"float", struct.pack("<f", 1.0)),
    ]
    header = struct.pack("<ii", 20000630, 2)
    for name, kind, value in attributes:
        header += name + b"\0" + kind + b"\0" + struct.pack("<i", len(value)) + value
    header += b"\0"
    row_bytes = 12 * width
    first = len(header) + 8 * height
    offsets = first + np.arange(height, dtype="<u8") * (8 + row_bytes)
    # Blue, green and red of a line lie after each other.
    planes = np.ascontiguousarray(pixels[:, :, ::-1].transpose(0, 2, 1), "<f4").reshape(height, -1)
    with open(path, "wb") as file:
        file.write(header + offsets.tobytes())
        for row, plane in enumerate(planes):
            file.write(struct.pack("<ii", row, row_bytes) + plane.tobytes())


def read(path: Path) -> np.ndarray:
    """(height, width, 4) of a picture that pellicle wrote: red, green, blue, alpha, the upper row first."""
    data = path.read_bytes()
    attributes, at = _attributes(data)
    left, top, right, bottom = struct.unpack("<iiii", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    channels = _channels(attributes["channels"])
    row = np.dtype([(name, kind, (width,)) for name, kind in channels])
    lines = _BLOCK_LINES[attributes["compression"][0]]
    picture = np.ones((height, width, 4), np.float32)
    for offset in np.frombuffer(data, "<u8", -(-height // lines), at).tolist():
        y, size = struct.unpack_from("<ii", data, offset)
        first, count = y - top, min(lines, height - (y - top))
        block = data[offset + 8 : offset + 8 + size]
        # Blocks that would grow are left as they are.
        rows = np.frombuffer(block if size == count * row.itemsize else _unzipped(block), row)
        for channel, name in enumerate("RGBA"):
            if name in row.names:
                picture[first : first + count, :, channel] = rows[name]
    return picture


def _attributes(data: bytes) -> tuple[dict[str, bytes], int]:
    """The header's values by name, and where it ends."""
    at, found = 8, {}
    while data[at]:
        name, at = _word(data, at)
        _, at = _word(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        found[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    return found, at + 1


def _channels(data: bytes) -> list[tuple[str, np.dtype]]:
    at, found = 0, []
    while data[at]:
        name, at = _word(data, at)
        found.append((name, _KINDS[struct.unpack_from("<i", data, at)[0]]))
        at += 16
    return found


def _word(data: bytes, at: int) -> tuple[str, int]:
    end = data.index(0, at)
    return data[at:end].decode(), end + 1


def _unzipped(block: bytes) -> bytes:
    """ZIP of OpenEXR: differences of bytes, the even ones before the odd ones."""
    differences = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
    differences[1:] -= 128
    packed = np.cumsum(differences).astype(np.uint8)
    plain = np.empty_like(packed)
    half = (len(packed) + 1) // 2
    plain[0::2], plain[1::2] = packed[:half], packed[half:]
    return plain.tobytes()
