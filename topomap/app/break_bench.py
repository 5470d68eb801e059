"""The bench of breaks put together: what breaks is drawn, each drive is taught with it, and one file says it all."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from topomap.app.config import load_config
from topomap.app.made_file import write_made
from topomap.app.runs import open_world
from topomap.app.sweep import source_digest, world_digests
from topomap.app.warm_up import warm_up
from topomap.app.wiring import build_navigator, versions
from topomap.bench.breaks import BreakDrive, BreakWatch
from topomap.bench.pool import Store, workers
from topomap.core.errors import DataError
from topomap.core.geometry import Pose2
from topomap.core.records import Command

Kind = Literal["none", "lifted", "turned", "slip", "dead", "one wheel", "reset"]
KINDS: tuple[Kind, ...] = ("lifted", "turned", "slip", "dead", "one wheel", "reset")
WHEN = 0.2, 0.7
"""Share of the route at which it breaks: there is something before, and something to be seen again behind."""


@dataclass(frozen=True, slots=True)
class Break:
    """What breaks, at what share of the route, by how much [m] (turned and one wheel: [degree]), and its setting."""

    kind: Kind
    at: float
    size: float
    word: str


def draw(kind: Kind, rng: np.random.Generator, seconds: float, speed: float) -> tuple[float, float, str]:
    """Return when it breaks [s], by how much, and the setting that does it; seconds: the route takes, at speed [m/s].

    lifted: somebody carries the robot on or back; turned: somebody turns it; slip: wheels count more than they drive;
    dead: they count nothing; one wheel: the other one counts nothing, which reads as a turn; reset: the odometer begins
    anew elsewhere, which reads as one leap.
    """
    at = round(float(rng.uniform(*WHEN)) * seconds, 2)  # as its setting says it
    sign = float(rng.choice([-1.0, 1.0]))
    when = f"at_s = {at:.2f}"
    if kind == "lifted":
        size = float(rng.uniform(1.5, 6.0))
        turn = float(rng.choice([0.0, rng.uniform(-180.0, 180.0)]))
        return at, size, f"sim.kidnaps=[{{{when}, along = {sign * size:.2f}, turn_deg = {turn:.0f}}}]"
    if kind == "turned":
        size = float(rng.uniform(30.0, 180.0))
        return at, size, f"sim.kidnaps=[{{{when}, along = 0.0, turn_deg = {sign * size:.0f}}}]"
    if kind == "slip":
        size, times = float(rng.uniform(1.5, 5.0)), float(rng.uniform(2.0, 5.0))
        lasts = size / (times - 1) / speed
        return at, size, f"sim.odometry_faults=[{{{when}, lasts_s = {lasts:.2f}, forward_scale = {times:.2f}}}]"
    if kind == "dead":
        size = float(rng.uniform(1.5, 5.0))
        fault = "forward_scale = 0.0, turn_scale = 0.0"
        return at, size, f"sim.odometry_faults=[{{{when}, lasts_s = {size / speed:.2f}, {fault}}}]"
    if kind == "one wheel":
        size, rate = float(rng.uniform(40.0, 180.0)), float(rng.uniform(0.5, 3.0))
        lasts = math.radians(size) / rate / speed
        fault = f"forward_scale = 0.5, turn_per_m = {sign * rate:.2f}"
        return at, size, f"sim.odometry_faults=[{{{when}, lasts_s = {lasts:.2f}, {fault}}}]"
    size, turn = float(rng.uniform(2.0, 20.0)), float(rng.uniform(-math.pi, math.pi))
    fault = f"jump = {sign * size:.2f}, jump_turn = {turn:.2f}"
    return at, size, f"sim.odometry_faults=[{{{when}, lasts_s = 0.5, {fault}}}]"


@dataclass(frozen=True, slots=True)
class BreakTask:
    """One drive: a pool Task whose result is what became of its break."""

    world: str
    seed: int
    kind: Kind
    number: int
    words: tuple[str, ...]

    @property
    def key(self) -> str:
        """All that decides the result."""
        files = world_digests(self.world)
        own = [Path(self.world).name, files, self.seed, self.kind, self.number, self.words]
        return json.dumps(["break", *own, versions(), source_digest()])

    def perform(self) -> BreakDrive:
        """Drive the taught route with the break and judge what the map became."""
        config = load_config(None, self.words)
        whole = open_world(self.world, self.seed, config)
        speed = config.sim.body.max_speed
        rng = np.random.default_rng(np.random.SeedSequence([self.seed, self.number]))
        at, size, word = math.inf, 0.0, ""
        if self.kind != "none":
            at, size, word = draw(self.kind, rng, whole.route_length_m / speed, speed)
            config = load_config(None, (*self.words, word))
        warm_up(config.stack)
        robot, navigator, watch = open_world(self.world, self.seed, config), build_navigator(config.stack), BreakWatch()
        first: int | None = None
        broke: int | None = None
        while (reading := robot.sense()) is not None and reading.driven:
            first = reading.stamp_ns if first is None else first
            if broke is None and (reading.stamp_ns - first) * 1e-9 >= at:
                broke = reading.stamp_ns
            record = navigator.step(reading)[1]
            true = robot.truth()
            watch.observe(reading, record, Pose2(true.x, true.y, true.heading))
            robot.act(Command())
        navigator.mapper.finish(max(watch.truths))
        words = (*self.words, word) if word else self.words
        return watch.judged(Path(self.world).stem, self.seed, self.kind, size, words, broke, navigator.mapper)


def plan(
    worlds: Sequence[str], seeds: Sequence[int], breaks: int, undisturbed: int, words: Sequence[str]
) -> list[BreakTask]:
    """Return so many drives with a break and without, over worlds, seeds and kinds in turn, each world checked first.

    Raises ConfigError, DataError.
    """
    if not worlds:
        raise DataError("name one world or more, as in room-corridor,hall")
    for world in worlds:
        open_world(world, 0, load_config(None, words))
    return list(itertools.islice(_turns(worlds, seeds, KINDS, tuple(words)), breaks)) + list(
        itertools.islice(_turns(worlds, seeds, ("none",), tuple(words)), undisturbed)
    )


def _turns(
    worlds: Sequence[str], seeds: Sequence[int], kinds: tuple[Kind, ...], words: tuple[str, ...]
) -> Iterator[BreakTask]:
    """Yield drives so that every world meets every kind: kinds go round, worlds go on by one more each round."""
    for number in itertools.count():
        world = worlds[(number % len(kinds) + number // len(kinds)) % len(worlds)]
        yield BreakTask(world, seeds[number // len(worlds) % len(seeds)], kinds[number % len(kinds)], number, words)


def run_breaks(
    tasks: Sequence[BreakTask], store: Store, count: int, progress: Callable[[int], None]
) -> list[BreakDrive]:
    """Return what became of all drives."""
    done = itertools.count(1)
    with workers(count, store) as hands:
        return hands.run(tasks, lambda: progress(next(done)))


def write(made: Sequence[BreakDrive], folder: Path) -> Path:
    """Write every drive with what was said in it. Raises DataError where that can't be done."""
    return write_made(made, folder / "breaks.json")
