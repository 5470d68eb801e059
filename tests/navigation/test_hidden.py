"""What a view tells of which people hide a half: that it is the likeliest place's, and where the robot is beside it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim2d import worlds
from sim2d.records import SetDown
from sim2d.robot import SimRobot
from topomap.app.config import load_config
from topomap.app.kidnapped import Lesson, teach
from topomap.core.arrays import FloatArray
from topomap.core.geometry import between, compose, wrap
from topomap.core.panorama import Panorama
from topomap.navigation.localiser.hidden import measured_in_part, seen_in_part
from topomap.navigation.localiser.mixture import Mixture
from topomap.vision.image.sectors import SECTORS

HIDDEN = 7
PEOPLE = np.random.default_rng(4)


@pytest.fixture(scope="module")
def lesson() -> Lesson:
    """A third of a lap of the hall, some 14 m."""
    return teach("hall", 0, load_config(None, ["sim.driver.laps=0.3"]))


def seen_from(lesson: Lesson, pose: FloatArray) -> Panorama:
    """The view from a true pose (3,), with something else before it in HIDDEN directions of SECTORS."""
    x, y, heading = pose.tolist()
    robot = SimRobot(worlds.load("hall"), lesson.config.sim, 0, SetDown((x, y, heading), lesson.step))
    reading = robot.sense()
    assert reading is not None
    whole = Panorama.from_reading(reading)
    image, width = whole.image.copy(), whole.rig.width
    for k in PEOPLE.choice(SECTORS, HIDDEN, replace=False).tolist():
        part = image[:, k * width // SECTORS : (k + 1) * width // SECTORS]
        people = PEOPLE.integers(0, 256, (8, 4, 3), dtype=np.uint8)
        part[:] = np.kron(
            people, np.ones((*(-(-n // m) for n, m in zip(part.shape, (8, 4), strict=False)), 1), np.uint8)
        )[: part.shape[0], : part.shape[1]]
    return Panorama(image, whole.ranges, whole.rig)


def at(pose: FloatArray) -> Mixture:
    return Mixture.at(pose, np.diag(np.square([0.4, 0.4, math.radians(6.0)])), 0.01)


def places(lesson: Lesson) -> list[int]:
    """Rows of the map's snapshots that the driver was well past the beginning and before the end at."""
    return list(range(2, len(lesson.navigator.mapper.recognition) - 2))


def test_the_likeliest_place_is_told_from_the_others_by_what_is_not_hidden(lesson: Lesson) -> None:
    mapper = lesson.navigator.mapper
    nodes = mapper.recognition.nodes()
    right, wrong = 0, 0
    for row in places(lesson):
        view = seen_from(lesson, compose(lesson.truth[nodes[row]], np.array([0.1, 0.1, 0.05])))
        here, elsewhere = mapper.map.poses[nodes[row]], mapper.map.poses[nodes[(row + len(nodes) // 2) % len(nodes)]]
        right += seen_in_part(view, at(here), mapper, nodes)
        wrong += seen_in_part(view, at(elsewhere), mapper, nodes)
    assert right == len(places(lesson))
    assert wrong <= 0.2 * len(places(lesson))  # one in ten by chance


def test_a_pose_is_measured_by_what_is_not_hidden(lesson: Lesson) -> None:
    mapper = lesson.navigator.mapper
    nodes, rng, off = mapper.recognition.nodes(), np.random.default_rng(1), []
    for row in places(lesson):
        true = np.array([0.12, -0.1, 0.06])  # the robot, seen from the place
        believed = true + rng.uniform(-1.0, 1.0, 3) * np.array([0.45, 0.45, 0.12])
        view = seen_from(lesson, compose(lesson.truth[nodes[row]], true))
        place = mapper.map.poses[nodes[row]]
        found = measured_in_part(view, at(compose(place, believed)), mapper, nodes)
        error, before = between(place, found.poses[0]) - true, believed - true
        off.append([math.hypot(*error[:2]), abs(wrap(error[2])), math.hypot(*before[:2]), abs(wrap(before[2]))])
    after, turned, before, turned_before = np.sqrt(np.mean(np.square(off), axis=0)).tolist()
    assert after < 0.6 * before
    assert turned < 0.6 * turned_before


def test_where_no_place_is_near_nothing_is_measured(lesson: Lesson) -> None:
    mapper = lesson.navigator.mapper
    nodes = mapper.recognition.nodes()
    far = at(mapper.map.poses[nodes[2]] + np.array([0.0, 40.0, 0.0]))
    view = seen_from(lesson, lesson.truth[nodes[2]])
    assert measured_in_part(view, far, mapper, nodes) is far
