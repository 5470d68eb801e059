"""Stage times of a step."""

from __future__ import annotations

import time


class Stopwatch:
    """Collects milliseconds by stage name; what it measures is logged and never decides anything."""

    def __init__(self) -> None:
        self.laps: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, name: str) -> None:
        """End the stage `name`."""
        now = time.perf_counter()
        self.laps[name] = (now - self._last) * 1e3
        self._last = now
