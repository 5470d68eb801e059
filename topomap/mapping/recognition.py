"""Place search: which older node looks most like the current view, and when it looked most alike."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from topomap.geometry import FloatArray
from topomap.types import PlaceMatch
from topomap.vision.compare import SignatureBank, signature
from topomap.vision.panorama import Panorama


class RecognitionSettings(BaseModel, frozen=True, extra="forbid"):
    """When a place is proposed as seen before."""

    min_travel: float = Field(8.0, gt=0, description="way since a node before it can be seen again [m]")
    threshold: float = Field(0.9, gt=0, description="image difference above which nothing is proposed")
    lag: int = Field(2, ge=1, description="steps to either side over which the difference has its minimum")
    shortlist: int = Field(8, ge=1, description="most similar nodes that are compared in detail")
    pause: float = Field(0.3, ge=0, description="way between proposals [m]")


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """One step as place search saw it: stamp, raw odometer way [m], view, and difference and rotation [rad] (N,) to
    the snapshots so far (infinite where they are too recent)."""

    stamp_ns: int
    travel: float
    panorama: Panorama
    difference: FloatArray
    rotation: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """A moment at which the best older place looked most alike, and the nodes to compare it with, best first."""

    moment: Moment
    shortlist: tuple[PlaceMatch, ...]


class Recognition:
    """Compares every view with all older snapshots at all rotations, and proposes at local minima."""

    def __init__(self, settings: RecognitionSettings) -> None:
        self._s = settings
        self._bank = SignatureBank()
        self._nodes: list[int] = []
        self._travel: list[float] = []
        self._recent: deque[Moment] = deque(maxlen=2 * settings.lag + 1)
        self._last_proposal = -np.inf

    def add(self, node: int, travel: float, panorama: Panorama) -> None:
        """Make a snapshot node findable; `travel` is the raw odometer way at it [m]."""
        self._bank.add(signature(panorama))
        self._nodes.append(node)
        self._travel.append(travel)

    def update(self, stamp_ns: int, travel: float, panorama: Panorama) -> PlaceMatch | None:
        """Take this step's view; return the most similar older node, if there is any."""
        # the snapshots are in travel order: only a head of the bank is old enough
        old = int(np.searchsorted(self._travel, travel - self._s.min_travel, side="right"))
        found = self._bank.compare(signature(panorama), old)
        self._recent.append(Moment(stamp_ns, travel, panorama, found.difference.astype(float), found.rotation))
        return self._match(self._recent[-1], int(np.argmin(found.difference))) if old else None

    def proposal(self) -> Proposal | None:
        """Return the moment `lag` steps ago if the view was then most like an older place, once a pass."""
        if len(self._recent) < 2 * self._s.lag + 1:
            return None
        moment = self._recent[self._s.lag]
        if not len(moment.difference) or moment.travel - self._last_proposal < self._s.pause:
            return None
        best = int(np.argmin(moment.difference))
        if moment.difference[best] > self._s.threshold or not self._is_minimum(best):
            return None
        self._last_proposal = moment.travel
        order = np.argsort(moment.difference, kind="stable")[: self._s.shortlist]
        return Proposal(moment, tuple(self._match(moment, int(i)) for i in order))

    def _is_minimum(self, index: int) -> bool:
        curve = [m.difference[index] if index < len(m.difference) else np.inf for m in self._recent]
        return int(np.argmin(curve)) == self._s.lag

    def _match(self, moment: Moment, index: int) -> PlaceMatch:
        return PlaceMatch(self._nodes[index], float(moment.difference[index]), float(moment.rotation[index]))
