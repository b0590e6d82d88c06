"""Numbers as text, fast for arrays of millions."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

# Values that are formatted at once: few enough for their text to stay in the cache.
_CHUNK = 1 << 14


def real(value: float, digits: int = 9) -> str:
    """One number; nine digits tell every 32-bit float from its neighbours."""
    return f"{value:.{digits}g}"


def reals(values: Iterable[float], digits: int = 9) -> str:
    """Numbers with spaces between them."""
    numbers = np.asarray(values, dtype=np.float64).ravel()
    return _joined(numbers, f"%.{digits}g ")


def wholes(values: np.ndarray) -> str:
    """Whole numbers with spaces between them."""
    return _joined(np.asarray(values).ravel(), "%d ")


def _joined(numbers: np.ndarray, pattern: str) -> str:
    pieces = []
    for start in range(0, len(numbers), _CHUNK):
        chunk = numbers[start : start + _CHUNK].tolist()
        pieces.append((pattern * len(chunk)) % tuple(chunk))
    return "".join(pieces).rstrip()
