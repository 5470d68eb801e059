"""Landmarks on the horizon ring: vertical edges, colour markers, and how those of two views belong together."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from topomap.core.arrays import BoolArray, Float32Array, FloatArray, IndexArray
from topomap.core.geometry import TAU, wrap_all
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision.image.distances import filled
from topomap.vision.image.ring import RingSpec, ring


@dataclass(frozen=True, slots=True, eq=False)
class Landmarks:
    """bearings (N,) [rad]; looks (N, F), what each looks like; metres (N,), NaN where unknown; rig."""

    bearings: FloatArray
    looks: FloatArray
    metres: FloatArray
    rig: Rig

    def __len__(self) -> int:
        """Return the number of landmarks."""
        return len(self.bearings)


_RING = RingSpec(columns=360, bands=5, blur=1.5)


@dataclass(frozen=True, slots=True)
class EdgeSpec:
    """Vertical edges: most, how many; apart [columns], the least gap; side [columns], how far a look reaches."""

    most: int = 40
    apart: int = 3
    side: int = 4
    ring: RingSpec = _RING


EDGES = EdgeSpec()


def edges(panorama: Panorama, spec: EdgeSpec = EDGES) -> Landmarks:
    """Return the strongest vertical edges of the horizon ring, each with the colours beside it."""
    return panorama.derived(spec, lambda p: _edges(p, spec))


def _edges(panorama: Panorama, spec: EdgeSpec) -> Landmarks:
    bands = ring(panorama, spec.ring)
    columns = bands.shape[1]
    slope = np.abs(np.roll(bands, -1, axis=1) - np.roll(bands, 1, axis=1)).sum(axis=0, dtype=np.float64)
    highest = np.max([np.roll(slope, k) for k in range(-spec.apart, spec.apart + 1)], axis=0)
    peaks = np.flatnonzero((slope >= highest) & (slope > slope.mean()) & (slope > 1e-6))
    strong = np.sort(peaks[np.argsort(-slope[peaks], kind="stable")[: spec.most]])
    below, here, above = (slope[(strong + k) % columns] for k in (-1, 0, 1))
    bend = np.maximum(2.0 * here - below - above, 1e-9)
    where = strong + np.clip(0.5 * (above - below) / bend, -0.5, 0.5)
    bearings = where * (TAU / columns) + 0.5 * (TAU / columns - TAU / panorama.rig.width)
    return Landmarks(bearings, _looks(bands, strong, spec.side), _nearest(panorama, bearings), panorama.rig)


def _looks(bands: Float32Array, at: IndexArray, side: int) -> FloatArray:
    columns = bands.shape[1]
    left, right = bands[:, (at + side) % columns], bands[:, (at - side) % columns]
    return np.asarray(np.concatenate([left, right]).T, np.float64)


def _nearest(panorama: Panorama, bearings: FloatArray) -> FloatArray:
    """An edge belongs to the nearer of the surfaces beside it."""
    if panorama.ranges is None or panorama.rig.width < 3:
        return np.full(len(bearings), np.nan)
    width = panorama.rig.width
    ranges = filled(panorama.ranges)
    if ranges.share == 0.0:
        return np.full(len(bearings), np.nan)
    columns = np.rint(bearings * width / TAU).astype(np.intp)
    beside = np.stack([ranges.metres[(columns + k) % width] for k in (-2, -1, 0, 1, 2)])
    return np.asarray(beside.min(axis=0), np.float64)


@dataclass(frozen=True, slots=True)
class MarkerSpec:
    """Colour markers: hue [0, 360) within hue_width [deg], saturated and bright enough, `least` wide."""

    hue: float = 0.0
    hue_width: float = 25.0
    saturation: float = 0.45
    value: float = 0.2
    least: int = 3


def markers(panorama: Panorama, spec: MarkerSpec) -> Landmarks:
    """Return the runs of columns on the horizon that show the marker's colour (2.6.5.3)."""
    middle = int(panorama.rig.horizon_row)
    rows = panorama.image[max(middle - 2, 0) : middle + 3].mean(axis=0, keepdims=True).astype(np.float32) / 255.0
    hue, saturation, value = cv2.cvtColor(rows, cv2.COLOR_RGB2HSV)[0].T.astype(np.float64)
    near = np.abs((hue - spec.hue + 180.0) % 360.0 - 180.0) <= spec.hue_width
    runs = [r for r in _runs(near & (saturation >= spec.saturation) & (value >= spec.value)) if r[1] >= spec.least]
    width = panorama.rig.width
    bearings = np.array([(first + (length - 1) / 2.0) * TAU / width for first, length in runs])
    looks = np.array([[length * TAU / width, hue[first], value[first]] for first, length in runs]).reshape(-1, 3)
    return Landmarks(bearings, looks, _nearest(panorama, bearings), panorama.rig)


def _runs(chosen: BoolArray) -> list[tuple[int, int]]:
    """Return (first, length) of the runs around the circle; a whole one has no ends and is none."""
    starts = np.flatnonzero(chosen & ~np.roll(chosen, 1))
    ends = np.flatnonzero(chosen & ~np.roll(chosen, -1))
    return [(int(s), int(min((e - s) % len(chosen) for e in ends)) + 1) for s in starts]


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """Matched landmarks: indices (M,) into the current and the goal view; weight (M,) in [0, 1]."""

    current: IndexArray
    goal: IndexArray
    weight: FloatArray


def matched(current: Landmarks, goal: Landmarks, reach: float) -> Pairs:
    """Return the pairs that are each other's most alike within `reach` [rad] of bearing.

    The weight says how much better the best partner is than the second best.
    """
    if not len(current) or not len(goal):
        nothing: IndexArray = np.empty(0, np.intp)
        return Pairs(nothing, nothing, np.empty(0))
    unlike = np.sqrt(np.square(goal.looks[:, np.newaxis] - current.looks[np.newaxis]).mean(axis=2))
    apart = np.abs(wrap_all(goal.bearings[:, np.newaxis] - current.bearings[np.newaxis]))
    cost = np.where(apart <= reach, unlike, np.inf)
    to_current, to_goal = cost.argmin(axis=1), cost.argmin(axis=0)
    mine = np.arange(len(goal))
    mutual = (to_goal[to_current] == mine) & np.isfinite(cost[mine, to_current])
    g, c = mine[mutual], to_current[mutual]
    return Pairs(c, g, _clarity(cost, g, c))


def _clarity(cost: FloatArray, g: IndexArray, c: IndexArray) -> FloatArray:
    best = cost[g, c]
    others = cost.copy()
    others[g, c] = np.inf
    rival = np.minimum(others[g].min(axis=1, initial=np.inf), others[:, c].min(axis=0, initial=np.inf))
    clarity = np.where(np.isfinite(rival), 1.0 - best / np.maximum(rival, 1e-9), 1.0)
    return np.asarray(np.clip(clarity, 0.0, 1.0) + 1e-3, np.float64)
