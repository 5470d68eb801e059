"""The bench of faults put together: each fault while the robot is taught and on its way home, in whole runs."""

from __future__ import annotations

import itertools
import json
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from topomap.app.config import load_config
from topomap.app.drive import drive
from topomap.app.faulty import FAULTS, Fault, FaultyRobot
from topomap.app.folder import RunFolder
from topomap.app.made_file import write_made
from topomap.app.runs import open_world
from topomap.app.sweep import source_digest, world_digests
from topomap.app.wiring import versions
from topomap.bench.pool import Store, workers
from topomap.core.errors import DataError, RobotFault, TopomapError

When = Literal["teaching", "way home"]
WHEN: tuple[When, ...] = get_args(When)
AFTER = 15, 50
"""Steps of its phase after which a fault comes, drawn between these: so far all is well."""
DEADLINE_S = 2.0


@dataclass(frozen=True, slots=True)
class FaultRun:
    """One run with one fault.

    ended: how, in the run's own words; stopped: the wheels were, once; way [m]: driven behind the fault; claimed:
    arrival; off [m]: how far from the goal it was claimed, None where it wasn't; whole: log, map, summary and report
    were written, and the log reads whole.
    """

    world: str
    seed: int
    fault: str
    when: str
    ended: str
    stopped: bool
    way: float
    claimed: bool
    off: float | None
    false: bool
    whole: bool

    @property
    def good(self) -> bool:
        """Whether nothing went wrong that the fault can't be blamed for."""
        return self.stopped and self.whole and not self.false


@dataclass(frozen=True, slots=True)
class FaultTask:
    """One run: a pool Task whose result is how it ended."""

    world: str
    seed: int
    fault: Fault
    when: When
    words: tuple[str, ...]

    @property
    def key(self) -> str:
        """All that decides the result."""
        files = world_digests(self.world)
        own = [Path(self.world).name, files, self.seed, self.fault, self.when, self.words]
        return json.dumps(["fault", *own, versions(), source_digest()])

    def perform(self) -> FaultRun:
        """Drive, fail, and look at what is left."""
        after = int(np.random.default_rng(self.seed).integers(*AFTER))
        robot = FaultyRobot(
            open_world(self.world, self.seed, load_config(None, self.words)), self.fault, self.when, after
        )
        ended = ""
        with tempfile.TemporaryDirectory() as place:
            folder = RunFolder(Path(place) / "run")
            try:
                drive(robot, folder.path, settings=self._stack, truth=robot, name="fault", deadline_s=DEADLINE_S)
            except RobotFault as fault:
                ended = str(fault)
            except TopomapError as error:
                ended = f"not written: {error}"
            whole = all(path.exists() for path in folder.files)
            summary = json.loads(folder.summary.read_bytes()) if folder.summary.exists() else {}
        home = summary.get("home") or {}
        claimed = bool(home.get("claimed"))
        return FaultRun(
            Path(self.world).stem, self.seed, self.fault, self.when, ended or ("arrived" if claimed else "not home"),
            robot.stops == 1, robot.way, claimed, home.get("error_m") if claimed else None,
            claimed and not home.get("within_0_3_m"), whole and summary.get("log", {}).get("state") == "whole",
        )  # fmt: skip

    @property
    def _stack(self) -> list[str]:
        return [word for word in self.words if not word.startswith("sim.")]


def plan(worlds: Sequence[str], seeds: Sequence[int], faults: str, words: Sequence[str]) -> list[FaultTask]:
    """Return every fault at both times in every world. Raises ConfigError, DataError."""
    asked = list(FAULTS) if faults == "all" else [word.strip() for word in faults.split(",")]
    unknown = [word for word in asked if word not in FAULTS]
    if unknown:
        raise DataError(f"--faults {unknown[0]}: there are all, {', '.join(FAULTS)}")
    for world in worlds:
        open_world(world, 0, load_config(None, words))
    chosen = [fault for fault in FAULTS if fault in asked]
    every = itertools.product(worlds, seeds, chosen, WHEN)
    return [FaultTask(world, seed, fault, when, tuple(words)) for world, seed, fault, when in every]


def run_faults(tasks: Sequence[FaultTask], store: Store, count: int, progress: Callable[[int], None]) -> list[FaultRun]:
    """Return how all runs ended."""
    done = itertools.count(1)
    with workers(count, store) as hands:
        return hands.run(tasks, lambda: progress(next(done)))


HEADINGS = ("fault", "when", "good", "stopped", "false", "written", "way [m]", "ended")

KEPT = ("world", "seed", *HEADINGS)


def kept_rows(made: Sequence[FaultRun]) -> list[tuple[str, ...]]:
    """Return one row a run under KEPT; the first four cells tell runs apart."""
    return [(one.world, f"{one.seed}", *row) for one, row in zip(made, rows(made)[:-1], strict=True)]


def rows(made: Sequence[FaultRun]) -> list[tuple[str, ...]]:
    """Return the table's rows under HEADINGS, and one for all together."""
    lines = [
        (one.fault, one.when, "yes" if one.good else "NO", "yes" if one.stopped else "NO",
         f"{one.off:.1f} m" if one.false and one.off is not None else "-", "yes" if one.whole else "NO",
         f"{one.way:.1f}", one.ended[:90])
        for one in made
    ]  # fmt: skip
    good, false = sum(one.good for one in made), sum(one.false for one in made)
    return [*lines, ("all", "", f"{good} of {len(made)}", "", f"{false}", "", "", "")]


def write(made: Sequence[FaultRun], folder: Path) -> Path:
    """Write every run. Raises DataError where that can't be done."""
    return write_made(made, folder / "faults.json")
