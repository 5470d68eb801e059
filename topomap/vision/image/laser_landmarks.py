"""Landmarks from the range scan's derivative: where one thing stands before another (2.6.5.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from topomap.core.errors import DataError
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.vision.image.distances import filled
from topomap.vision.image.landmarks import Landmarks


@dataclass(frozen=True, slots=True)
class JumpSpec:
    """Jumps of the range: least [m] from one ray to the next; widest [rad] a thing between two jumps may be."""

    least: float = 0.25
    widest: float = 1.0


def jumps(panorama: Panorama, spec: JumpSpec) -> Landmarks:
    """Return the things between a jump towards the robot and the next one away from it (fig. 2.22).

    Each has the bearing of its middle, looks as wide as it is [m], and its distance is its middle's, taken as round.
    Raises DataError without ranges.
    """
    if panorama.ranges is None:
        raise DataError("landmarks of the range scan need measured ranges, and the panorama has none")
    return panorama.derived(spec, lambda p: _jumps(p, spec))


def _jumps(panorama: Panorama, spec: JumpSpec) -> Landmarks:
    assert panorama.ranges is not None
    metres = filled(panorama.ranges).metres
    width = len(metres)
    rise = np.roll(metres, -1) - metres
    nearer, farther = np.flatnonzero(rise < -spec.least), np.flatnonzero(rise > spec.least)
    if not len(nearer) or not len(farther):
        return Landmarks(np.empty(0), np.empty((0, 1)), np.empty(0), panorama.rig)
    ends = np.array([int(((farther - first - 1) % width).min()) + 1 for first in nearer])  # rays of each thing
    good = ends * (TAU / width) <= spec.widest
    first, rays = nearer[good] + 1, ends[good]
    near = np.array([float(np.median(metres[np.arange(f, f + n) % width])) for f, n in zip(first, rays, strict=True)])
    across = rays * (TAU / width)
    bearings = np.mod((first + (rays - 1) / 2.0) * (TAU / width), TAU)
    return Landmarks(bearings, (near * across).reshape(-1, 1), near + 0.5 * near * across, panorama.rig)
