"""A textured rectangular room with cylinders, seen by the stack's cylinder camera: geometry that shares no
code with what it tests (nor with sim2d).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from topomap.core.geometry import Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig

Floats = NDArray[np.float64]


def texture(seed: int, u: Floats, v: Floats) -> Floats:
    """Colour in 0..1, (..., 3), of a surface point u along, v up [m]: a few waves over a base, by seed."""
    rng = np.random.default_rng(seed)
    colour = np.broadcast_to(rng.uniform(0.25, 0.75, 3), (*u.shape, 3)).copy()
    for wave in range(7):
        length = 2.4 / 1.45**wave
        turn, phase = rng.uniform(0, 2 * math.pi, 2)
        across = np.sin((u * math.cos(turn) + v * math.sin(turn)) * 2 * math.pi / length + phase)
        colour += 0.13 * across[..., None] * rng.uniform(0.4, 1.0, 3)
    return np.clip(colour, 0, 1)


@dataclass(frozen=True)
class Room:
    """Walls x in [0, width], y in [0, depth] [m], cylinders (x, y, radius, height) [m]; patterned: the floor is."""

    seed: int = 1
    width: float = 8.0
    depth: float = 6.0
    height: float = 2.6
    cylinders: tuple[tuple[float, float, float, float], ...] = (
        (1.2, 1.1, 0.3, 1.4),
        (6.6, 1.6, 0.25, 2.0),
        (5.4, 5.0, 0.35, 0.9),
        (1.4, 4.7, 0.2, 2.6),
    )

    patterned: bool = True

    def view(self, x: float, y: float, heading: float = 0.0, rig: Rig | None = None) -> Panorama:
        """The panorama at a pose [m, rad], with exact ranges to the nearest surface at camera height."""
        rig = rig or Rig()
        angles = heading + np.arange(rig.width) * 2 * math.pi / rig.width
        rows = (rig.horizon_row - np.arange(rig.height)) / rig.focal  # height gained per metre
        image, depth = self._floor_and_ceiling(x, y, angles, rows, rig)
        ranges = np.full(rig.width, np.inf)
        for number, (distance, along, top) in enumerate(self._surfaces(x, y, angles)):
            z = rig.camera_height + rows[:, None] * distance[None, :]
            seen = (z >= 0) & (z <= top) & (distance[None, :] < depth)
            colour = texture(100 * self.seed + number, np.broadcast_to(along, z.shape)[seen], z[seen])
            image[seen] = colour
            depth[seen] = np.broadcast_to(distance, z.shape)[seen]
            ranges = np.minimum(ranges, np.where(top >= rig.camera_height, distance, np.inf))
        return Panorama((image * 255).astype(np.uint8), ranges.astype(np.float32), rig)

    def at(self, pose: Pose2) -> Panorama:
        return self.view(pose.x, pose.y, pose.heading)

    def _floor_and_ceiling(self, x: float, y: float, angles: Floats, rows: Floats, rig: Rig) -> tuple[Floats, Floats]:
        up = self.height - rig.camera_height
        reach = np.where(rows > 0, up, -rig.camera_height) / np.where(rows == 0, 1e-9, rows)
        px, py = x + reach[:, None] * np.cos(angles), y + reach[:, None] * np.sin(angles)
        floor, ceiling = texture(7 * self.seed, px, py), texture(13 * self.seed + 1, px, py)
        floor = floor if self.patterned else np.full_like(floor, 0.1)
        image = np.where((rows > 0)[:, None, None], 0.8 + 0.2 * ceiling, 0.15 + 0.3 * floor)
        return image, np.full(image.shape[:2], np.inf)

    def _surfaces(self, x: float, y: float, angles: Floats) -> list[tuple[Floats, Floats, float]]:
        c, s = np.cos(angles), np.sin(angles)
        walls = []
        with np.errstate(divide="ignore", invalid="ignore"):
            for t in ((self.width - x) / c, -x / c):
                walls.append((np.where(t > 0, t, np.inf), np.where(t > 0, y + t * s, 0.0), self.height))
            for t in ((self.depth - y) / s, -y / s):
                walls.append((np.where(t > 0, t, np.inf), np.where(t > 0, x + t * c, 0.0), self.height))
        near = np.minimum.reduce([w[0] for w in walls])
        walls = [(np.where(w[0] == near, w[0], np.inf), np.where(w[0] == near, w[1], 0.0), w[2]) for w in walls]
        return walls + [self._cylinder(x, y, c, s, *cylinder) for cylinder in self.cylinders]

    def _cylinder(
        self, x: float, y: float, c: Floats, s: Floats, cx: float, cy: float, r: float, top: float
    ) -> tuple[Floats, Floats, float]:
        dx, dy = cx - x, cy - y
        along = dx * c + dy * s
        gap = r * r - (dx * dx + dy * dy - along * along)
        hit = (gap > 0) & (along > 0)
        t = np.where(hit, along - np.sqrt(np.maximum(gap, 0)), np.inf)
        turn = np.arctan2(y + np.where(hit, t, 0) * s - cy, x + np.where(hit, t, 0) * c - cx)
        return t, r * turn, top


def around(home: Pose2, distance: float) -> list[Pose2]:
    """Eight poses at a distance [m] from home, each turned its own way."""
    angles = [k * math.pi / 4 + 0.13 for k in range(8)]
    return [
        Pose2(home.x + distance * math.cos(a), home.y + distance * math.sin(a), wrap(1.1 * k + distance))
        for k, a in enumerate(angles)
    ]


POSTS = ((1.0, 1.0), (6.8, 0.9), (7.1, 3.4), (6.2, 5.3), (3.2, 5.5), (0.8, 4.2))
"""Where the marker room's red posts stand [m]."""


@cache
def marker_view(pose: Pose2) -> Panorama:
    """Red posts of 8 degrees before grey walls, seen from a pose, with ranges to the posts or 9 m."""
    angles = np.arange(720) * math.tau / 720
    image = np.full((100, 720, 3), 120, np.uint8)
    image[50:] = 90
    ranges = np.full(720, 9.0, np.float32)
    for x, y in POSTS:
        there = Pose2(x, y)
        near = np.abs(np.angle(np.exp(1j * (angles - pose.bearing_to(there))))) <= math.radians(4)
        image[10:80, near] = (220, 20, 20)
        ranges[near] = pose.distance(there)
    return Panorama(image, ranges)


@cache
def view(pose: Pose2, seed: int = 1) -> Panorama:
    """The room of a seed, seen from a pose; rendered once for all tests."""
    return Room(seed).at(pose)


@cache
def plain_floor_view(pose: Pose2, seed: int = 1) -> Panorama:
    """The room of a seed with a floor of one colour, on which a ground line can be told."""
    return Room(seed, patterned=False).at(pose)
