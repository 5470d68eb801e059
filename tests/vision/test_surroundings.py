"""Small views predicted around a place: the first is the place's own, the others are what is seen from there."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import Room

from topomap.core.geometry import Pose2
from topomap.vision.image.compare import rms, rotation_difference, signature
from topomap.vision.image.displaced import displaced
from topomap.vision.image.surroundings import surroundings

START = Pose2(3.7, 2.8, 0.7)


def test_the_first_view_is_the_places_own() -> None:
    here = Room(4).at(START)
    around = surroundings(here)
    assert around.points[0].tolist() == [0.0, 0.0]
    assert around.views[0].pixels == pytest.approx(signature(here).pixels, abs=1e-4)
    assert len(around.views) == len(around.points) == len(np.unique(around.points, axis=0))


def test_what_is_predicted_is_what_is_seen_from_there() -> None:
    room, here = Room(4), Room(4).at(START)
    around = surroundings(here)
    for (x, y), seen in list(zip(around.points.tolist(), around.views, strict=True))[1:]:
        true = signature(room.at(START @ Pose2(x, y)))
        assert rms(seen, true) < 0.7 * rms(signature(here), true)
        assert rms(seen, signature(displaced(here, x, y))) < 0.15


def test_a_turned_robot_is_told_where_the_place_stands_from_it() -> None:
    room, turn = Room(4), 2.0
    around = surroundings(room.at(START @ Pose2(0.0, 0.0, turn)))
    place = START @ Pose2(-0.3, 0.15)
    found = [rotation_difference(view, signature(room.at(place))) for view in around.views]
    best = int(np.argmin([difference for difference, _ in found]))
    robot = START @ Pose2(0.0, 0.0, turn)
    ahead, left = around.points[best]
    told = robot @ Pose2(float(ahead), float(left))
    assert told.distance(place) < 0.12
    assert found[best][1] == pytest.approx(turn, abs=0.1)
