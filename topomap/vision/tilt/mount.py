"""How a camera's mount leans, learnt from all its views; and how the body under it sways, where it does.

A view's own reading errs by what hangs askew in it, and errs alike as long as the same things are in view; as the robot
turns and goes on, that averages out, and what remains is the mount. Nothing is done below a quarter of a degree, nor
where the views don't agree: a camera that stands upright is left alone to the bit.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.panorama import Panorama
from topomap.core.records import MountLean
from topomap.vision.tilt.lean import UPRIGHT, Lean
from topomap.vision.tilt.upright import upright
from topomap.vision.tilt.verticals import LeanReading, lean_of

EVERY, FIRST = 4, 8
"""Views are read one in so many, and the first ones all: 0.4 m on, most of what stands in view is the same."""
MOST = 600  # readings that are kept: 240 m at 0.1 m a step
ALIKE = 15
"""Readings that err alike, as many as 6 m have: in rooms and grass their means err as those of so many fewer."""
TOO_VAGUE = math.radians(1.0)
"""[rad] A reading that errs by more says nothing: those of rooms err by 0.1 to 0.2 degrees, of grass by 0.3."""
HIDDEN = 3.0
"""What readings say that they err is to be taken so many times: 0.3 to 3.4 in rooms, grass and photographs."""
FLOOR = math.radians(0.1)
"""[rad] What many readings may err by together: found means lie 0.0 to 0.1 degrees off."""
LEAST, CLEAR, FAINT = math.radians(0.25), 3.0, 2.0
"""[rad] A lean that is taken out is at least so large, and so many sigmas; of fewer it is left alone again, and so many
it has to be off before it is stated anew."""
SURER = 0.7  # share of its former error from which on a lean is stated anew where it is off by a quarter of a degree
SWAYS, STILL = math.radians(0.4), math.radians(0.3)
"""[rad] A body sways where readings differ so much from one to the next, and doesn't any more where they differ by
less: what hangs askew stays in view, so that those of a camera that stands still differ by 0.2 in rooms ..."""
SHARP = math.radians(0.3)
"""[rad] ... and sharp ones alone can tell: those of grass differ by 0.3 to 0.7, of small photographs by 1.7 to 2.6, and
say themselves that they err by 0.4 and 0.7."""
MOSTLY = (0.8, 1.2816)  # four steps of five are within this many sigmas: what remains are jolts and misreadings
LATELY, ENOUGH = 60, 15  # readings by which that is told, and the fewest


@dataclass(frozen=True, slots=True)
class Taken:
    """One view: what it said of its lean (None: wasn't asked, or saw nothing upright), and what was taken out."""

    said: LeanReading | None
    lean: Lean


class Mount:
    """Reads views one after the other; `see` returns what is to be taken out of each.

    lean: the mount's own, as it is taken out now; restated: whether that changed with the last view.
    """

    def __init__(self, every: int = EVERY, before: Lean = UPRIGHT) -> None:
        """every: one in so many views is read, once the first ones are; before: how it leant when it was seen last."""
        self._every = every
        self.lean = before if before.size >= LEAST else UPRIGHT
        self.restated = False
        self._sigma = self._sway = 0.0
        self._seen = 0
        self._spaced: deque[tuple[float, float]] = deque(maxlen=LATELY)
        self._leans: list[tuple[float, float]] = []
        self._variances: list[float] = []

    def see(self, raw: Panorama) -> Taken:
        """Learn from a view as the camera took it, and return what to take out of it."""
        self.restated = False
        due = self._seen < FIRST or self._seen % self._every == 0
        said = self._said(raw) if due or self._sway > 0.0 else None
        self._seen += 1
        if said is not None and due:
            self._learn(said, self._seen % self._every == 1 % self._every)
        return Taken(said, self.lean_at(said))

    def lean_at(self, said: LeanReading | None) -> Lean:
        """Return what to take out of a view that said so: the mount's lean, and of the rest as much as is sway."""
        if said is None or self._sway == 0.0:
            return self.lean
        share = self._sway**2 / (self._sway**2 + said.sigma**2)
        own = said.lean - self.lean
        return self.lean + Lean(share * own.roll, share * own.pitch)

    @property
    def estimate(self) -> MountLean | None:
        """What is known of the mount, None where too few views showed anything upright."""
        if len(self._leans) < FIRST:
            return None
        mean, sigma = self._mean()
        taken = self.lean != UPRIGHT or self._sway > 0.0
        return MountLean(float(mean[0]), float(mean[1]), sigma, self._sway, taken)

    def _said(self, raw: Panorama) -> LeanReading | None:
        # read in the view as it is taken upright: what lies near zero is read exactly, more is read a tenth too small
        rest = lean_of(upright(raw, self.lean))
        if rest is None or rest.sigma > TOO_VAGUE:
            return None
        return LeanReading(rest.lean + self.lean, rest.covariance)

    def _learn(self, said: LeanReading, spaced: bool) -> None:
        """Take a reading; spaced: so far from the last one that told as the others."""
        if spaced:
            self._spaced.append((said.lean.roll, said.lean.pitch))
        self._leans.append((said.lean.roll, said.lean.pitch))
        self._variances.append(float(np.trace(said.covariance)) / 2.0)
        del self._leans[:-MOST], self._variances[:-MOST]
        if len(self._leans) < FIRST:
            return
        mean, sigma = self._mean()
        sway = self._swaying()
        lean = self._stated(Lean(float(mean[0]), float(mean[1])), sigma)
        if lean != self.lean or (sway > 0.0) != (self._sway > 0.0):
            self.restated = True
            self.lean, self._sigma = lean, sigma
        self._sway = sway

    def _stated(self, found: Lean, sigma: float) -> Lean:
        """Return the lean that is taken out from now on: the one that was, unless what was found speaks against it."""
        if self.lean == UPRIGHT:
            return found if found.size >= max(LEAST, CLEAR * sigma) else UPRIGHT
        if found.size < max(LEAST, FAINT * sigma):
            return UPRIGHT
        surer = sigma < SURER * self._sigma
        off = (found - self.lean).size
        return found if off >= (LEAST if surer else max(LEAST, FAINT * sigma)) else self.lean

    def _swaying(self) -> float:
        """Return how far the body leans besides the mount [rad], 0 where it doesn't."""
        if len(self._spaced) < ENOUGH or self._sharp() > SHARP:
            return 0.0
        steps = np.abs(np.diff(np.array(self._spaced), axis=0))
        flicker = float(np.quantile(steps, MOSTLY[0], axis=0).max()) / (MOSTLY[1] * math.sqrt(2.0))
        return flicker if flicker > (STILL if self._sway > 0.0 else SWAYS) else 0.0

    def _sharp(self) -> float:
        """Return what the middle one of the readings says that it errs [rad]."""
        return math.sqrt(float(np.median(self._variances)))

    def _mean(self) -> tuple[FloatArray, float]:
        """Return the robust mean (2,) of the readings, and how far it may be off [rad]."""
        leans, own = np.array(self._leans), np.array(self._variances)
        mean = np.median(leans, axis=0)
        spread = float(1.4826 * np.median(np.abs(leans - mean), axis=0).max())
        weight = 1.0 / (own + spread**2)
        for _ in range(2):
            far = np.square(leans - mean).sum(axis=1) * weight
            robust = weight / np.square(1.0 + far / 8.0)
            mean = (robust[:, np.newaxis] * leans).sum(axis=0) / robust.sum()
        apart = max(len(leans) / ALIKE, 1.0)
        error = math.sqrt(max(spread, HIDDEN * self._sharp()) ** 2 / apart + FLOOR**2)
        return mean, error
