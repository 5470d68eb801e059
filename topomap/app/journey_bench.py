"""The bench of journeys put together: each world is taught once and travelled many times, and one file says it all."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from topomap.app.config import load_config
from topomap.app.disturbed import KINDS, Disturbance, Kind
from topomap.app.journeys import journeys, teach
from topomap.app.made_file import write_made
from topomap.app.runs import open_world
from topomap.app.sweep import source_digest, world_digests
from topomap.app.wiring import versions
from topomap.bench.journeys import Journey
from topomap.bench.pool import Store, workers
from topomap.core.errors import DataError


@dataclass(frozen=True, slots=True)
class LessonTask:
    """One lesson with all its journeys, `count` of each kind: a pool Task whose result is what became of them.

    goal: None draws one for each journey.
    """

    world: str
    seed: int
    textures: int
    kinds: tuple[Kind, ...]
    count: int
    goal: int | None
    words: tuple[str, ...]

    @property
    def key(self) -> str:
        """All that decides the result."""
        files = world_digests(self.world)
        own = [Path(self.world).name, files, self.seed, self.textures, self.kinds, self.count, self.goal, self.words]
        return json.dumps(["journeys", *own, versions(), source_digest()])

    @property
    def travels(self) -> int:
        """How many journeys these are."""
        return len(self.kinds) * self.count

    def perform(self) -> tuple[Journey, ...]:
        """Teach the world once and make all its journeys. Raises DataError."""
        wanted = [Disturbance(kind) for kind in self.kinds for _ in range(self.count)]
        return tuple(journeys(teach(self.world, self.seed, self.textures, self.words), self.goal, wanted))


def plan(
    worlds: str, seeds: Sequence[int], textures: Sequence[int], kinds: str, count: int, goal: str, words: Sequence[str]
) -> list[LessonTask]:
    """Return the lessons of a command line's words, each world checked first; goal: a node's number, or "any".

    Raises DataError, ConfigError.
    """
    if not goal.isdecimal() and goal != "any":
        raise DataError(f"--goal {goal}: expected the number of a node, or any")
    asked = list(KINDS) if kinds == "all" else [word.strip() for word in kinds.split(",")]
    unknown = [word for word in asked if word not in KINDS]
    if unknown:
        raise DataError(f"--kinds {unknown[0]}: there are all, {', '.join(KINDS)}")
    names = [word.strip() for word in worlds.split(",") if word.strip()]
    if not names:
        raise DataError("--worlds: name one or more, as in room-corridor,hall")
    for name in names:
        open_world(name, 0, load_config(None, words))
    chosen = tuple(kind for kind in KINDS if kind in asked)
    every = itertools.product(names, seeds, textures)
    return [LessonTask(*one, chosen, count, None if goal == "any" else int(goal), tuple(words)) for one in every]


def run_journeys(
    tasks: Sequence[LessonTask], store: Store, count: int, progress: Callable[[int], None]
) -> list[Journey]:
    """Return what became of all journeys; progress: is told how many are made."""
    done = itertools.count(1)
    each = tasks[0].travels if tasks else 0
    with workers(count, store) as hands:
        lessons = hands.run(tasks, lambda: progress(each * next(done)))
    return [one for lesson in lessons for one in lesson]


def write(made: Sequence[Journey], folder: Path) -> Path:
    """Write every journey with its notes. Raises DataError where that can't be done."""
    return write_made(made, folder / "journeys.json")
