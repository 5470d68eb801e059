"""How a camera's mount leans, learnt from all its views; and how the body under it sways, where it does.

A view's own reading errs by what hangs askew in it, and errs alike as long as the same things are in view; as the robot
turns and goes on, that averages out, and what remains is the mount. Nothing is done below a quarter of a degree, nor
where the views don't agree: a camera that stands upright is left alone to the bit.
"""

from __future__ import annotations

import math
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
FLOOR = math.radians(0.1)
"""[rad] What many readings may err by together: found means lie 0.0 to 0.1 degrees off."""
LEAST, CLEAR = math.radians(0.25), 3.0
"""[rad] A lean that is taken out, or a change of it, is at least so large, and so many sigmas."""
SWAY_LEAST, SWAY_CLEAR, SWAY_SHARP = math.radians(0.4), 3.5, math.radians(0.3)
"""[rad] A body sways where its readings spread by more, and by so many times what they say they err (things that hang
askew make up to 3.4 of a camera that stands still, grass and photographs 4.3), and such readings are sharp."""


@dataclass(frozen=True, slots=True)
class Taken:
    """One view: what it said of its lean (None: wasn't asked, or saw nothing upright), and what was taken out."""

    said: LeanReading | None
    lean: Lean


class Mount:
    """Reads views one after the other; `see` returns what is to be taken out of each.

    lean: the mount's own, as it is taken out now; restated: whether that changed with the last view.
    """

    def __init__(self) -> None:
        self.lean = UPRIGHT
        self.restated = False
        self._sway = 0.0
        self._seen = 0
        self._leans: list[tuple[float, float]] = []
        self._covariances: list[FloatArray] = []

    def see(self, raw: Panorama) -> Taken:
        """Learn from a view as the camera took it, and return what to take out of it."""
        self.restated = False
        said = self._said(raw) if self._asked() else None
        self._seen += 1
        if said is not None:
            self._learn(said)
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
        mean, sigma, _ = self._mean()
        taken = self.lean != UPRIGHT or self._sway > 0.0
        return MountLean(float(mean[0]), float(mean[1]), sigma, self._sway, taken)

    def _asked(self) -> bool:
        return self._sway > 0.0 or self._seen < FIRST or self._seen % EVERY == 0

    def _said(self, raw: Panorama) -> LeanReading | None:
        # read in the view as it is taken upright: what lies near zero is read exactly, more is read a tenth too small
        rest = lean_of(upright(raw, self.lean))
        if rest is None or rest.sigma > TOO_VAGUE:
            return None
        return LeanReading(rest.lean + self.lean, rest.covariance)

    def _learn(self, said: LeanReading) -> None:
        self._leans.append((said.lean.roll, said.lean.pitch))
        self._covariances.append(said.covariance)
        del self._leans[:-MOST], self._covariances[:-MOST]
        if len(self._leans) < FIRST:
            return
        mean, sigma, spread = self._mean()
        sharp = math.sqrt(float(np.median([np.trace(c) / 2.0 for c in self._covariances])))
        sways = spread > max(SWAY_LEAST, SWAY_CLEAR * sharp) and sharp < SWAY_SHARP
        found = Lean(float(mean[0]), float(mean[1]))
        if (found - self.lean).size >= max(LEAST, CLEAR * sigma) or sways != (self._sway > 0.0):
            self.restated = True
            self.lean = found if found.size >= LEAST else UPRIGHT
            self._sway = math.sqrt(spread**2 - sharp**2) if sways else 0.0

    def _mean(self) -> tuple[FloatArray, float, float]:
        """Return the robust mean (2,) of the readings, how far it may be off, and their spread about it [rad]."""
        leans, own = np.array(self._leans), np.array([np.trace(c) / 2.0 for c in self._covariances])
        mean = np.median(leans, axis=0)
        spread = float(1.4826 * np.median(np.abs(leans - mean)))
        weight = 1.0 / (own + spread**2)
        for _ in range(2):
            far = np.square(leans - mean).sum(axis=1) * weight
            robust = weight / np.square(1.0 + far / 8.0)
            mean = (robust[:, np.newaxis] * leans).sum(axis=0) / robust.sum()
        apart = max(len(leans) / ALIKE, 1.0)
        error = math.sqrt((spread**2 + float(np.median(own))) / apart + FLOOR**2)
        return mean, error, spread
