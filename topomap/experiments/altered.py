"""Methods that are shown altered views: what a difference between views alone does to them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import HomingMethod, Needs


@dataclass(frozen=True, slots=True)
class Altered:
    """A method that sees every view changed; the change says in its repr all that decides it."""

    method: HomingMethod[Any]  # Any: each method keeps its own kind of description
    change: Callable[[Panorama], Panorama]
    claims_homing: bool = True

    @property
    def needs(self) -> Needs:
        """What the method needs."""
        return self.method.needs

    def describe(self, panorama: Panorama) -> Any:
        """Return the method's description of the changed view. Raises DataError."""
        return self.method.describe(self.change(panorama))

    def home(self, current: Any, goal: Any) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        return self.method.home(current, goal)


@dataclass(frozen=True, slots=True)
class Smooth:
    """The colours through a low-pass along the columns, of `sigma` columns."""

    sigma: float

    def __call__(self, panorama: Panorama) -> Panorama:
        """Return the view with its colours smoothed around the seam."""
        if not self.sigma:
            return panorama
        reach = int(3 * self.sigma)
        wide = np.concatenate([panorama.image[:, -reach:], panorama.image, panorama.image[:, :reach]], axis=1)
        soft = cv2.GaussianBlur(wide, (2 * reach + 1, 1), self.sigma)[:, reach:-reach]
        return Panorama(np.ascontiguousarray(soft), panorama.ranges, panorama.rig)


@dataclass(frozen=True, slots=True)
class Fade:
    """The colours with a `share` of their contrast around the view's mean."""

    share: float

    def __call__(self, panorama: Panorama) -> Panorama:
        """Return the view with its colours faded."""
        mean = panorama.image.mean()
        faded = np.rint(mean + self.share * (panorama.image - mean)).astype(np.uint8)
        return Panorama(faded, panorama.ranges, panorama.rig)
