"""An aligner and a homing method as one: from two panoramas to a home vector."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Generic, TypeVar, cast

from topomap.core.geometry import TAU, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, HomeVector
from topomap.vision.contracts import Aligner, HomingMethod
from topomap.vision.homing.needs import check

D = TypeVar("D")


@dataclass(frozen=True, slots=True)
class Homing:
    """A home vector in the current robot's frame and the alignment it rests on."""

    home: HomeVector
    alignment: Alignment


@dataclass(frozen=True, slots=True)
class AlignedHoming(Generic[D]):
    """Aligns the current view, asks the method, and turns its answer back into the robot's frame.

    method None: the aligner's own home vector. A method without `needs.compass` gets the views as they are.
    """

    aligner: Aligner
    method: HomingMethod[D] | None = None

    def home(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Homing:
        """Return where the goal lies; prior: rotation [rad] from odometry. Raises DataError."""
        alignment = self.aligner.align(current, goal, prior)
        if self.method is None:
            return Homing(alignment.home or HomeVector(0.0, None, 0.0), alignment)
        check(self.method.needs, current)
        check(self.method.needs, goal)
        columns = current.columns(alignment.rotation) if self.method.needs.compass else 0
        found = self.method.home(_described(self.method, current.rolled(columns)), _described(self.method, goal))
        bearing = wrap(found.bearing - columns * TAU / current.rig.width)
        return Homing(HomeVector(bearing, found.distance, found.confidence), alignment)

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        """Return the alignment with the method's home vector, so that the pair serves as an `Aligner` itself."""
        found = self.home(current, goal, prior)
        return replace(found.alignment, home=found.home)


def _described(method: HomingMethod[D], panorama: Panorama) -> D:
    return panorama.derived(cast(Hashable, method), method.describe)
