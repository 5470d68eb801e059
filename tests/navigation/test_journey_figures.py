"""Journeys on the square map, step by step: the same commands and words as before."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from homing_fakes import Knowing, KnowingCompass
from kept import as_before
from maps import square
from roamer import Roamer, difference

from topomap.core.geometry import Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, HomeVector, Hypothesis
from topomap.navigation import sight
from topomap.navigation.arrival import Arrival
from topomap.navigation.edge_costs import Shut, costs, edges_of
from topomap.navigation.manoeuvres.relocalise import free_bearing
from topomap.navigation.pilot import Pilot, PilotSettings
from topomap.navigation.planner import near, route
from topomap.navigation.senses import Health
from topomap.navigation.steering import heading_for, share_of_view
from topomap.navigation.way_round import way_round
from topomap.vision.aligned_homing import AlignedHoming


def wall(x: float) -> Callable[[Pose2, Pose2], bool]:
    return lambda before, after: after.y < 1.0 and abs(after.x - x) < 0.2 and abs(after.x - x) < abs(before.x - x)


def wanders() -> Callable[[Pose2], Pose2]:
    """A belief that is off by something else in every step, as one is."""
    rng = np.random.default_rng(3)

    def believed(pose: Pose2) -> Pose2:
        x, y, turn = rng.normal(size=3) * [0.05, 0.05, 0.04]
        return Pose2(pose.x + x, pose.y + y, pose.heading + turn)

    return believed


def robots() -> dict[str, tuple[Roamer, int, int]]:
    """Robots, each with its goal and the steps it is watched for."""
    blind = AlignedHoming(KnowingCompass(), Knowing(silent_beyond=-9.0))
    return {
        "free": (Roamer(), 12, 200),
        "unsure": (Roamer(believed=wanders(), lost=0.04), 10, 200),
        "doubtful": (Roamer(believed=wanders(), lost=0.2), 6, 120),
        "blocked": (Roamer(wall=wall(2.25)), 8, 260),
        "lost": (Roamer(lost=0.9, homing=blind), 8, 160),
        "rivals": (Roamer(pose=Pose2(0.6, 0.1, 2.0), rivals=(Hypothesis(9, Pose2(9.0, 9.0), 0.4),)), 0, 120),
        "off course": (Roamer(pose=Pose2(1.0, 2.5, 0.0), believed=wanders()), 20, 200),
        "slow": (Roamer(pose=Pose2(0.3, 0.2, math.pi), health=Health(slow=True)), 9, 120),
        "beside": (Roamer(believed=lambda pose: Pose2(pose.x + 0.3, pose.y - 0.3, pose.heading + 0.1)), 10, 160),
    }


@pytest.mark.parametrize("name", robots())
def test_journeys_are_as_before(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sight, "aligned_difference", difference)
    robot, goal, steps = robots()[name]
    robot.travel(goal, steps)
    told = robot.travels
    as_before(
        f"journey {name}",
        {
            "forward": [command.forward for command in robot.commands],
            "turn": [command.turn for command in robot.commands],
            "milestone": [-1 if one.milestone is None else one.milestone for one in told],
            "left": [-1 if one.legs_left is None else one.legs_left for one in told],
            "bearing": [9.0 if one.home is None else one.home.bearing for one in told],
            "difference": [9.0 if one.difference is None else one.difference for one in told],
            "said": [f"{k}: {one.note}" for k, one in enumerate(told) if one.note],
            "end": [str(told[-1].phase)],
        },
    )


def rooms() -> list[np.ndarray]:
    """Ranges in rooms with things in them, some so near that they touch, and rays that met nothing."""
    found = []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        angle = np.arange(180) * math.tau / 180
        walls = rng.uniform(0.6, 4.0, 4)
        reach = np.minimum.reduce([w / np.maximum(np.cos(angle - k * math.pi / 2), 1e-3) for k, w in enumerate(walls)])
        things = rng.uniform([0.0, 0.05, 0.15], [math.tau, 0.4, 2.0], (4, 3))
        for at, wide, away in things:
            reach[np.abs(np.remainder(angle - at + math.pi, math.tau) - math.pi) < wide] = away
        reach[rng.random(180) < 0.05] = np.nan
        found.append(reach.astype(np.float32))
    return found


def test_steering_is_as_before() -> None:
    rng, pilot, topo = np.random.default_rng(5), Pilot(PilotSettings()), square(8)
    steered, round_, free, joined = [], [], [], []
    for ranges in rooms():
        for bearing in (-2.5, -0.4, 0.0, 0.7, 3.0):
            aims = [(1.0 * math.cos(bearing), 1.0 * math.sin(bearing)), (1.4, 0.2)]
            for command in (pilot.steer(bearing, ranges, 0.3), pilot.steer(bearing, ranges, None, aims)):
                steered += [command.forward, command.turn]
            way = way_round(aims, ranges, 0.26)
            round_.append(9.0 if way is None else way)
        free.append(free_bearing(ranges))
        joined.append(str(near(topo, Pose2(1.2, 0.3, 0.4), ranges, (Shut(1.7, 0.3, 0),))))
    headed = []
    for _ in range(40):
        pose, milestone, ahead = (Pose2(*rng.uniform(-1.0, 1.0, 3)) for _ in range(3))
        home = HomeVector(float(rng.uniform(-3, 3)), None, float(rng.choice([0.0, 0.3, 0.9])))
        lost, least = float(rng.choice([0.0, 0.3, 0.6])), float(rng.choice([0.0, 0.3]))
        headed.append(heading_for(pose, milestone, ahead, home, lost, least))
        headed.append(share_of_view(home, pose.bearing_to(milestone), pose.distance(milestone), lost, least))
    as_before("steering", {"pilot": steered, "round": round_, "free": free, "joined": joined, "headed": headed})


def test_what_edges_cost_is_as_before() -> None:
    topo = square(8)
    for a, b, seconds in ((0, 1, 2.0), (1, 2, 9.0), (5, 4, 1.0)):
        topo.experience.passed(a, b, seconds)
    for a, b, stamp in ((1, 2, 10**12), (7, 6, 2 * 10**12), (9, 10, 29 * 10**11)):
        topo.experience.failed(a, b, stamp)
    shut, now = (Shut(2.0, 0.1, 29 * 10**11), Shut(4.0, 2.0, 10**12)), 3 * 10**12
    there, back = (np.minimum(one, 1e3) for one in costs(topo, edges_of(topo), shut, now))
    routes = [route(topo, a, b, shut, now) for a, b in ((0, 20), (12, 2), (30, 9))]
    as_before("edge costs", {"there": there, "back": back, "routes": [node for way in routes for node in way]})


def test_arrivals_are_as_before() -> None:
    rng, found = np.random.default_rng(1), []
    for _ in range(12):
        arrival, middle = Arrival(), rng.uniform(5, 20)
        curve = rng.uniform(0.05, 0.6) + 0.05 * np.abs(np.arange(40) - middle) + rng.normal(0, 0.01, 40)
        met = [arrival.update(float(one)) for one in curve]
        found.append(met.index(True) if True in met else -1)
    as_before("arrivals", {"steps": found})


class Expecting:
    """A compass that knows, and keeps how far off it was told to look."""

    def __init__(self) -> None:
        self.off: list[float] = []

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        found = KnowingCompass().align(current, goal)
        self.off.append(abs(wrap(found.rotation - (prior or 0.0))))
        return found


def test_a_milestone_is_looked_for_as_the_wheels_turned(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sight, "aligned_difference", difference)
    compass = Expecting()
    robot = Roamer(pose=Pose2(0.0, 0.0, 2.0), lost=0.06, homing=AlignedHoming(compass, Knowing()))
    robot.travel(3, 25)
    assert max(abs(command.turn) for command in robot.commands) > 0.5
    assert float(np.median(compass.off)) < 0.02  # as fine as a view tells its heading
    assert sum(off > 0.1 for off in compass.off) <= 2
