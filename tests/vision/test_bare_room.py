"""Homes in a room with next to nothing in it: where few features are left, each method says as little as before."""

from __future__ import annotations

from functools import cache

import numpy as np
from kept import as_before

from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision.aligned_homing import AlignedHoming
from topomap.vision.contracts import GoalView
from topomap.vision.homing import METHODS, REFERENCE_METHODS

POSTS = ((0.4, 2.0, (210, 30, 30)), (1.9, 2.6, (30, 190, 60)), (3.6, 1.7, (40, 60, 220)), (5.2, 3.0, (230, 230, 40)))
"""Bearing [rad], distance [m] and colour of the posts as seen from the middle."""
HALF, WALL = 0.06, 4.0
"""[m] Half a post's width; the round wall's distance."""


@cache
def seen(x: float, y: float, count: int) -> Panorama:
    """What is seen from x, y [m], looking along +x: `count` posts before a grey wall, on a darker floor."""
    rig = Rig(360, 60, 29.5, 360 / TAU, 0.6)
    bearings = (np.arange(360) * TAU / 360) % TAU
    across = x * np.cos(bearings) + y * np.sin(bearings)
    ranges = -across + np.sqrt(np.maximum(across**2 + WALL**2 - x**2 - y**2, 0.0))
    colours = np.full((360, 3), 120.0)
    for bearing, distance, colour in POSTS[:count]:
        dx, dy = distance * np.cos(bearing) - x, distance * np.sin(bearing) - y
        off = np.abs((bearings - np.arctan2(dy, dx) + np.pi) % TAU - np.pi)
        hit = off < np.arctan2(HALF, np.hypot(dx, dy))
        ranges[hit], colours[hit] = np.hypot(dx, dy), colour
    rows = np.arange(60)[:, None]
    floor = rows - 29.5 > rig.focal * 0.6 / ranges
    image = np.where(floor[:, :, None], 60.0, colours[None]).astype(np.uint8)
    return Panorama(np.ascontiguousarray(image), ranges.astype(np.float32), rig)


def homes(count: int) -> dict[str, list[float | None]]:
    found: dict[str, list[float | None]] = {}
    there, here = seen(0.0, 0.0, count), (seen(0.5, 0.2, count), seen(-0.9, 0.7, count))
    for name, method in {**METHODS, **REFERENCE_METHODS}.items():
        found[name] = []
        for view in here:
            if name in REFERENCE_METHODS:
                goal = GoalView(there, seen(method.step, 0.0, count), seen(0.0, method.step, count), method.step)
                predicted = AlignedHoming.goal_view(there, method.step)
                answers = [method.home(view, goal), method.home(view, predicted)]
            else:
                answers = [method.home(method.describe(view), method.describe(there))]
            found[name] += [one for home in answers for one in (home.bearing, home.distance, home.confidence)]
    return found


def test_four_posts_tell_as_much_as_before() -> None:
    as_before("four posts", {name: [np.nan if v is None else v for v in told] for name, told in homes(4).items()})


def test_one_post_tells_as_much_as_before() -> None:
    found = {name: [np.nan if v is None else v for v in told] for name, told in homes(1).items()}
    as_before("one post", found, close=0.005)  # one post is little: convergence-point's last digits grow to 0.3 %
