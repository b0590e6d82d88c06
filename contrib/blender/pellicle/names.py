"""Ids for COLLADA: unique, and legal as XML names."""

from __future__ import annotations

import re
from collections.abc import Hashable


class Names:
    """Gives every key one id, and no two keys the same one."""

    def __init__(self) -> None:
        self._ids: dict[Hashable, str] = {}
        self._taken: set[str] = set()
        # The number that the next thing of a name gets.
        self._next: dict[str, int] = {}

    def of(self, key: Hashable, wanted: str) -> str:
        """The id of `key`, made from `wanted` when it is asked for the first time."""
        if key not in self._ids:
            base = name = legal(wanted)
            while name in self._taken:
                self._next[base] = self._next.get(base, 1) + 1
                name = f"{base}_{self._next[base]}"
            self._taken.add(name)
            self._ids[key] = name
        return self._ids[key]


def legal(name: str) -> str:
    """Letters of any script, digits, `_` and `-` stay; an id begins with a letter or `_`."""
    name = re.sub(r"[^\w-]", "_", name) or "_"
    return name if name[0].isalpha() or name[0] == "_" else f"_{name}"
