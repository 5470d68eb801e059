"""The face for Python: anybody's robot driven, anybody's log replayed, with all that a simulated run has."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from topomap.app.config import load_config
from topomap.app.folder import RunFolder
from topomap.app.runs import Progress, RunResult, execute, open_log, replay_log
from topomap.app.warm_up import warm_up
from topomap.app.wiring import versions
from topomap.core.errors import DataError
from topomap.core.records import Command
from topomap.core.robot import Reading, Robot, TruthSource
from topomap.recording.encode import run_header


def _quiet(_: int) -> None:
    """Take the number of steps and do nothing."""


def drive(
    robot: Robot,
    out: Path | str,
    *,
    config: Path | str | None = None,
    settings: Iterable[str] = (),
    truth: TruthSource | None = None,
    name: str = "own robot",
    progress: Progress = _quiet,
) -> RunResult:
    """Drive a robot, map, close loops and go home; write run.mcap, run.topomap, summary.json and report.html.

    out: folder for them; config: TOML file with settings; settings: words as `stack.mission.then=stop`; truth: where
    the true pose is known, often the robot itself, for the metrics only; name: what log and report call the run;
    progress: is told the steps done. Ctrl-C ends the drive and keeps what was mapped; `robot.stop()` is called
    whatever happens. Raises ConfigError before the robot is asked anything, and DataError.
    """
    chosen = load_config(None if config is None else Path(config), settings)
    folder = RunFolder.create(Path(out))
    ready = _Ready(robot)
    try:
        warm_up()
        first = ready.look()
        start = None if truth is None else truth.truth()
        stored = {part: values for part, values in chosen.resolved().items() if part != "sim"}
        header = run_header(name, first.rig, None, stored, versions(), start)
        return execute(ready, truth, header, chosen, folder, progress)
    finally:
        ready.stop()


def replay(
    log: Path | str, out: Path | str | None = None, *, settings: Iterable[str] = (), progress: Progress = _quiet
) -> RunResult:
    """Take a log's readings through the stack again; with the same settings the summary's graph hash is the same.

    out: folder for what a run writes, `replay` beside the log where none is given; settings: words as
    `stack.mapper.snapshots.threshold=0.6`. Settings of an old log that are no more are told in the result's notes.
    Raises DataError, ConfigError.
    """
    path = Path(log)
    stored = open_log(path, settings)
    folder = RunFolder.create(path.parent / "replay" if out is None else Path(out), keep=path)
    return replay_log(stored, folder, progress)


class _Ready:
    """A robot whose first reading is looked at before the run, as the log's header needs its rig; stops once."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._first: Reading | None = None
        self._stopped = False

    def look(self) -> Reading:
        """Return the first reading; `sense` hands it over again. Raises DataError where there is none."""
        self._first = self._robot.sense()
        if self._first is None:
            raise DataError("the robot's first sense() returned None: there is nothing to drive")
        return self._first

    def sense(self) -> Reading | None:
        first, self._first = self._first, None
        return first if first is not None else self._robot.sense()

    def act(self, command: Command) -> None:
        self._robot.act(command)

    def stop(self) -> None:
        if not self._stopped:
            self._stopped = True
            self._robot.stop()
