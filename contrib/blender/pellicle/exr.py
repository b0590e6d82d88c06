"""Writes plain OpenEXR: 32-bit red, green and blue, scan line by scan line.

Blender's own writer encodes by the image's colour space, and images that were painted or generated cannot have another one
for a moment.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

_FLOAT, _UNCOMPRESSED, _TOP_FIRST = 2, 0, 0


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
