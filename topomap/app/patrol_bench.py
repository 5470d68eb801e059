"""The bench of patrols: a map that was taught and saved, and another drive from goal to goal on it."""

from __future__ import annotations

import itertools
import json
import math
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from sim2d.robot import SimRobot
from topomap.app.config import load_config
from topomap.app.made_file import write_made
from topomap.app.mission_steps import expected_steps, way_between
from topomap.app.runs import STEPS_RATIO, STEPS_SPARE, open_world
from topomap.app.saved_map import SavedMap
from topomap.app.session_bench import OTHER, drive
from topomap.app.sweep import source_digest, world_digests
from topomap.app.wiring import build_navigator, versions
from topomap.bench.belief import is_wrong
from topomap.bench.journeys import Journey, Trip, Watched
from topomap.bench.patrols import Patrol
from topomap.bench.pool import Store, workers
from topomap.bench.sessions import MapFigures, Truths, figures
from topomap.core.errors import DataError
from topomap.core.geometry import Pose2
from topomap.core.records import Phase, StepRecord, Where
from topomap.core.robot import Reading
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapfile import load_map, save_map
from topomap.mapping.mapper import Mapper
from topomap.navigation.runner import run


class Legs:
    """An observer that judges each leg of a patrol; known: where the map's nodes truly are, by number.

    trip: what all legs share, its goal and number aside.
    """

    def __init__(self, robot: SimRobot, mapper: Mapper, known: Truths, trip: Trip) -> None:
        self._robot, self._mapper, self._trip = robot, mapper, trip
        self._known = dict(known)
        self._driven: dict[int, tuple[float, float, float]] = {}
        self.made: list[Journey] = []
        self._watched: Watched | None = None
        self._goal = 0
        self._from: int | None = None

    def observe(self, reading: Reading, record: StepRecord) -> None:
        """Take one step."""
        self._driven[reading.stamp_ns] = self._here()
        if record.goal.node is None:
            return
        if self._watched is None:
            self._goal, self._watched = record.goal.node, Watched(self._robot.truth, self._wrong)
            self._from = self._nearest() if self._from is None else self._from
        self._watched.observe(reading, record)
        if record.travel.phase in (Phase.ARRIVED, Phase.FAILED):
            self._end(self._watched, record.travel.phase is Phase.ARRIVED, over=True)

    def close(self) -> MapFigures:
        """Judge a leg that was cut off, finish the map and return its figures."""
        if self._watched is not None:
            self._end(self._watched, claimed=False, over=False)
        self._mapper.finish(max(self._driven))
        topo = self._mapper.map
        return figures(topo, {name: self._truth(node) for node, name in enumerate(topo.names)})

    def _end(self, watched: Watched, claimed: bool, over: bool) -> None:
        topo, goal = self._mapper.map, self._goal
        assert self._from is not None
        trip = replace(self._trip, number=len(self.made), goal=topo.names[goal])
        planned = way_between(topo, self._from, goal)
        self.made.append(watched.judged(trip, claimed, over, self._truth(goal)[:2], planned))
        self._watched, self._from = None, goal if claimed else None

    def _here(self) -> tuple[float, float, float]:
        now = self._robot.truth()
        return now.x, now.y, now.heading

    def _truth(self, node: int) -> tuple[float, float, float]:
        """Return where a node truly is."""
        topo = self._mapper.map
        return self._known.get(topo.names[node]) or self._driven[topo.nodes[node].stamp_ns]

    def _nearest(self) -> int:
        """Return the node truly nearest to the robot: where the way to the goal is taken to begin."""
        here = self._here()[:2]
        return min(range(len(self._mapper.map.nodes)), key=lambda node: math.dist(self._truth(node)[:2], here))

    def _wrong(self, where: Where) -> bool:
        if where.node is None:
            return True
        node, true = self._mapper.map.pose(where.node), Pose2(*self._truth(where.node))
        return is_wrong(where, Pose2(*self._here()), true, node)


