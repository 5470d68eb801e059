"""What each stage makes of views by cameras and scanners unlike the usual one: the same as before."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from kept import as_before
from scenes import Room
from stages import numbers, of_one, of_two

from topomap.core.errors import DataError, ShapeError
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision.compass import ALIGNERS
from topomap.vision.homing import METHODS

PLACES = ((3.7, 2.8, 0.4), (4.1, 3.1, 0.6))


def gaps(view: Panorama) -> Panorama:
    """The scanner sees half of the circle, and some of that not."""
    assert view.ranges is not None
    ranges = view.ranges.copy()
    ranges[len(ranges) // 2 :], ranges[::7], ranges[5] = np.nan, math.inf, 0.0
    return replace(view, ranges=ranges)


def blank(view: Panorama) -> Panorama:
    return replace(view, image=np.full_like(view.image, 77))


def dead(view: Panorama) -> Panorama:
    assert view.ranges is not None
    return replace(view, ranges=np.full_like(view.ranges, np.nan))


CAMERAS: dict[str, tuple[Rig, Callable[[Panorama], Panorama]]] = {
    "tiny": (Rig(24, 10, 4.5, 24 / TAU, 0.5), lambda view: view),
    "odd": (Rig(101, 33, 14.2, 108 / TAU, 0.4), gaps),
    "large": (Rig(900, 30, 17.0, 840 / TAU, 1.1), gaps),
    "low": (Rig(90, 30, 26.5, 90 / TAU, 0.6), lambda view: view),
    "high": (Rig(90, 30, 2.0, 90 / TAU, 0.6), gaps),
    "blank": (Rig(90, 30, 14.5, 90 / TAU, 0.6), blank),
    "dead scanner": (Rig(90, 30, 14.5, 90 / TAU, 0.6), dead),
}


UNSURE = {"blank": {"ring flow"}}
"""What the last digits decide, which another processor has otherwise; so some ways home of the high camera do."""


def views(camera: str) -> list[Panorama]:
    rig, changed = CAMERAS[camera]
    return [changed(Room().view(*place, rig)) for place in PLACES]


def told(made: Callable[[], object]) -> list[float] | list[str]:
    try:
        return list(numbers(made()))
    except (DataError, ShapeError) as error:
        return [str(error)]


@pytest.mark.parametrize("camera", CAMERAS)
def test_it_is_seen_as_before(camera: str) -> None:
    goal, current = views(camera)
    as_before(f"odd camera {camera}", {
        name: told(made) for name, made in (*of_one(current), *of_two(goal, current))
        if name not in UNSURE.get(camera, ())
    })  # fmt: skip


@pytest.mark.parametrize("camera", ["tiny", "odd", "blank", "dead scanner"])
def test_it_homes_as_before(camera: str) -> None:
    goal, current = views(camera)
    found = {name: told(lambda one=one: one.home(one.describe(current), one.describe(goal)))
             for name, one in METHODS.items()}  # fmt: skip
    found |= {f"compass {name}": told(lambda one=one: [one.align(current, goal, prior) for prior in (None, 0.3)])
              for name, one in ALIGNERS.items()}  # fmt: skip
    as_before(f"odd camera {camera} homes", found)
