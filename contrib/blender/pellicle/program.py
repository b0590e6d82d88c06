"""Runs `pellicle` and listens to its progress."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import threading
from collections.abc import Sequence
from pathlib import Path

# Lines of the program's messages that are kept for a report.
_KEPT_LINES = 40


class ProgramMissing(Exception):
    """The renderer is not where it was looked for."""


def find(preferred: str = "") -> str:
    """The program's path: the one of the preferences, else from PATH."""
    if preferred:
        path = Path(preferred).expanduser()
        if not (path.is_file() and os.access(path, os.X_OK)):
            raise ProgramMissing(f"`{path}` is no program: correct the path in the add-on's preferences")
        return str(path)
    found = shutil.which("pellicle")
    if found is None:
        advice = "`cargo install --path .` puts it there, or set its path in the preferences"
        raise ProgramMissing(f"`pellicle` is not on PATH: {advice}")
    return found


class Run:
    """A render under way. Reading happens in a thread of its own, so that `share` and `state` never wait."""

    def __init__(self, command: Sequence[str]) -> None:
        self.share = 0.0
        self.state = "starting"
        self.messages: list[str] = []
        self._process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace")
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        for line in self._process.stderr or ():
            self.hear(line.rstrip())

    def hear(self, line: str) -> None:
        """Takes one line of the program's messages."""
        progress = parse(line)
        if progress is None:
            self.messages = [*self.messages, line][-_KEPT_LINES:]
        else:
            self.share = float(progress["done"])
            self.state = f"{progress['spp']:.0f} samples, about {progress['left_s']:.0f} s left"

    def running(self) -> bool:
        return self._process.poll() is None

    def cancel(self) -> None:
        """The program writes the picture as far as it is, and ends."""
        if self.running():
            self._process.send_signal(signal.SIGINT if os.name == "posix" else signal.SIGTERM)

    def finish(self) -> int:
        """Waits for the end; the program's exit code."""
        code = self._process.wait()
        self._reader.join()
        if self._process.stderr:
            self._process.stderr.close()
        return code


def parse(line: str) -> dict[str, float] | None:
    """A line of `--progress json`; `None` for any other."""
    if not line.startswith("{"):
        return None
    try:
        progress = json.loads(line)
    except json.JSONDecodeError:
        return None
    return progress if {"done", "spp", "left_s"} <= progress.keys() else None


def render_command(program: str, scene: str, picture: str, options: Sequence[str] = ()) -> list[str]:
    return [program, "render", scene, "-o", picture, "--progress", "json", *options]
