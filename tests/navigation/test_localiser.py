"""The belief in a taught world: kept, lost when the robot is carried away, found again by moving, and said."""

from __future__ import annotations

import copy
import math
from itertools import pairwise

import numpy as np
import pytest
from kept import as_before, of_drive

from sim2d import worlds
from sim2d.config import SimConfig
from sim2d.records import SetDown
from sim2d.robot import SimRobot
from topomap.app.config import load_config
from topomap.app.kidnapped import Lesson, search, teach
from topomap.bench.searches import tally
from topomap.core.geometry import Pose2
from topomap.core.records import StepRecord, Where
from topomap.navigation.localiser import ANYWHERE, Localiser
from topomap.navigation.localiser.belief import Belief
from topomap.navigation.localiser.mixture import Mixture

CHAOS = 2e-3
"""By what a robot that steers by what it sees differs after 60 steps, from one kind of processor to another."""
PART = ["sim.driver.laps=0.3", "sim.camera.noise=2.0"]


@pytest.fixture(scope="module")
def lesson() -> Lesson:
    """A third of a lap of the hall, some 14 m."""
    return teach("hall", 0, load_config(None, PART))


def journey(lesson: Lesson, sim: dict[str, object], steps: int, start: Localiser | None = None) -> list[StepRecord]:
    """The way home from where the lesson ended, with things that happen on it."""
    navigator = copy.deepcopy(lesson.navigator)
    if start is not None:
        navigator.localiser = start
    config = SimConfig.model_validate({**lesson.config.sim.model_dump(), **sim})
    robot = SimRobot(worlds.load("hall"), config, 0, SetDown(lesson.end, lesson.step))
    records = []
    for _ in range(steps):
        reading = robot.sense()
        assert reading is not None
        command, record = navigator.step(reading)
        records.append(record)
        if navigator.over:
            break
        robot.act(command)
    return records


def test_an_undisturbed_robot_is_never_lost_and_nothing_is_noticed(lesson: Lesson) -> None:
    records = journey(lesson, {}, 30)
    assert max(record.where.lost for record in records) < 0.05
    assert not any(record.where.event for record in records)


def test_carried_away_it_says_so_and_claims_nothing_until_it_has_found_itself(lesson: Lesson) -> None:
    records = journey(lesson, {"kidnaps": [{"handed_over_s": 2.0, "along": -5.0, "turn_deg": 120.0}]}, 120)
    noticed = next(k for k, record in enumerate(records) if record.where.event)
    assert records[noticed].where.event.startswith("carried away")
    assert records[noticed].where.lost > 0.05  # the first view may tell one place, but proves nothing
    assert max(record.where.lost for record in records[:noticed]) < 0.05
    found = next(k for k, record in enumerate(records) if record.where.event.startswith("found itself"))
    assert all(not record.change.decisions for record in records[noticed:found])
    assert sum(record.command.forward for record in records[noticed:found]) * 0.25 < 10.0


def test_set_down_anywhere_it_finds_its_place(lesson: Lesson) -> None:
    x, y, heading = lesson.truth[len(lesson.truth) // 2].tolist()
    found = [search(lesson, (x, y, heading + turn)) for turn in (1.5, -2.5)]
    figures = tally(found)
    assert figures.soon.value == 1.0
    assert figures.sure_and_wrong == 0


def test_turned_beside_its_goal_it_proves_where_it_is_before_it_arrives() -> None:
    """It stood there, as near as it could come, until its patience ended: looking alone proves nothing."""
    lesson = teach("hall", 0, load_config(None, ["sim.driver.laps=0.05"]))
    x, y, heading = lesson.end
    found = search(lesson, (x, y, heading + 1.5))
    assert found.right
    assert len(found.lost) < 150


def test_a_belief_that_begins_anywhere_is_lost_at_first(lesson: Lesson) -> None:
    records = journey(lesson, {}, 80, Localiser(ANYWHERE))
    assert records[0].where.lost > 0.05
    found = next(record for record in records if record.where.lost < 0.05)
    assert found.where.node is not None
    here = records.index(found)
    assert math.isfinite(found.where.difference)
    assert here > 5  # it had to move


def test_turned_on_the_spot_the_view_tells_the_turn_and_nothing_is_lost(lesson: Lesson) -> None:
    records = journey(lesson, {"kidnaps": [{"handed_over_s": 1.0, "turn_deg": 90.0}]}, 12)
    headings = [record.where.pose.heading for record in records]
    steps = [abs(math.remainder(b - a, math.tau)) for a, b in pairwise(headings)]
    assert max(steps) > 1.2  # the carried turn, and what the wheels turned meanwhile
    assert max(record.where.lost for record in records) < 0.3


def test_finding_itself_is_as_before(lesson: Lesson) -> None:
    as_before("found anywhere", of_drive(journey(lesson, {}, 80, Localiser(ANYWHERE)), 2), close=CHAOS)


def test_the_lesson_and_the_way_home_are_as_before(lesson: Lesson) -> None:
    found = journey(lesson, {"kidnaps": [{"handed_over_s": 2.0, "along": -5.0}]}, 60)
    as_before("way home", of_drive(found, 2), close=CHAOS)


@pytest.mark.parametrize(("alike", "said"), [(0.3, "the odometry was 1.5 m off"), (2.0, "")])
def test_where_views_are_alike_over_metres_the_belief_is_no_surer_than_odometry(
    lesson: Lesson, alike: float, said: str
) -> None:
    mapper = copy.deepcopy(lesson.navigator).mapper
    for _ in range(60):
        for times, difference in ((0.25, 0.1), (0.5, 0.2), (1.0, 0.5), (2.0, 1.0), (4.0, 1.0), (16.0, 1.0)):
            mapper.recognition.catchment.learn(times * alike, difference)
    assert (mapper.catchment > 1.0) == (not said)
    here = mapper.track.pose
    there = here @ Pose2(1.5, 0.0, 0.45)
    localiser = Localiser()
    localiser._belief = belief = Belief(Mixture.at(there.array(), np.diag([0.01, 0.01, 0.001]), 1e-4), mapper.map)
    localiser._right = mapper.map.chain[-3]
    belief.stretches = 3
    doubt = localiser._doubt(belief, mapper)
    assert doubt == pytest.approx(1e-4, rel=0.01) if not said else doubt == 1.0
    assert localiser._mend(Where(there, 0, 0.1, 1e-4), mapper, driven=True).startswith(said)
    assert (mapper.track.pose.distance(here) < 1e-9) == (not said)
