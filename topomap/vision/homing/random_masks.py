"""H19, H20: random Haar-like masks with one reference and with three (4.1.2, 4.1.3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from topomap.core.arrays import FloatArray, IndexArray
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import GoalView, Needs, Origin
from topomap.vision.homing.view_vector import ViewVector, difference, same_views, vector_home
from topomap.vision.image.haar_masks import WIDE, MaskSpec, masks, scores

MASKS = MaskSpec()


@dataclass(frozen=True, slots=True)
class RandomMasks:
    """Sum over masks of (S_C - S_H) u (4.10-4.12, current minus goal); claims no homing.

    The field has the same saddle at the goal as the centre of mass: neither sign homes in a room.
    """

    origin: ClassVar[Origin] = Origin("H19", "4.8-4.12")
    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = False
    spec: MaskSpec = MASKS

    def describe(self, panorama: Panorama) -> ViewVector:
        """Return the mean over masks of score * u."""
        rig = panorama.rig
        chosen = masks(self.spec, rig.width, rig.height, rig.horizon_row)
        found = panorama.derived(self.spec, lambda p: scores(p, self.spec))
        x, y = float(np.mean(found * np.cos(chosen.bearings))), float(np.mean(found * np.sin(chosen.bearings)))
        return ViewVector(x, y, 1.0 if found.any() else 0.0, rig)

    def home(self, current: ViewVector, goal: ViewVector) -> HomeVector:
        """Return the bearing [rad] of the vectors' difference in the aligned frame. Raises ShapeError."""
        return difference(current, goal)


@dataclass(frozen=True, slots=True)
class ReferenceMasks:
    """Score differences to three references: X = sum |S_X - S| - sum |S_0 - S|, Y alike, home = atan2(Y, X)
    (4.13-4.15); bearing only. Where several masks share a direction, the one that scores best at the goal counts.
    """

    needs: ClassVar[Needs] = Needs(compass=True)
    spec: MaskSpec = WIDE
    step: float = 0.1

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        best = ", best of each direction" if self.spec.candidates > 1 else ""
        return Origin("H20", f"4.13-4.15, fig. 4.35{best}" if self.spec.even else "4.13-4.15")

    @property
    def claims_homing(self) -> bool:
        """Whether the masks are large enough to see the goal from afar (`WIDE`)."""
        return self.spec.height[0] >= WIDE.height[0]

    def home(self, current: Panorama, goal: GoalView) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        same_views(current, goal.home)
        here, *there = (
            p.derived(self.spec, lambda q: scores(q, self.spec)) for p in (current, goal.home, goal.x, goal.y)
        )
        chosen = self._chosen(there[0])
        apart = [float(np.abs(score - here)[chosen].mean()) for score in there]
        x, y = apart[1] - apart[0], apart[2] - apart[0]
        return vector_home(x, y, sum(apart) + 1e-9, 1.0 if here.any() and apart[0] > 1e-9 else 0.0)

    def _chosen(self, scores_home: FloatArray) -> IndexArray:
        """Return which masks count: of each direction's candidates the one of the highest score at the goal (4.35)."""
        most = self.spec.candidates
        if most < 2:
            return np.arange(len(scores_home))
        groups = scores_home[: len(scores_home) // most * most].reshape(-1, most)
        return np.asarray(np.arange(len(groups)) * most + groups.argmax(axis=1), np.intp)