@dataclass(frozen=True, slots=True)
class PatrolTask:
    """A world that is taught, and a patrol over so many goals by another robot on the saved map: a pool Task.

    words: settings of both drives; changed: settings that the patrol alone has.
    """

    world: str
    seed: int
    count: int
    words: tuple[str, ...]
    changed: tuple[str, ...]

    @property
    def key(self) -> str:
        """All that decides the result."""
        own = [Path(self.world).name, world_digests(self.world), self.seed, self.count, self.words, self.changed]
        return json.dumps(["patrol", *own, versions(), source_digest()])

    def perform(self) -> Patrol:
        """Teach, save, load and patrol. Raises DataError."""
        with tempfile.TemporaryDirectory() as folder:
            taught = drive(self.world, self.seed, self.words)
            file = Path(folder) / "map.topomap"
            save_map(taught.map, file)
            made, after = self._patrol(file, taught.truths)
        before = figures(taught.map, taught.truths).ate
        world = Path(self.world).stem
        return Patrol(world, self.seed, self.words, self.changed, self.count, tuple(made), before, after)

    def _patrol(self, file: Path, truths: Truths) -> tuple[list[Journey], MapFigures]:
        """Go from goal to goal on a map, with another odometer, put where the route begins and not told so."""
        seed = self.seed + OTHER
        wish = "patrol:" + ",".join(str(goal) for goal in goals(load_map(file), seed, self.count))
        own = [f"stack.mission.do={wish}", "sim.driver.teaches=false"]
        config = load_config(None, [*self.words, *self.changed, *own])
        robot = open_world(self.world, seed, config)
        saved = SavedMap.open(file, config.stack.mission)
        navigator = build_navigator(config.stack, saved=saved)
        trip = Trip(Path(self.world).stem, self.seed, config.sim.textures, (*self.words, *self.changed), "patrol", 0, 0)
        legs = Legs(robot, navigator.mapper, truths, trip)
        most = STEPS_SPARE + STEPS_RATIO * expected_steps(robot, config.stack.mission, saved)
        steps = itertools.count()
        run(robot, navigator, (legs,), lambda: next(steps) >= most)
        after = legs.close()
        return legs.made, after


def goals(topo: TopoMap, seed: int, count: int) -> list[int]:
    """Return the numbers of so many nodes with views, drawn one after the other, never the same twice in a row."""
    rng = np.random.default_rng(seed)
    views = [name for name, node in zip(topo.names, topo.nodes, strict=True) if node.snapshot is not None]
    drawn: list[int] = []
    while len(drawn) < count:
        name = views[int(rng.integers(len(views)))]
        if drawn[-1:] != [name] or len(views) == 1:
            drawn.append(name)
    return drawn


def plan(
    worlds: str, seeds: Sequence[int], count: int, words: Sequence[str], changed: Sequence[str]
) -> list[PatrolTask]:
    """Return a task for each world and seed, each world checked first. Raises DataError, ConfigError."""
    names = [word.strip() for word in worlds.split(",") if word.strip()]
    if not names:
        raise DataError("--worlds: name one or more, as in hall,office-loop")
    for name in names:
        open_world(name, 0, load_config(None, [*words, *changed]))
    every = itertools.product(names, seeds)
    return [PatrolTask(world, seed, count, tuple(words), tuple(changed)) for world, seed in every]


def run_patrols(tasks: Sequence[PatrolTask], store: Store, count: int, progress: Callable[[int], None]) -> list[Patrol]:
    """Return what became of all patrols; progress: is told how many are made."""
    done = itertools.count(1)
    with workers(count, store) as hands:
        return hands.run(tasks, lambda: progress(next(done)))


def write(made: Sequence[Patrol], folder: Path) -> Path:
    """Write every leg with its notes. Raises DataError where that can't be done."""
    return write_made(made, folder / "patrols.json")
