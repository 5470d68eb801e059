"""The milestone spacing study by the simulated robot: it is led along a way, then goes it by each method alone."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

from sim2d import worlds
from sim2d.errors import WorldError
from sim2d.records import SetDown
from sim2d.robot import SimRobot
from topomap.app.config import load_config
from topomap.app.sweep import source_digest
from topomap.bench.pool import Store, workers
from topomap.core.errors import DataError
from topomap.core.geometry import Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.experiments.spacing import LEGS, SPACINGS, Course, Follower, judged, milestones
from topomap.vision.registry import aligned_homing, entries

APART = 0.618
"""Share of the route by which the starts of following seeds lie apart: they spread evenly over it."""
Pose = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class SpacingTask:
    """All spacings of one method, world and seed (of looks, noise and where the way begins): a pool Task."""

    world: str
    method: str
    seed: int
    spacings: tuple[float, ...] = SPACINGS

    @property
    def key(self) -> str:
        """All that decides the result."""
        return json.dumps(["spacing", self.world, self.method, self.seed, self.spacings, source_digest()])

    def perform(self) -> list[Course]:
        """Lead the robot along a way, then let it go by the method."""
        taught = _teach(self.world, self.seed, LEGS * max(self.spacings))
        return [self._course(taught, spacing) for spacing in self.spacings]

    def _course(self, taught: _Taught, spacing: float) -> Course:
        course, places = milestones(taught.way, spacing)
        robot = taught.again(self.seed)
        errors: list[float] = []
        wrong = False

        def reached(k: int) -> bool:
            nonlocal wrong
            here = robot.truth()
            wrong = not judged(math.dist((here.x, here.y), taught.truth[places[k]][:2]), errors)
            return not wrong

        follower = Follower(aligned_homing(self.method), course)
        legs = follower.follow(robot, reached, taught.way[0][1], spacing)
        robot.stop()
        return Course(self.world, self.method, self.seed, spacing, legs, tuple(errors), wrong)


@dataclass(frozen=True, slots=True, eq=False)
class _Taught:
    """A way that the driver led along: views, odometry, metres; and the true poses, for setting down and judging."""

    robot: SimRobot
    way: list[tuple[Panorama, Pose2, float]]
    truth: list[Pose]

    def again(self, seed: int) -> SimRobot:
        """Return a robot at the beginning of the way, with nobody driving."""
        return SimRobot(self.robot.world, CONFIG.sim, seed, SetDown(self.truth[0], len(self.way)))


CONFIG = load_config(None, ())


@lru_cache(maxsize=1)
def _teach(world: str, seed: int, length: float) -> _Taught:
    """Drive `length` [m] of a world's route, from another place of it for each seed; kept for the next method.

    Raises DataError.
    """
    try:
        made = worlds.load(world, seed)
        whole = SimRobot(made, CONFIG.sim, seed).route_length_m
        along = (seed * APART) % 1.0 * max(whole - length - 1.0, 0.0)
        start = CONFIG.sim.start.model_copy(update={"along": along})
        robot = SimRobot(made, CONFIG.sim.model_copy(update={"start": start}), seed)
    except WorldError as error:
        raise DataError(str(error)) from error
    way, truth = list[tuple[Panorama, Pose2, float]](), list[Pose]()
    at, metres = Pose2(), 0.0
    while (reading := robot.sense()) is not None and reading.driven and metres <= length + 0.1:
        m = reading.motion
        at = at @ Pose2(m.forward * math.cos(m.turn / 2), m.forward * math.sin(m.turn / 2), wrap(m.turn))
        here = robot.truth()
        metres += math.dist(truth[-1][:2], (here.x, here.y)) if truth else 0.0
        way.append((Panorama.from_reading(reading), at, metres))
        truth.append((here.x, here.y, here.heading))
    if metres < length:
        raise DataError(
            f"{world}: its route is {metres:.1f} m long; {LEGS} milestones so far apart take {length:.1f} m"
        )
    return _Taught(robot, way, truth)


def plan(
    names: Sequence[str], methods: str, seeds: Sequence[int], spacings: Sequence[float] = SPACINGS
) -> list[SpacingTask]:
    """Return the tasks of worlds, methods ("all": every one that claims to home), seeds and spacings [m].

    Raises DataError.
    """
    known = list(dict.fromkeys(e.name for e in entries() if e.homes and (e.kind != "aligner" or _alone(e.name))))
    chosen = known if methods == "all" else [word.strip() for word in methods.split(",") if word.strip()]
    for name in chosen:
        aligned_homing(name)
    places = itertools.product(names, seeds)
    return [SpacingTask(world, name, seed, tuple(spacings)) for world, seed in places for name in dict.fromkeys(chosen)]


def _alone(name: str) -> bool:
    """Return whether an aligner homes by itself."""
    try:
        return aligned_homing(name).method is None
    except DataError:
        return False


def run_spacing(
    tasks: Sequence[SpacingTask], store: Store, count: int, progress: Callable[[int], None]
) -> list[Course]:
    """Return all courses."""
    done = itertools.count(1)
    with workers(count, store) as hands:
        found = hands.run(tasks, lambda: progress(next(done)))
    return [course for courses in found for course in courses]
