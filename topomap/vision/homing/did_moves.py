"""H7, descent in image distance by trial moves (Möller, Vardy 2006; 2.5.3, 2.5.3.1, 2.5.3.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.did import BLURRED
from topomap.vision.image.compare import Signature, SignatureSpec, rms, signature

Form = Literal["basic", "gradient", "newton"]


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """The state: the goal; differences at the centre and at the trial places so far; where the robot stands, x, y
    [m] from the centre.
    """

    goal: Signature
    seen: tuple[float, ...] = ()
    x: float = 0.0
    y: float = 0.0


@dataclass(frozen=True, slots=True)
class TrialMoves:
    """Looks at the centre and at `directions` places around it, then moves on by `stride` [m] (2.5.3).

    form "basic": towards the least difference; "gradient" (2 or 4 directions): down the differences; "newton"
    (4 or 8): down them, divided by the second differences (with 8 the mixed one too). trial [m]: how far.
    """

    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = True
    form: Form = "gradient"
    directions: int = 2
    trial: float = 0.1
    stride: float = 0.2
    spec: SignatureSpec = BLURRED

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        sources = {"basic": "2.5.3", "gradient": "2.5.3.1; Möller, Vardy 2006", "newton": "2.5.3.2"}
        return Origin("H7", sources[self.form])

    def start(self, goal: Panorama) -> Trial:
        """Return the state before the first look."""
        return Trial(signature(goal, self.spec))

    def step(self, state: Trial, current: Panorama) -> tuple[Trial, HomeVector]:
        """Return the next state and move: to the next trial place, or on from the centre. Raises ShapeError."""
        seen = (*state.seen, rms(signature(current, self.spec), state.goal))
        if len(seen) <= self.directions:
            angle = (len(seen) - 1) * self._turn
            x, y = self.trial * math.cos(angle), self.trial * math.sin(angle)
            return replace(state, seen=seen, x=x, y=y), _move(x - state.x, y - state.y, 0.5)
        x, y = self.towards(np.array(seen))
        move = _move(x * self.stride - state.x, y * self.stride - state.y, 1.0 if x or y else 0.0)
        return Trial(state.goal), move

    @property
    def _turn(self) -> float:
        return math.pi / 2 if self.directions == 2 else TAU / self.directions

    def towards(self, seen: FloatArray) -> tuple[float, float]:
        """Return the unit direction of home from the difference at the centre and at the trial places."""
        around = seen[1:] - seen[0]
        if self.form == "basic":
            if around.min() >= 0.0:
                return 0.0, 0.0
            best = int(around.argmin()) * self._turn
            return math.cos(best), math.sin(best)
        slope, bend = self._fit(around)
        if self.form == "newton":
            slope = _newton(slope, bend)
        length = math.hypot(*slope)
        return (0.0, 0.0) if length < 1e-12 else (-float(slope[0]) / length, -float(slope[1]) / length)

    def _fit(self, around: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Fit slope (2,) and second differences (2, 2) to the differences around; unseen terms are zero."""
        angles = np.arange(self.directions) * self._turn
        x, y = np.cos(angles), np.sin(angles)
        terms = [x, y]
        if self.directions >= 4:
            terms += [0.5 * x * x, 0.5 * y * y]
        if self.directions >= 8:
            terms.append(x * y)
        fit = np.zeros(5)
        fit[: len(terms)] = np.linalg.lstsq(np.column_stack(terms), around, rcond=None)[0]
        return fit[:2], np.array([[fit[2], fit[4]], [fit[4], fit[3]]])


def _newton(slope: FloatArray, bend: FloatArray) -> FloatArray:
    """Divide by the curvature; where that is no bowl, by its size only, so that the step still descends."""
    values, vectors = np.linalg.eigh(bend)
    floor = max(float(np.abs(values).max()), 1e-12) * 0.2
    return np.asarray(vectors @ ((vectors.T @ slope) / np.maximum(np.abs(values), floor)), np.float64)


def _move(x: float, y: float, confidence: float) -> HomeVector:
    return HomeVector(wrap(math.atan2(y, x)), math.hypot(x, y), confidence)
