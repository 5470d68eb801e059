"""What the travelling part knows at one step: what was sensed, what works, where it believes to be, and the map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import Float32Array
from topomap.core.panorama import Panorama
from topomap.core.records import PlaceMatch, Where
from topomap.mapping.mapper import Mapper


@dataclass(frozen=True, slots=True)
class Health:
    """What can be relied on. stop: why the wheels must stand ("" for none); slow: half speed at most; event: what has
    just changed, in plain words.
    """

    stop: str = ""
    slow: bool = False
    event: str = ""


SOUND = Health()


@dataclass(frozen=True, slots=True, eq=False)
class Senses:
    """One reading: stamp, the panorama, the odometry's corrected turn [rad], the bumper, what works.

    ranges (W,) [m] with NaN where nothing was measured, or None where there are none that can be relied on; place: the
    node of the map that looks most alike, wherever it lies.
    """

    stamp_ns: int
    panorama: Panorama
    turn: float = 0.0
    contact: bool = False
    health: Health = SOUND
    ranges: Float32Array | None = None
    place: PlaceMatch | None = None

    def trusted(self) -> Panorama:
        """Return the panorama with those ranges only that can be relied on."""
        seen = self.panorama
        if seen.ranges is None or (
            self.ranges is not None and np.array_equal(seen.ranges, self.ranges, equal_nan=True)
        ):
            return seen
        return Panorama(seen.image, self.ranges, seen.rig)


@dataclass(frozen=True, slots=True, eq=False)
class Now:
    """One step: what was sensed, the belief, the map, and the ranges (W,) [m] with what was touched in them."""

    senses: Senses
    where: Where
    mapper: Mapper
    ranges: Float32Array | None = None
