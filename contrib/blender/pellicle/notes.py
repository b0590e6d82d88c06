"""What an export could not say in our format, by name, so that nothing is dropped in silence."""

from __future__ import annotations


class Notes:
    """Remarks in the order in which they came up, each once."""

    def __init__(self) -> None:
        self._lines: dict[str, None] = {}

    def add(self, what: str, advice: str) -> None:
        """`what` names the thing, such as "material `Gold`: anisotropy"; `advice` says what is written instead."""
        self._lines[f"{what}: {advice}"] = None

    def lines(self) -> list[str]:
        return list(self._lines)
