"""The driven line: a route's corners rounded off, as dense points with their length along the way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim2d.errors import WorldError
from sim2d.shapes import Point, Route

SPACING = 0.02  # [m]
RAMP = 1.0  # [m] over which a lateral offset sets in


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """Points (N, 2), their distance along the line (N,), the length of one lap, and where it turns back, all [m]."""

    points: NDArray[np.float64]
    along: NDArray[np.float64]
    lap: float
    cusps: tuple[float, ...] = ()

    @property
    def length(self) -> float:
        """The whole way [m]."""
        return float(self.along[-1])

    def at(self, s: float) -> tuple[float, float]:
        """Return the point x, y [m] after s [m], held at the ends."""
        # by hand: np.interp would copy the whole line's x and y at every call
        k = min(max(int(np.searchsorted(self.along, s, side="right")) - 1, 0), len(self.along) - 2)
        share = min(max(s - self.along[k], 0.0), self.along[k + 1] - self.along[k])
        x, y = (self.points[k + 1] - self.points[k]) / (self.along[k + 1] - self.along[k]) * share + self.points[k]
        return float(x), float(y)

    def heading(self, s: float) -> float:
        """Return the heading [rad] after s [m]."""
        (x0, y0), (x1, y1) = self.at(max(0.0, s - SPACING)), self.at(s + SPACING)
        return math.atan2(y1 - y0, x1 - x0)

    def nearest(self, x: float, y: float) -> float:
        """Return how far along the point nearest to x, y lies [m]; of passes equally near, the first."""
        return float(self.along[int(np.argmin(np.hypot(self.points[:, 0] - x, self.points[:, 1] - y)))])

    def beside(self, pose: tuple[float, float, float], along: float) -> tuple[float, float, float]:
        """Return the pose that lies to the path, `along` [m] further on, as a pose x, y [m], heading [rad] lies to it.

        Held at the path's ends.
        """
        x, y, heading = pose
        here = self.nearest(x, y)
        there = min(max(here + along, 0.0), self.length)
        (x0, y0), (x1, y1) = self.at(here), self.at(there)
        before, turned = self.heading(here), self.heading(there) - self.heading(here)
        left = -math.sin(before) * (x - x0) + math.cos(before) * (y - y0)
        after = self.heading(there)
        return x1 - left * math.sin(after), y1 + left * math.cos(after), heading + turned


def of_route(route: Route, laps: float | None = None, offset: float = 0.0) -> Path:
    """Return the path of a route, with other laps if given, shifted left by `offset` [m] from lap two on.

    Raises WorldError where a tail would begin in the middle of a lap.
    """
    laps = route.laps if laps is None else laps
    ring = [*route.ring, route.ring[0]]
    lap = _length(rounded(ring, route.radius))
    if route.tail and laps != round(laps):
        raise WorldError(f"this route has a tail, so its laps must be whole, not {laps}")
    points = rounded([*route.ring[:1], *_laps(ring, math.ceil(laps), route.both_ways), *route.tail], route.radius)
    if not route.tail:
        points = _cut(points, laps * lap)
    points = _shifted(points, lap, offset) if offset else points
    along = _along(points)
    return Path(points, along, lap, _cusps(points, along))


def _laps(ring: list[Point], laps: int, both_ways: bool) -> list[Point]:
    """Return the corners of so many laps of a closed ring, without its first point; the other way round in turn."""
    there, back = ring[1:], ring[-2::-1]
    return [corner for lap in range(laps) for corner in (back if both_ways and lap % 2 else there)]


def _cusps(points: NDArray[np.float64], along: NDArray[np.float64]) -> tuple[float, ...]:
    """Return where the line turns by more than a right angle on the spot [m]."""
    steps = np.diff(points, axis=0)
    back = np.flatnonzero((steps[1:] * steps[:-1]).sum(axis=1) < 0)
    return tuple(float(along[k + 1]) for k in back)


def rounded(corners: Sequence[Point], radius: float) -> NDArray[np.float64]:
    """Return an open polyline as points about 2 cm apart, each corner an arc of at most `radius` [m]."""
    pieces = [np.array([corners[0]], dtype=np.float64)]
    for a, b, c in zip(corners, corners[1:], corners[2:], strict=False):
        pieces.append(_arc(np.array(a), np.array(b), np.array(c), radius))
    pieces.append(np.array([corners[-1]], dtype=np.float64))
    return _resampled(np.concatenate(pieces))


def _arc(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    """Return the points of the arc that replaces corner b, or b itself on a straight line."""
    u, v = (a - b) / np.linalg.norm(a - b), (c - b) / np.linalg.norm(c - b)
    half = 0.5 * math.acos(float(np.clip(u @ v, -1, 1)))
    if half > 0.5 * math.pi - 1e-6 or half < 1e-3:
        return b[None]
    room = 0.5 * min(np.linalg.norm(a - b), np.linalg.norm(c - b))
    cut = min(radius / math.tan(half), float(room))
    centre = b + (u + v) / np.linalg.norm(u + v) * cut / math.cos(half)
    start = b + u * cut - centre
    turn = (math.pi - 2 * half) * (1.0 if u[0] * v[1] - u[1] * v[0] < 0 else -1.0)
    angles = np.linspace(0.0, turn, max(3, int(abs(turn) / 0.02)))
    cos, sin = np.cos(angles), np.sin(angles)
    arc: NDArray[np.float64] = np.stack([cos * start[0] - sin * start[1], sin * start[0] + cos * start[1]], axis=-1)
    arc += centre
    return arc


def _along(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.concatenate([np.zeros(1), np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def _length(points: NDArray[np.float64]) -> float:
    return float(_along(points)[-1])


def _resampled(points: NDArray[np.float64]) -> NDArray[np.float64]:
    along = _along(points)
    s = np.linspace(0.0, along[-1], max(2, math.ceil(along[-1] / SPACING) + 1))
    return np.stack([np.interp(s, along, points[:, 0]), np.interp(s, along, points[:, 1])], axis=-1)


def _cut(points: NDArray[np.float64], length: float) -> NDArray[np.float64]:
    return points[: int(np.searchsorted(_along(points), length)) + 1]


def _shifted(points: NDArray[np.float64], lap: float, offset: float) -> NDArray[np.float64]:
    """Return the points moved to the left from the second lap on, setting in over a ramp."""
    tangent = np.gradient(points, axis=0)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)
    left: NDArray[np.float64] = np.stack([-tangent[:, 1], tangent[:, 0]], axis=-1)
    share = np.clip((_along(points) - lap) / RAMP, 0.0, 1.0)[:, None]
    return points + offset * share * left
