"""Many runs: worlds, seeds and variants of the settings on all cores, each in a folder of its own, and their table."""

from __future__ import annotations

import hashlib
import itertools
import json
import tomllib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import topomap
from sim2d.worlds import sources
from topomap.app import runs
from topomap.app.config import RunConfig, load_config, read_toml
from topomap.app.folder import RunFolder
from topomap.app.wiring import versions
from topomap.bench.pool import Store, digest_files, workers
from topomap.bench.sweeps.figure import swept
from topomap.bench.sweeps.matrix import matrix
from topomap.bench.sweeps.table import SweptRun, to_csv, to_json
from topomap.core.errors import ConfigError
from topomap.core.names import safe_name
from topomap.evaluation.summary import write_whole
from topomap.report.figures.style import png

AS_IT_IS = "default"


@dataclass(frozen=True, slots=True)
class Variant:
    """What sets some runs apart: a name and `section.key=value` words."""

    name: str
    words: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class RunTask:
    """One run of a sweep: a pool Task whose result is the run's summary."""

    world: str
    variant: str
    seed: int
    config: RunConfig
    folder: Path

    @property
    def key(self) -> str:
        """Return all that decides the run: world with every file it rests on, seed, settings, versions and code."""
        files = world_digests(self.world)
        return json.dumps(
            [
                Path(self.world).name,
                files,
                self.seed,
                self.config.resolved(),
                versions(),
                source_digest(),
                str(self.folder),
            ]
        )

    def perform(self) -> dict[str, Any]:
        """Drive, write the run's files, return its summary. Raises KeyboardInterrupt when it was stopped."""
        robot = runs.open_world(self.world, self.seed, self.config)
        result = runs.run_world(
            robot, self.seed, self.config, RunFolder.create(self.folder, force=True), lambda _: None
        )
        if result.interrupted:
            raise KeyboardInterrupt
        return result.summary


def variants(vary: Iterable[str], file: Path | None) -> list[Variant]:
    """Return every combination of `section.key=[value, ...]` words and of a TOML file's named tables of settings.

    Raises ConfigError.
    """
    axes = [[Variant(f"{key}={_short(v)}", (f"{key}={_toml(v)}",)) for v in vs] for key, vs in map(_axis, vary)]
    if file is not None:
        axes.append(_named(file))
    return [_joined(parts) for parts in itertools.product(*axes)]


def plan(
    worlds: Sequence[str], seeds: Sequence[int], config: Path | None, words: Sequence[str],
    which: Sequence[Variant], out: Path,
) -> list[RunTask]:  # fmt: skip
    """Return the runs of a sweep, each checked before any is made. Raises ConfigError, DataError."""
    tasks = []
    for world, variant in itertools.product(worlds, which):
        chosen = load_config(config, (*words, *variant.words))
        name = safe_name(runs.open_world(world, 0, chosen).world.name)
        folder = out / name / safe_name(variant.name)
        tasks += [RunTask(world, variant.name, seed, chosen, folder / f"seed-{seed}") for seed in seeds]
    return tasks


def run_sweep(
    tasks: Sequence[RunTask], jobs: int, fresh: bool, out: Path, progress: Callable[[int], None]
) -> list[SweptRun]:
    """Make the runs that aren't there yet and return all, in order; the number of processes changes nothing."""
    done = itertools.count(1)
    store = Store(None if fresh else out / ".done")
    for task in tasks:
        if not all(path.exists() for path in RunFolder(task.folder).files):
            store.forget(task.key)
    with workers(jobs, store) as hands:
        found = hands.run(tasks, lambda: progress(next(done)))
    return [SweptRun(s["world"], t.variant, t.seed, s) for t, s in zip(tasks, found, strict=True)]


def write_sweep(found: Sequence[SweptRun], out: Path) -> tuple[Path, ...]:
    """Write sweep.json, sweep.csv, sweep.png with every run, and matrix.png with variants against worlds."""
    write_whole(out / "sweep.json", to_json(found))
    write_whole(out / "sweep.csv", to_csv(found))
    write_whole(out / "sweep.png", png(swept(found)))
    write_whole(out / "matrix.png", png(matrix(found)))
    return tuple(out / name for name in ("sweep.json", "sweep.csv", "sweep.png", "matrix.png"))


def world_digests(world: str) -> list[str]:
    """Return a digest of each file that a world rests on."""
    return [hashlib.sha256(path.read_bytes()).hexdigest() for path in sources(world)]


@cache
def source_digest() -> str:
    """Return a digest of all code that decides a run."""
    return digest_files(
        Path(topomap.__file__).parents[1], ("topomap/**/*.py", "sim2d/**/*.py", "sim2d/**/*.toml", "logs/**/*.py")
    )


def _axis(word: str) -> tuple[str, list[Any]]:
    key, _, text = word.partition("=")
    try:
        values = tomllib.loads(f"values = {text}")["values"]
    except (ValueError, RecursionError):  # no TOML
        values = None
    if not key or not isinstance(values, list) or not values:
        raise ConfigError(f"--vary {word}: expected section.key=[value, ...], as in sim.driver.lateral_offset=[0, 0.3]")
    return key.strip(), values


def _named(file: Path) -> list[Variant]:
    tables = read_toml(file)
    for name, table in tables.items():
        if not isinstance(table, dict):
            raise ConfigError(f"{file}: {name} = {table!r}: expected a table of settings, as in [{name}]")
    if not tables:
        raise ConfigError(f"{file}: holds no variants: expected tables of settings, as in [calm]")
    return [Variant(name, tuple(_words(table))) for name, table in tables.items()]


def _words(table: dict[str, Any], path: str = "") -> Iterable[str]:
    """Yield the settings of nested tables as `section.key=value`."""
    for name, value in table.items():
        if isinstance(value, dict):
            yield from _words(value, f"{path}{name}.")
        else:
            yield f"{path}{name}={_toml(value)}"


def _joined(parts: Sequence[Variant]) -> Variant:
    return Variant(", ".join(p.name for p in parts) or AS_IT_IS, tuple(word for p in parts for word in p.words))


def _short(value: Any) -> str:
    return value if isinstance(value, str) else _toml(value)


def _toml(value: Any) -> str:
    """Return a value as TOML has it on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return json.dumps(value)  # strings, numbers and booleans are written as in JSON
