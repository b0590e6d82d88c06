"""Writes 16-bit PNG, which Blender can only write through its render settings."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np

_COLOUR_TYPES = {1: 0, 3: 2, 4: 6}


def write(path: Path, pixels: np.ndarray) -> None:
    """`pixels`: (height, width, 1, 3 or 4), 0..1, the upper row first."""
    height, width, channels = pixels.shape
    samples = np.round(np.clip(pixels, 0.0, 1.0) * 65535.0).astype(">u2").reshape(height, -1)
    # Each row begins with its filter; 2 means differences to the row above.
    rows = samples.view(np.uint8).reshape(height, -1)
    differences = rows.copy()
    differences[1:] -= rows[:-1]
    filtered = np.concatenate([np.full((height, 1), 2, np.uint8), differences], axis=1)
    header = struct.pack(">IIBBBBB", width, height, 16, _COLOUR_TYPES[channels], 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(filtered.tobytes(), 6)), (b"IEND", b"")]
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        for kind, data in chunks:
            file.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))
