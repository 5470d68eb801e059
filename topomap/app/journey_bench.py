"""The bench of journeys put together: worlds, seeds, textures and disturbances, and the file it writes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import get_args

from topomap.app.config import RunConfig, load_config
from topomap.app.disturbed import Disturbance, Kind
from topomap.app.journeys import journeys, teach
from topomap.app.words import parse_seeds
from topomap.bench.journeys import Journey, tally
from topomap.core.errors import DataError
from topomap.evaluation.summary import write_whole


@dataclass(frozen=True, slots=True)
class JourneyRequest:
    """What to travel: worlds, seeds, textures, disturbances (each `count` times from every lesson), the goal node."""

    worlds: tuple[str, ...]
    seeds: tuple[int, ...]
    textures: tuple[int, ...]
    kinds: tuple[Kind, ...]
    count: int
    goal: int
    config: RunConfig

    @property
    def steps(self) -> int:
        """How many journeys there will be."""
        return len(self.worlds) * len(self.seeds) * len(self.textures) * len(self.kinds) * self.count


def request(
    worlds: str, seeds: str, textures: str, kinds: str, count: int, goal: int, settings: Iterable[str]
) -> JourneyRequest:
    """Return the request of a command line's words. Raises DataError, ConfigError."""
    known: tuple[Kind, ...] = get_args(Kind)
    asked = list(known) if kinds == "all" else [word.strip() for word in kinds.split(",")]
    unknown = [word for word in asked if word not in known]
    if unknown:
        raise DataError(f"--kinds {unknown[0]}: there are all, {', '.join(known)}")
    chosen = tuple(kind for kind in known if kind in asked)
    names = tuple(word.strip() for word in worlds.split(",") if word.strip())
    if not names:
        raise DataError("--worlds: name one or more, as in room-corridor,hall")
    config = load_config(None, settings)
    return JourneyRequest(
        names, tuple(parse_seeds(seeds)), tuple(parse_seeds(textures)), chosen, count, goal, config
    )  # fmt: skip


def travel_all(asked: JourneyRequest, advance: Callable[[int], None]) -> list[Journey]:
    """Teach each world once for each seed and textures, and make all its journeys; advance: is told how many are made.

    Raises DataError.
    """
    made: list[Journey] = []
    wanted = [Disturbance(kind) for kind in asked.kinds for _ in range(asked.count)]
    for world in asked.worlds:
        for seed in asked.seeds:
            for looks in asked.textures:
                for one in journeys(teach(world, seed, looks, asked.config), asked.goal, wanted):
                    made.append(one)
                    advance(len(made))
    return made


HEADINGS = ("world", "disturbance", "journeys", "home", "95 %", "false", "collisions", "ratio", "m/s", "standing")


def rows(made: Sequence[Journey]) -> list[tuple[str, ...]]:
    """Return the table's rows, one for each world and disturbance."""
    groups = dict.fromkeys((one.world, one.kind) for one in made)
    return [
        _row(world, kind, [one for one in made if (one.world, one.kind) == (world, kind)]) for world, kind in groups
    ]


def _row(world: str, kind: str, made: list[Journey]) -> tuple[str, ...]:
    t = tally(made)
    return (
        world, kind, f"{t.journeys}", f"{t.home.value:.2f}", f"{t.home.low:.2f}-{t.home.high:.2f}", f"{t.false}",
        f"{t.collisions}", f"{t.ratio:.2f}", f"{t.speed:.2f}", f"{t.standing:.2f}",
    )  # fmt: skip


def write(made: Sequence[Journey], folder: Path) -> Path:
    """Write every journey with its notes. Raises DataError where that can't be done."""
    path = folder / "journeys.json"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(path, json.dumps([asdict(one) for one in made], indent=1) + "\n")
    except OSError as error:
        raise DataError(f"{folder}: can't be written ({error.strerror})") from error
    return path
