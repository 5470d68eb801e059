"""The thesis's loop closing (5.2.4), a baseline: image differences alone, two corrections of odometry, no solver."""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from topomap.core.arrays import Complex64Array, FloatArray
from topomap.core.geometry import wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Motion
from topomap.vision.image.compare import PLACE, Signature, rms, rotation_differences, signature


class DifferenceRuleSettings(BaseModel, frozen=True, extra="forbid"):
    """When a view is kept and when a loop is closed."""

    threshold: float = Field(0.8, gt=0, description="summed difference between neighbouring views that keeps one")
    travel: float = Field(10.0, gt=0, description="way that must lie between a snapshot and its return [m]")


@dataclass(frozen=True, slots=True)
class RuleClosure:
    """Step `now` was taken where step `old` was; rotation [rad]: now's heading minus old's; difference: of the views;
    k_theta, k_d: the corrections of turns and distances between them.
    """

    now: int
    old: int
    rotation: float
    difference: float
    k_theta: float
    k_d: float


LEAST_TURN = math.radians(90.0)
"""K_theta = (sum of turns + what is left) / sum of turns means nothing where the robot hardly turned."""
MOST_CORRECTION = 0.3
"""A loop that wants a larger correction of turns or distances isn't corrected by a scale: its gap is only reset."""


class DifferenceRule:
    """Keeps a snapshot when differences have added up, closes when a kept one differs by less than half of that."""

    def __init__(self, settings: DifferenceRuleSettings | None = None) -> None:
        self._s = settings or DifferenceRuleSettings()
        self._distances: list[float] = []
        self._turns: list[float] = []
        self._path: FloatArray = np.zeros((0, 3))
        self._kept: list[int] = []
        self._kept_at: list[float] = []
        self._spectra: Complex64Array = np.empty((0, 0, 0), np.complex64)
        self._before: Signature | None = None
        self._sum = 0.0
        self._travelled: list[float] = []
        self.closures: list[RuleClosure] = []

    @property
    def path(self) -> FloatArray:
        """The path as corrected so far (N, 3) [m, rad], the first pose at the origin."""
        return self._path

    @property
    def kept(self) -> tuple[int, ...]:
        """The steps of the snapshots."""
        return tuple(self._kept)

    def advance(self, panorama: Panorama, motion: Motion) -> RuleClosure | None:
        """Take a step's view and increment; return the loop it closes, if it does."""
        seen = signature(panorama, PLACE)
        self._move(motion)
        closure = self._closed(seen)
        if closure is not None:
            self._correct(closure)
            self.closures.append(closure)
        self._sum += rms(seen, self._before) if self._before is not None else math.inf
        self._before = seen
        if self._sum > self._s.threshold:
            self._keep(seen)
        return closure

    def _keep(self, seen: Signature) -> None:
        """Keep a snapshot; the room for their spectra doubles, so that the next ones fit."""
        count, self._sum = len(self._kept), 0.0
        if count == len(self._spectra):
            room = np.empty((max(2 * count, 64), *seen.spectrum.shape), np.complex64)
            room[:count] = self._spectra if count else room[:0]
            self._spectra = room
        self._spectra[count] = seen.spectrum
        self._kept.append(len(self._path) - 1)
        self._kept_at.append(self._travelled[-1])

    def _move(self, motion: Motion) -> None:
        first = not len(self._path)
        # like the thesis, distance and turn; what slides sideways isn't modelled
        self._distances.append(0.0 if first else motion.forward)
        self._turns.append(0.0 if first else motion.turn)
        self._travelled.append((self._travelled[-1] if self._travelled else 0.0) + abs(self._distances[-1]))
        x, y, heading = (0.0, 0.0, 0.0) if first else self._path[-1]
        heading = heading + self._turns[-1]
        pose = (x + self._distances[-1] * math.cos(heading), y + self._distances[-1] * math.sin(heading), heading)
        self._path = np.vstack([self._path, pose])

    def _closed(self, seen: Signature) -> RuleClosure | None:
        """Return the closure with the most alike snapshot that lies far enough back."""
        now = len(self._path) - 1
        last = self.closures[-1].now if self.closures else 0
        if self.closures and self._travelled[now] - self._travelled[last] < 1.0:  # a pass is one closure a metre
            return None
        far = bisect.bisect_right(self._kept_at, self._travelled[now] - self._s.travel)
        if far == 0:
            return None
        compared = rotation_differences(seen, self._spectra[:far])
        best = int(compared.difference.argmin())
        difference, rotation = float(compared.difference[best]), float(compared.rotation[best])
        if difference >= 0.5 * self._s.threshold:
            return None
        old = self._kept[best]
        return RuleClosure(now, old, rotation, difference, *self._corrections(old, now, rotation))

    def _corrections(self, old: int, now: int, rotation: float) -> tuple[float, float]:
        """Return K_theta from the compass's residual, and K_D from the gap along the way that is left after it."""
        turned = float(np.sum(self._turns[old + 1 : now + 1]))
        left = wrap(rotation - turned)
        k_theta = (turned + left) / turned if abs(turned) >= LEAST_TURN else 1.0
        k_theta = k_theta if abs(k_theta - 1.0) <= MOST_CORRECTION else 1.0
        redone = self._redone(old, now, k_theta, 1.0)
        gap = redone[-1, :2] - self._path[old, :2]
        along = float(gap @ (math.cos(redone[-1, 2]), math.sin(redone[-1, 2])))
        driven = float(np.sum(self._distances[old + 1 : now + 1]))
        k_d = (driven - along) / driven if driven > 0.0 else 1.0
        return k_theta, k_d if abs(k_d - 1.0) <= MOST_CORRECTION else 1.0

    def _redone(self, old: int, now: int, k_theta: float, k_d: float) -> FloatArray:
        """Return the poses old .. now (M, 3) with turns and distances scaled, from the old pose on."""
        turns, distances = (np.array(v[old + 1 : now + 1]) for v in (self._turns, self._distances))
        headings = self._path[old, 2] + k_theta * np.cumsum(turns)
        steps = k_d * distances[:, np.newaxis] * np.column_stack([np.cos(headings), np.sin(headings)])
        places = self._path[old, :2] + np.cumsum(steps, axis=0)
        return np.vstack([self._path[old], np.column_stack([places, headings])])

    def _correct(self, closure: RuleClosure) -> None:
        """Rebuild the path between the two and set the robot to where it was before."""
        old, now = closure.old, closure.now
        redone = self._redone(old, now, closure.k_theta, closure.k_d)
        self._path[old : now + 1] = redone
        self._path[now] = (*self._path[old, :2], self._path[old, 2] + closure.rotation)
