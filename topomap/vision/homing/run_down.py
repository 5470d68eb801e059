"""H22, pixel-wise landmarks by colour only: four fields, one of which runs down to the goal (5.1.2, eq. 5.10)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

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

    selection: keep the automatically chosen brightest columns (H23), else all; stride [m]: how far a move goes;
    spec: the views whose difference must run down. Allow a path of at least 2.5 times the direct one.
    """

    origin: ClassVar[Origin] = Origin("H22, H23", "5.6-5.12")
    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = True
    selection: bool = True
    stride: float = 0.1
    spec: SignatureSpec = ARRIVAL

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
        here, there = (equalised(horizon(p).mean(axis=0)) for p in (current, goal))
        count = landmark_count(here, there) if self.selection else len(here)
        x, y = _vector(here, count) - _vector(there, count)
        a, b, c, d = FIELDS[number]
        return a * x + b * y, c * x + d * y


def _vector(values: FloatArray, count: int) -> FloatArray:
    columns = len(values)
    chosen = np.argsort(-values, kind="stable")[:count]
    angles = chosen * (TAU / columns)
    return np.array([np.sum(values[chosen] * np.cos(angles)), np.sum(values[chosen] * np.sin(angles))]) / columns
