"""The bench of sessions: two drives merged against one long drive, and a map that is gone on with and pruned."""

from __future__ import annotations

import itertools
import json
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from sim2d.errors import WorldError
from sim2d.robot import SimRobot
from topomap.app.config import load_config
from topomap.app.runs import open_world
from topomap.app.saved_map import SavedMap
from topomap.app.sweep import source_digest, world_digests
from topomap.app.warm_up import warm_up
from topomap.app.wiring import build_navigator, versions
from topomap.bench.pool import Store, workers
from topomap.bench.sessions import Growth, Merging, Truths, figures
from topomap.core.errors import DataError
from topomap.core.geometry import Pose2
from topomap.core.records import Command
from topomap.core.robot import Reading
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapfile import load_map, save_map
from topomap.mapping.mapper import MapperSettings
from topomap.mapping.sessions.cross_claims import CrossClaims
from topomap.mapping.sessions.merge import merge
from topomap.mapping.sessions.prune import prune
from topomap.navigation.localiser import Start
from topomap.vision.registry import aligner

LAPS, OFFSET, ALL = 0.8, 0.4, 1.6
"""Laps of each of the two drives, how far along the lap the second one begins, and those of the long one: either way
1.6 laps are driven, and 0.6 of them are on known ground."""
LESSON = 1.2
"""Laps of the lesson before a map grows: the ring is closed."""
OTHER = 50
"""The second drive's seed is so much higher."""


@dataclass(frozen=True, slots=True)
class Driven:
    """A drive's finished map, and where its nodes truly are by their number."""

    map: TopoMap
    truths: Truths


def drive(world: str, seed: int, words: Sequence[str], known: Driven | None = None) -> Driven:
    """Drive a world's route once, on a map that is known where its first node is, or a fresh one. Raises DataError."""
    config = load_config(None, ["stack.mission.do=teach", *words])
    warm_up(config.stack)
    robot = open_world(world, seed, config)
    saved = None if known is None else SavedMap(known.map, Start(node=known.map.chain[0]))
    navigator = build_navigator(config.stack, saved=saved)
    truths: dict[int, Pose2] = {}
    while (reading := _sensed(robot)) is not None and reading.driven:
        navigator.step(reading)
        true = robot.truth()
        truths[reading.stamp_ns] = Pose2(true.x, true.y, true.heading)
        robot.act(Command())
    navigator.mapper.finish(max(truths))
    topo = navigator.mapper.map
    own = dict(known.truths) if known else {}
    for name, node in zip(topo.names, topo.nodes, strict=True):
        if name not in own:
            pose = truths[node.stamp_ns]
            own[name] = pose.x, pose.y, pose.heading
    return Driven(topo, own)


def _sensed(robot: SimRobot) -> Reading | None:
    """Return the next reading. Raises DataError where the driver is stuck."""
    try:
        return robot.sense()
    except WorldError as error:
        raise DataError(f"{robot.world.name}: {error}") from error


def _key(kind: str, world: str, *own: object) -> str:
    return json.dumps([kind, Path(world).name, world_digests(world), *own, versions(), source_digest()])


@dataclass(frozen=True, slots=True)
class MergeTask:
    """A long drive, and two that overlap: a pool Task."""

    world: str
    seed: int
    words: tuple[str, ...]

    @property
    def key(self) -> str:
        """All that decides the result."""
        return _key("merge", self.world, self.seed, self.words)

    def perform(self) -> Merging:
        """Drive, merge and judge. Raises DataError, and TopomapError where the two share no ground."""
        long = self._drive(self.seed, ALL, 0.0)
        first, second = self._drive(self.seed, LAPS, 0.0), self._drive(self.seed + OTHER, LAPS, OFFSET)
        claims = CrossClaims(aligner("min-warping"), MapperSettings().closing.offset)
        merged = merge(first.map, second.map, claims, lambda _, __: None)
        truths = {**first.truths, **{name + merged.offset: pose for name, pose in second.truths.items()}}
        return Merging(
            Path(self.world).stem, self.seed, self.words,
            figures(long.map, long.truths), figures(merged.map, truths),
        )  # fmt: skip

    def _drive(self, seed: int, laps: float, skipped: float) -> Driven:
        """Drive so many laps, begun so many laps along the route."""
        config = load_config(None, [*self.words, "sim.driver.laps=1"])
        lap = open_world(self.world, seed, config).route_length_m
        along = [f"sim.start.along={skipped * lap:.2f}"] if skipped else []
        return drive(self.world, seed, [*self.words, f"sim.driver.laps={laps + skipped:g}", *along])


@dataclass(frozen=True, slots=True)
class GrowthTask:
    """A map that is gone on with lap after lap, pruned and saved after each: a pool Task."""

    world: str
    seed: int
    laps: int
    words: tuple[str, ...]

    @property
    def key(self) -> str:
        """All that decides the result."""
        return _key("growth", self.world, self.seed, self.laps, self.words)

    def perform(self) -> Growth:
        """Drive, prune and judge. Raises DataError."""
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "map.topomap"
            now = _pruned(drive(self.world, self.seed, [*self.words, f"sim.driver.laps={LESSON}"]), file)
            nodes, sizes = [len(now.map.nodes)], [file.stat().st_size]
            for lap in range(1, self.laps + 1):
                seed = self.seed + lap * OTHER
                now = _pruned(drive(self.world, seed, [*self.words, "sim.driver.laps=1"], now), file)
                nodes.append(len(now.map.nodes))
                sizes.append(file.stat().st_size)
        last = figures(now.map, now.truths)
        return Growth(Path(self.world).stem, self.seed, self.words, tuple(nodes), tuple(sizes), last)


def _pruned(driven: Driven, file: Path) -> Driven:
    """Return a map without what adds nothing, saved and loaded again, with the truths of what is left."""
    save_map(prune(driven.map).map, file)
    topo = load_map(file)
    return replace(driven, map=topo, truths={name: driven.truths[name] for name in topo.names})


def plan(worlds: str, seeds: Sequence[int], laps: int, words: Sequence[str]) -> list[MergeTask | GrowthTask]:
    """Return a merge task and, where there are laps, a growth task for each world and seed, each world checked first.

    Raises DataError, ConfigError.
    """
    names = [word.strip() for word in worlds.split(",") if word.strip()]
    if not names:
        raise DataError("--worlds: name one or more, as in hall,office-loop")
    for name in names:  # a route with a tail can't be driven by parts of a lap
        open_world(name, 0, load_config(None, [*words, f"sim.driver.laps={LAPS}"]))
    every = list(itertools.product(names, seeds))
    merges: list[MergeTask | GrowthTask] = [MergeTask(*one, tuple(words)) for one in every]
    return merges + ([GrowthTask(*one, laps, tuple(words)) for one in every] if laps else [])


def run_sessions(
    tasks: Sequence[MergeTask | GrowthTask], store: Store, count: int, progress: Callable[[int], None]
) -> tuple[list[Merging], list[Growth]]:
    """Return what became of all tasks."""
    done = itertools.count(1)
    with workers(count, store) as hands:
        merges = hands.run([t for t in tasks if isinstance(t, MergeTask)], lambda: progress(next(done)))
        growths = hands.run([t for t in tasks if isinstance(t, GrowthTask)], lambda: progress(next(done)))
    return merges, growths
