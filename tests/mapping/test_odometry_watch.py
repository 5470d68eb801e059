"""Odometry that can't be true is noticed by the views before and after; what is usual isn't."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sim2d.records import SimReading
from tests.helpers.played import moved, taught
from topomap.core.panorama import Panorama
from topomap.mapping.odometry.watch import OdometryWatch


def said(readings: list[SimReading]) -> list[tuple[int, str]]:
    watch = OdometryWatch()
    words = [(k, watch.judge(Panorama.from_reading(r), r.motion)) for k, r in enumerate(readings)]
    return [(k, word) for k, word in words if word]


def test_an_undisturbed_drive_is_believed() -> None:
    assert said(taught(80)) == []


def test_being_carried_on_by_two_metres_is_noticed_at_once() -> None:
    seen = taught(80)
    assert [(k, word.split(":")[0]) for k, word in said(seen[:40] + seen[60:])] == [(40, "carried away")]


def test_wheels_that_stood_while_the_view_moved_are_noticed_when_they_go_on() -> None:
    seen = taught(60)
    dead = [moved(r, forward=0.0, turn=0.0) if 30 <= k < 45 else r for k, r in enumerate(seen)]
    found = said(dead)
    assert [k for k, _ in found] == [45]
    assert "stood still for 15 steps" in found[0][1]


def test_wheels_that_spin_on_the_spot_are_noticed_when_they_grip() -> None:
    seen = taught(60)
    stuck = seen[:30] + [moved(seen[29], forward=0.1, turn=0.0) for _ in range(8)] + seen[30:]
    found = said(stuck)
    assert [k for k, _ in found] == [38]
    assert "spun for 8 steps" in found[0][1]


def test_turning_on_the_spot_is_no_spinning() -> None:
    seen = taught(40)
    still = [moved(seen[29], forward=0.0, turn=0.2) for _ in range(12)]
    turned = [replace(r, image=np.roll(r.image, 23 * k, axis=1)) for k, r in enumerate(still, 1)]
    back = [replace(r, image=seen[29].image) for r in (moved(seen[29], forward=0.0, turn=-2.4),)]
    assert [word for _, word in said(seen[:30] + turned + back + seen[30:]) if "spun" in word] == []
