"""A run with an open log, which is closed and holds the finished map whatever happens."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace

from logs.errors import LogError
from logs.header import Header
from logs.recorder import Recorder
from topomap.app.config import RunConfig
from topomap.app.final_map import final_map, map_now
from topomap.app.folder import RunFolder
from topomap.app.interrupt import Stop
from topomap.core.errors import DataError, RobotFault
from topomap.core.records import StepRecord
from topomap.core.robot import Reading, Robot, TruthSource
from topomap.mapping.mapfile import save_map
from topomap.mapping.sessions.condense import condense
from topomap.navigation.navigator import Navigator
from topomap.navigation.runner import run
from topomap.recording.recorder import RunRecorder

Progress = Callable[[int], None]
Meet = Callable[[Callable[[str], None], Callable[[], bool]], None]


class _Watch:
    """Hands each step to the recorder and to the progress bar."""

    def __init__(self, recorder: RunRecorder, progress: Progress) -> None:
        self.recorder, self._progress = recorder, progress
        self.steps = 0
        self.last: StepRecord | None = None

    def sensed(self, reading: Reading) -> None:
        try:
            self.recorder.sensed(reading)
        except LogError:
            raise
        except Exception as error:  # whatever a driver hands over that no record can hold
            raise RobotFault(f"a reading can't be logged: {type(error).__name__}: {error}") from error

    def observe(self, reading: Reading, record: StepRecord) -> None:
        self.recorder.observe(reading, record)
        self.steps, self.last = self.steps + 1, record
        self._progress(self.steps)

    def say(self, message: str) -> None:
        """Write a warning into the log."""
        self.recorder.say("robot", message)


def run_logged(
    robot: Robot, truth: TruthSource | None, header: Header, config: RunConfig, folder: RunFolder, progress: Progress,
    most_steps: int | None, meet: Meet | None, navigator: Navigator, stopped: Stop,
    begun: tuple[tuple[str, str, bytes], ...],
) -> str:  # fmt: skip
    """Run with an open log, end the map; return what ended the run before its time, nothing where nothing did."""
    faults: list[str] = []
    try:
        with Recorder.of(folder.log, header, config.log) as recorder:
            for attachment in begun:
                recorder.attach(*attachment)
            watch = _Watch(RunRecorder(recorder, lambda: map_now(navigator.mapper.map), truth), progress)
            began = time.perf_counter()
            if meet is not None:
                meet(watch.say, stopped)
            with _noted(faults):
                run(robot, navigator, (watch,), stopped, most_steps, watch.sensed)
            with _noted(faults):
                _finish(navigator, watch, time.perf_counter() - began, folder, "; ".join(faults))
    except LogError as error:  # the log can't be closed, mostly for the reason for which the run ended
        if str(error) not in faults:
            faults.append(str(error))
    return "; ".join(faults)


@contextmanager
def _noted(faults: list[str]) -> Iterator[None]:
    """Take down what is expected to go wrong instead of raising it, so that what was done is kept."""
    try:
        yield
    except (RobotFault, LogError, DataError) as error:
        if str(error) not in faults:
            faults.append(str(error))


def _finish(navigator: Navigator, watch: _Watch, seconds: float, folder: RunFolder, fault: str) -> None:
    """End the map and write it beside the log and into it."""
    if fault:
        with suppress(LogError):  # the log itself may be what failed
            watch.recorder.say("fault", fault, error=True)
    if watch.last is None:
        return
    said = len(navigator.mapper.ledger.decisions)
    navigator.mapper.finish(watch.last.stamp_ns)
    unsaid = tuple(navigator.mapper.ledger.decisions[said:])
    final = final_map(navigator, watch.last, watch.steps / seconds)
    if navigator.mapper.map.view != "full":
        condense(navigator.mapper.map)
    save_map(navigator.mapper.map, folder.map)
    watch.recorder.finish(replace(final, decisions=unsaid, fault=fault))
