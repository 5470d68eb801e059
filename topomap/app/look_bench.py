"""The bench of looks put together: worlds driven as they are taught, each likeness judged, one curve and its table."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from topomap.app.config import RunConfig, load_config
from topomap.app.runs import open_world
from topomap.app.sweep import Variant, source_digest, world_digests
from topomap.app.wiring import versions
from topomap.bench.looks.fit import curves, said
from topomap.bench.looks.survey import Row, survey
from topomap.bench.pool import Store, workers
from topomap.core.errors import DataError
from topomap.core.geometry import Pose2
from topomap.core.records import Command
from topomap.core.robot import Reading
from topomap.evaluation.summary import plain, write_whole
from topomap.report.figures.calibration import calibration_curve
from topomap.report.figures.style import png
from topomap.vision.registry import aligner


@dataclass(frozen=True, slots=True)
class LookTask:
    """One drive: a pool Task whose result is its rows."""

    world: str
    seed: int
    config: RunConfig

    @property
    def key(self) -> str:
        """All that decides the result."""
        files = world_digests(self.world)
        name = Path(self.world).name
        return json.dumps(["looks", name, files, self.seed, self.config.resolved(), versions(), source_digest()])

    def perform(self) -> list[Row]:
        """Drive the taught route and return what looked alike."""
        return survey(self.world, self.seed, self._drive(), aligner(self.config.stack.mapper.aligner))

    def _drive(self) -> Iterator[tuple[Reading, Pose2]]:
        robot = open_world(self.world, self.seed, self.config)
        while (reading := robot.sense()) is not None and reading.driven:
            true = robot.truth()
            yield reading, Pose2(true.x, true.y, true.heading)
            robot.act(Command())


def plan(worlds: Sequence[str], seeds: Sequence[int], words: Sequence[str], which: Sequence[Variant]) -> list[LookTask]:
    """Return the drives, each checked before any is made. Raises ConfigError, DataError."""
    tasks = []
    for world, variant in itertools.product(worlds, which):
        chosen = load_config(None, (*words, *variant.words))
        open_world(world, 0, chosen)
        tasks += [LookTask(world, seed, chosen) for seed in seeds]
    return tasks


def run_looks(tasks: Sequence[LookTask], store: Store, count: int, progress: Callable[[int], None]) -> list[Row]:
    """Return the likenesses of all drives. Raises DataError where nothing looked alike."""
    done = itertools.count(1)
    with workers(count, store) as hands:
        drives = hands.run(tasks, lambda: progress(next(done)))
    rows = [row for drive in drives for row in drive]
    if not rows:
        raise DataError("looks: no place looked like an older one; longer drives or more laps would show some")
    return rows


def write_looks(rows: Sequence[Row], out: Path) -> tuple[Path, Path]:
    """Write looks.json and the calibration curve looks.png."""
    out.mkdir(parents=True, exist_ok=True)
    write_whole(out / "looks.json", json.dumps(plain(said(rows)), indent=2, allow_nan=False) + "\n")
    write_whole(out / "looks.png", png(calibration_curve(curves(rows))))
    return out / "looks.json", out / "looks.png"
