"""When a map is to be solved: after how many nodes, and how much of a surprise."""

from __future__ import annotations

from pydantic import BaseModel, Field

LARGE = 500  # nodes and closures from which on a map is solved bit by bit, as a step is to stay within 50 ms
ALARM = 2.5  # [sigmas] in a large map, a closure further off than this asks for all: so is one true one in ten
GROWTH = 0.1  # share by which a large map grows between two solves of all: work per node then stays the same


class OptimisationSettings(BaseModel, frozen=True, extra="forbid"):
    """When the map is corrected."""

    every: int = Field(10, ge=1, description="nodes after which the map is solved though nothing surprising happened")
    surprise: float = Field(1.0, ge=0, description="a closure further off than this is solved at once [sigmas]")


class SolveDue:
    """Counts the nodes since a map, or the newest stretch of a large one, was solved, and hears of surprises."""

    def __init__(self, settings: OptimisationSettings) -> None:
        self._s = settings
        self._solved = self._whole = 0  # nodes when either was solved, when all was
        self._surprise = 0.0
        self._unfit = False

    def hear(self, sigmas: float) -> None:
        """Take how far off a new closure is."""
        self._surprise = max(self._surprise, sigmas)

    def found(self, unfit: bool) -> None:
        """Take whether a closure that no solve of all has heard of doesn't fit beside the newest stretch."""
        self._unfit = unfit

    def begin(self, nodes: int, whole: bool) -> None:
        """Count anew: a map of so many nodes, or its newest stretch, is being solved."""
        self._solved, self._surprise = nodes, 0.0
        if whole:
            self._whole, self._unfit = nodes, False

    def recall(self, nodes: int) -> None:
        """Take a loaded map of so many nodes for solved."""
        self._solved = self._whole = nodes

    def give_up(self, whole: bool) -> None:
        """Let what was being solved be due again."""
        if whole:
            self._whole = 0
        else:
            self._solved = 0

    def whole(self, nodes: int, large: bool) -> bool:
        """Return whether all of a map of so many nodes is due."""
        if not large:
            return self._surprise > self._s.surprise or nodes - self._solved >= self._s.every
        return self._unfit or self._surprise > ALARM or nodes > (1 + GROWTH) * self._whole

    def stretch(self, nodes: int) -> bool:
        """Return whether the newest stretch of a large map of so many nodes is due."""
        return nodes - self._solved >= self._s.every or self._surprise > self._s.surprise
