"""H22, pixel-wise landmarks by colour only: four fields, one of which runs down to the goal (5.1.2, eq. 5.10)."""

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
from topomap.vision.homing.view_vector import same_views
from topomap.vision.image.colour_features import horizon
from topomap.vision.image.compare import ARRIVAL, SignatureSpec, rms, signature
from topomap.vision.image.pixel_selection import equalised, landmark_count

Selection = Literal["all", "threshold", "sorting", "automatic"]
COUNT = 200
"""Of 720 columns the thesis keeps 200 by hand (fig. 5.27)."""
THRESHOLD = 0.6
"""Equalised brightness above which a column counts; the thesis names no number."""
FIELDS = ((1.0, 0.0, 0.0, -1.0), (-1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 1.0, 0.0), (0.0, -1.0, -1.0, 0.0))
"""(X, -Y), (-X, Y), (Y, X), (-Y, -X): at least one of the four homes (5.12)."""


@dataclass(frozen=True, slots=True, eq=False)
class RunDownState:
    """The goal, the field that is followed (0 .. 3) and the image difference before the last move."""

    goal: Panorama
    field: int = 0
    before: float = math.inf


@dataclass(frozen=True, slots=True)
class RunDown:
    """Follows one of the four fields and changes to the next when the image difference grows.

    selection: which columns count (fig. 5.27, 5.30): "all", those above a "threshold", the `count` brightest by
    "sorting", or as many of them as H23 chooses, "automatic"; colour: a vector for each of R, G and B, added up, else
    of grey; stride [m]: how far a move goes; spec: the views whose difference must run down. Allow a path of at least
    2.5 times the direct one.
    """

    claims_homing: ClassVar[bool] = True
    selection: Selection = "automatic"
    colour: bool = False
    count: int = COUNT
    stride: float = 0.1
    spec: SignatureSpec = ARRIVAL

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        if self.selection == "automatic" and not self.colour:
            return Origin("H22, H23", "5.6-5.12")
        return Origin("H22", f"5.6-5.12, fig. 5.27-5.30: {'RGB' if self.colour else 'grey'}, {self.selection}")

    @property
    def needs(self) -> Needs:
        """Aligned views, in colour where it is told apart."""
        return Needs(compass=True, colour=self.colour)

    def start(self, goal: Panorama) -> RunDownState:
        """Return the state before the first look."""
        return RunDownState(goal)

    def step(self, state: RunDownState, current: Panorama) -> tuple[RunDownState, HomeVector]:
        """Return the next state and move. Raises ShapeError."""
        same_views(current, state.goal)
        now = rms(signature(current, self.spec), signature(state.goal, self.spec))
        field = (state.field + 1) % len(FIELDS) if now > state.before else state.field
        x, y = self.field(current, state.goal, field)
        sure = 1.0 if math.hypot(x, y) > 1e-12 else 0.0
        move = HomeVector(wrap(math.atan2(y, x)), self.stride if sure else 0.0, 0.5 * sure)
        return replace(state, field=field, before=now), move

    def field(self, current: Panorama, goal: Panorama, number: int) -> tuple[float, float]:
        """Return the vector of field `number` (5.10), from O(X) - O(X_0) (5.6, 5.7)."""
        x, y = self.difference(current, goal)
        a, b, c, d = FIELDS[number]
        return a * x + b * y, c * x + d * y

    def difference(self, current: Panorama, goal: Panorama) -> FloatArray:
        """Return O(X) - O(X_0) (2,), summed over the channels."""
        pairs = zip(self._channels(current), self._channels(goal), strict=True)
        return np.asarray(np.sum([self._one(here, there) for here, there in pairs], axis=0), np.float64)

    def _channels(self, panorama: Panorama) -> FloatArray:
        """Return the equalised values (F, W) of grey or of R, G, B."""
        seen = horizon(panorama)
        return np.stack([equalised(one) for one in (seen if self.colour else seen.mean(axis=0, keepdims=True))])

    def _one(self, here: FloatArray, there: FloatArray) -> FloatArray:
        if self.selection == "threshold":
            return _vector(here, int((here > THRESHOLD).sum())) - _vector(there, int((there > THRESHOLD).sum()))
        if self.selection == "automatic":
            count = landmark_count(here, there)
        else:
            count = len(here) if self.selection == "all" else max(round(self.count * len(here) / 720), 1)
        return _vector(here, count) - _vector(there, count)


def _vector(values: FloatArray, count: int) -> FloatArray:
    columns = len(values)
    chosen = np.argsort(-values, kind="stable")[:count]
    angles = chosen * (TAU / columns)
    return np.array([np.sum(values[chosen] * np.cos(angles)), np.sum(values[chosen] * np.sin(angles))]) / columns
