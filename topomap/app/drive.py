"""The face for Python: anybody's robot driven, anybody's log replayed, with all that a simulated run has."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from topomap.app.config import load_config
from topomap.app.folder import RunFolder
from topomap.app.interrupt import stop_on_signal
from topomap.app.logged_run import Progress
from topomap.app.runs import RunResult, execute, replay_log
from topomap.app.stored_run import open_log
from topomap.app.warm_up import warm_up
from topomap.app.wiring import versions
from topomap.core.errors import ConfigError, DataError, RobotFault
from topomap.core.records import Command
from topomap.core.robot import Reading, Robot, TruthSource
from topomap.navigation.watchdog import DEADLINE_S, GuardedRobot
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
    force: bool = False,
    deadline_s: float = DEADLINE_S,
) -> RunResult:
    """Drive a robot, map, close loops and go home; write run.mcap, run.topomap, summary.json and report.html.

    out: folder for them; config: TOML file with settings; settings: words as `stack.mission.then=stop`; truth: where
    the true pose is known, often the robot itself, for the metrics only; name: what log and report call the run;
    progress: is told the steps done; force: replace what an earlier run left in the folder; deadline_s: how long
    `sense`, `act` and a step of the stack may take before the wheels are stopped (math.inf: as long as they like).
    Ctrl-C and every other signal that would end the program end the drive and keep what was mapped; `robot.stop()` is
    called once, whatever happens. The robot's methods are called in one thread that isn't the caller's. Raises
    ConfigError before the robot is asked anything, DataError, and RobotFault, when log, map, summary and report are
    written, where the driver, a reading or the disk failed; its `result` is what was written.
    """
    chosen = load_config(None if config is None else Path(config), settings)
    if not deadline_s > 0:
        raise ConfigError(f"deadline_s = {deadline_s}: expected seconds, more than 0")
    folder = RunFolder.create(Path(out), force=force)
    ready = _Ready(robot, deadline_s)
    try:
        first = _first(ready)
        start = None if truth is None else truth.truth()
        stored = {part: values for part, values in chosen.resolved().items() if part != "sim"}
        header = run_header(name, first.rig, None, stored, versions(), start)
        return execute(ready, truth, header, chosen, folder, progress, meet=ready.meet)
    finally:
        ready.stop()


def replay(
    log: Path | str, out: Path | str | None = None, *, settings: Iterable[str] = (), progress: Progress = _quiet,
    force: bool = False,
) -> RunResult:  # fmt: skip
    """Take a log's readings through the stack again; with the same settings the summary's graph hash is the same.

    out: folder for what a run writes, `replay` beside the log where none is given; settings: words as
    `stack.mapper.snapshots.threshold=0.6`; force: replace what an earlier run left in the folder. Settings of an old
    log that are no more are told in the result's notes, what the log lacks in its doubt. Raises DataError, ConfigError,
    and RobotFault where the log's readings led to a fault.
    """
    path = Path(log)
    stored = open_log(path, settings)
    folder = RunFolder.create(path.parent / "replay" if out is None else Path(out), keep=path, force=force)
    return replay_log(stored, folder, progress)


def _first(ready: _Ready) -> Reading:
    """Return the first reading, once all is compiled. Raises DataError, and KeyboardInterrupt after a signal."""
    with stop_on_signal() as stopped:
        ready.meet(lambda _: None, stopped)
        warm_up()
        if stopped():
            raise KeyboardInterrupt
        return ready.look()


class _Ready:
    """A robot whose first reading is looked at before the run, as the log's header needs its rig; stops once."""

    def __init__(self, robot: Robot, deadline_s: float) -> None:
        self._robot = GuardedRobot(robot, deadline_s)
        self.meet = self._robot.meet
        self._first: Reading | None = None

    def look(self) -> Reading:
        """Return the first reading; `sense` hands it over again. Raises DataError where there is none."""
        try:
            self._first = self._robot.sense()
        except RobotFault:
            raise
        except Exception as error:  # a driver may raise anything
            raise RobotFault(f"the robot's first sense() failed: {type(error).__name__}: {error}") from error
        if self._first is None:
            raise DataError("the robot's first sense() returned None: there is nothing to drive")
        return self._first

    def sense(self) -> Reading | None:
        first, self._first = self._first, None
        return first if first is not None else self._robot.sense()

    def act(self, command: Command) -> None:
        self._robot.act(command)

    def stop(self) -> None:
        self._robot.stop()
