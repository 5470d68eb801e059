"""A view as one vector: what ALV, moments, masks and their kin keep of a snapshot, and their common difference."""

from __future__ import annotations

import math
from dataclasses import dataclass

from topomap.core.errors import ShapeError
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.core.rig import Rig

NOTHING = 1e-9
"""A difference below this share of the vectors themselves is rounding."""


@dataclass(frozen=True, slots=True)
class ViewVector:
    """x, y in the robot's frame, in the method's own unit; share in [0, 1] of the view it rests on; rig."""

    x: float
    y: float
    share: float
    rig: Rig

    @property
    def length(self) -> float:
        """The vector's length."""
        return math.hypot(self.x, self.y)


def same_camera(a: Rig, b: Rig) -> None:
    """Raise ShapeError when two views come from cameras of different size."""
    if (a.width, a.height) != (b.width, b.height):
        raise ShapeError(f"views differ in shape: {a.height} x {a.width} and {b.height} x {b.width}")


def same_views(*views: Panorama) -> None:
    """Raise ShapeError when views come from cameras of different size."""
    for view in views[1:]:
        same_camera(view.rig, views[0].rig)


def difference(current: ViewVector, goal: ViewVector, metric: bool = False) -> HomeVector:
    """Return the current vector minus the goal's as a home vector; metric: its length is a distance [m].

    The confidence is the share the views rest on, less where the vectors nearly cancel. Raises ShapeError.
    """
    same_camera(current.rig, goal.rig)
    x, y = current.x - goal.x, current.y - goal.y
    size = current.length + goal.length
    return vector_home(x, y, size, min(current.share, goal.share), metric)


def vector_home(x: float, y: float, size: float, share: float = 1.0, metric: bool = False) -> HomeVector:
    """Return the home vector (x, y) of two quantities of summed length `size`; none where rounding is left."""
    length = math.hypot(x, y)
    if not math.isfinite(length) or length <= NOTHING * (size + NOTHING):
        return HomeVector(0.0, 0.0 if metric else None, 0.0)
    return HomeVector(math.atan2(y, x), length if metric else None, min(share * math.sqrt(length / size), 1.0))
