"""Many journeys over one taught map of a simulated world: each from a start and with a disturbance of its own."""

from __future__ import annotations

import copy
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim2d import worlds
from sim2d.errors import WorldError
from sim2d.robot import SimRobot
from sim2d.streams import stream
from topomap.app.config import RunConfig, load_config
from topomap.app.disturbed import Disturbance, Disturbed
from topomap.app.warm_up import warm_up
from topomap.app.wiring import build_navigator
from topomap.bench.belief import is_wrong
from topomap.bench.journeys import Journey, Trip, Watched
from topomap.core.arrays import FloatArray
from topomap.core.errors import DataError
from topomap.core.geometry import Pose2
from topomap.core.records import Phase, StepRecord, Where
from topomap.core.robot import Reading, Truth
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapper import Mapper
from topomap.navigation import planner
from topomap.navigation.runner import run

FROM = 0.25
"""[m] Truth kept of the lesson: one pose each so many metres, where a journey may start."""
FAR = 5.0
"""[m] Distance of a goal that is drawn from the lesson's end, at least."""


@dataclass(frozen=True, slots=True, eq=False)
class Taught:
    """A taught map, the robot at the end of the lesson, the true pose (x, y, heading) at each stamp, the settings.

    words: the settings that differ from the default ones.
    """

    world: str
    seed: int
    looks: int
    robot: SimRobot
    mapper: Mapper
    truth: dict[int, tuple[float, float, float]]
    config: RunConfig
    words: tuple[str, ...] = ()

    def end(self) -> tuple[float, float, float]:
        """Return where the lesson ended."""
        return self.truth[max(self.truth)]

    def places(self) -> FloatArray:
        """Return the true poses (K, 3) of the lesson, FROM apart."""
        kept = [self.end()]
        for stamp in sorted(self.truth, reverse=True):
            if math.dist(self.truth[stamp][:2], kept[-1][:2]) >= FROM:
                kept.append(self.truth[stamp])
        return np.array(kept)


def teach(world: str, seed: int, looks: int, words: Sequence[str] = ()) -> Taught:
    """Drive the lesson of a world with some settings. Raises DataError for an unknown world, ConfigError."""
    config = load_config(None, words)
    warm_up(config.stack)
    try:
        robot = SimRobot(worlds.load(world, looks), config.sim, seed)
    except WorldError as error:
        raise DataError(str(error)) from error
    navigator = build_navigator(config.stack)
    truth: dict[int, tuple[float, float, float]] = {}

    class Lesson:
        """Takes the truth of each step, and ends when the driver hands over."""

        over = False

        def observe(self, reading: Reading, record: StepRecord) -> None:
            now = robot.truth()
            truth[reading.stamp_ns] = (now.x, now.y, now.heading)
            self.over = not reading.driven

    lesson = Lesson()
    run(_Kept(robot), navigator, (lesson,), lambda: lesson.over)
    return Taught(world, seed, looks, robot, navigator.mapper, truth, config, tuple(words))


class _Kept:
    """A robot that outlives a run: stopping it only stops its wheels."""

    def __init__(self, robot: SimRobot) -> None:
        self._robot = robot
        self.sense, self.act = robot.sense, robot.act

    def stop(self) -> None:
        self._robot.rest()


def journeys(
    taught: Taught, goal: int | None, disturbances: Sequence[Disturbance], steps: int = 6000
) -> Iterator[Journey]:
    """Travel to a node once for each disturbance, always with the map as it was after the lesson.

    goal: None draws one for each journey. What a journey is like depends on its kind and on how many of that kind went
    before it, not on other kinds: where neither start nor goal is drawn, those of a kind are much the same.
    """
    made = Counter[str]()
    for disturbance in disturbances:
        kind, number = disturbance.kind, made[disturbance.kind]
        made[kind] += 1
        to = _drawn_goal(taught, stream(taught.seed, f"goal {number} {kind}")) if goal is None else goal
        trip = Trip(Path(taught.world).stem, taught.seed, taught.looks, taught.words, kind, number, to)
        yield travel(taught, trip, disturbance, steps)


def _drawn_goal(taught: Taught, rng: np.random.Generator) -> int:
    """Return a snapshot that isn't near the lesson's end by the map, or the first node where none is far enough."""
    topo = taught.mapper.map
    away = [topo.length(node, topo.chain[-1]) for node in range(len(topo.nodes))]
    views = [k for k, node in enumerate(topo.nodes) if node.snapshot is not None and away[k] >= FAR]
    return views[int(rng.integers(len(views)))] if views else 0


def travel(taught: Taught, trip: Trip, disturbance: Disturbance, steps: int) -> Journey:
    """Make one journey of at most so many steps and judge it by the truth."""
    config, goal = taught.config.stack, trip.goal
    mission = config.mission.model_copy(update={"goal_node": goal})
    navigator = build_navigator(config.model_copy(update={"mission": mission}))
    navigator.take(copy.deepcopy(taught.mapper))
    topo = navigator.mapper.map
    if goal >= len(topo.nodes):
        raise DataError(f"--goal {goal}: the map of {taught.world} has {len(topo.nodes)} nodes, from 0 on")
    # a copy with its world, so that what a journey is like doesn't depend on those before it
    mine = copy.deepcopy(taught.robot)
    mine.put(*taught.end())
    rng = stream(taught.seed, f"journey {trip.number} {trip.kind}")
    watched = Watched(mine.truth, lambda where: _is_wrong(where, mine.truth(), taught, topo))
    planned = _length(topo.poses, planner.route(topo, topo.chain[-1], goal))
    target = taught.truth[topo.nodes[goal].stamp_ns][:2]
    robot = Disturbed(mine, disturbance, taught.places(), target, rng)
    run(robot, navigator, (watched,), lambda: watched.steps >= steps)
    return watched.judged(trip, navigator.phase is Phase.ARRIVED, navigator.over, target, planned)


def _is_wrong(where: Where, now: Truth, taught: Taught, topo: TopoMap) -> bool:
    node = None if where.node is None else topo.pose(where.node)
    true = None if where.node is None else Pose2(*taught.truth[topo.nodes[where.node].stamp_ns])
    return is_wrong(where, Pose2(now.x, now.y, now.heading), true, node)


def _length(poses: FloatArray, path: list[int]) -> float:
    return float(np.hypot(*np.diff(poses[path, :2], axis=0).T).sum())
