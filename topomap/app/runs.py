"""Runs from the first reading to the report: simulated or replayed, whole or interrupted."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from logs.errors import LogError
from logs.header import Header
from logs.recorder import Recorder
from sim2d import worlds
from sim2d.errors import WorldError
from sim2d.robot import SimRobot
from topomap.app.config import RunConfig
from topomap.app.folder import RunFolder
from topomap.app.interrupt import Stop, stop_on_signal
from topomap.app.saved_map import SavedMap, write_truths
from topomap.app.stored_run import StoredRun
from topomap.app.warm_up import warm_up
from topomap.app.wiring import build_navigator, versions
from topomap.core.errors import DataError, RobotFault
from topomap.core.records import Phase, StepRecord
from topomap.core.robot import Reading, Robot, TruthSource
from topomap.core.run_data import RunData, TrueCalibration
from topomap.evaluation.summary import summarise, write_summary
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapfile import save_map
from topomap.mapping.sessions.condense import condense
from topomap.navigation.navigator import Navigator
from topomap.navigation.runner import run
from topomap.recording.encode import run_header
from topomap.recording.recorder import FinalMap, MapNow, RunRecorder
from topomap.recording.run_reader import read_run
from topomap.report.report import write_report

Progress = Callable[[int], None]
Meet = Callable[[Callable[[str], None], Callable[[], bool]], None]
STEPS_SPARE, STEPS_RATIO = 5000, 20
"""A simulated run may take so many steps, and so many times those of its route: going home takes less than once."""


@dataclass(frozen=True)
class RunResult:
    """A finished run: its folder, its summary, whether it was interrupted, the files it wrote, and notes for people.

    signal: the one that interrupted it; fault: what ended it before its time; doubt: what its log lacks; failure: why
    its mission couldn't be.
    """

    folder: RunFolder
    summary: dict[str, Any]
    interrupted: bool
    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()
    signal: int | None = None
    fault: str = ""
    doubt: str = ""
    failure: str = ""


def open_world(name: str, seed: int, config: RunConfig) -> SimRobot:
    """Return the robot in a named world. Raises DataError for an unknown world."""
    try:
        return SimRobot(worlds.load(name, config.sim.textures), config.sim, seed)
    except WorldError as error:
        raise DataError(str(error)) from error


def run_world(
    robot: SimRobot, seed: int, config: RunConfig, folder: RunFolder, progress: Progress, saved: SavedMap | None = None
) -> RunResult:
    """Drive, map, close loops and travel in a simulated world; write log, map, summary and report.

    saved: a map to go on with. Raises RobotFault, when all is written, where the drive failed.
    """
    known = robot.true_calibration
    header = run_header(
        robot.world.name,
        robot.rig,
        seed,
        config.resolved(),
        versions(),
        robot.truth(),
        TrueCalibration(known.rotation_scale, known.distance_scale, known.curvature),
        robot.world.plan(),
    )
    most = STEPS_SPARE + STEPS_RATIO * robot.expected_steps
    return execute(robot, robot, header, config, folder, progress, most, saved=saved)


def replay_log(stored: StoredRun, folder: RunFolder, progress: Progress) -> RunResult:
    """Take a log's readings through the stack again and write what a run writes; journeys are then not made anew."""
    robot = stored.robot
    doubt = "" if robot.state.whole else f"{robot.state.word}: {robot.state.note}"
    try:
        header = replace(robot.header, replayed=True)
        result = execute(robot, robot, header, stored.config, folder, progress, saved=stored.saved)
    finally:
        robot.close()
    return replace(result, notes=stored.notes, doubt=doubt)


def conclude(data: RunData, folder: RunFolder) -> RunResult:
    """Write summary and report of a run. Raises DataError where they can't be written."""
    summary = summarise(data)
    try:
        write_summary(folder.summary, summary)
        write_report(data, folder.report, summary)
    except OSError as error:
        raise DataError(f"{folder.path}: can't be written ({error.strerror})") from error
    doubt = "" if data.log_state == "whole" else f"{data.log_state}: {data.log_note}"
    written = tuple(path for path in folder.files if path.exists())
    return RunResult(folder, summary, False, written, fault=data.fault, doubt=doubt)


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


def execute(
    robot: Robot, truth: TruthSource | None, header: Header, config: RunConfig, folder: RunFolder, progress: Progress,
    most_steps: int | None = None, meet: Meet | None = None, saved: SavedMap | None = None,
) -> RunResult:  # fmt: skip
    """Run with a log that is closed whatever happens, then write map, summary and report.

    truth: goes into the log, where there is one; the stack never sees it; meet: is given what writes a warning into the
    log, and what says that the run shall end; saved: a map to go on with. Raises DataError, and RobotFault where the
    run failed, when all is written that can be.
    """
    with folder.owned(), stop_on_signal() as stopped:
        folder.clear()
        warm_up(config.stack)
        begun = tuple(saved.attachments()) if saved else ()
        navigator = build_navigator(config.stack, saved=saved)
        fault = _logged(robot, truth, header, config, folder, progress, most_steps, meet, navigator, stopped, begun)
        result = _concluded(folder, stopped, fault)
        write_truths(read_run(folder.log), navigator.mapper.map, saved, folder.map)
        return replace(result, failure=navigator.failure)


def _logged(
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


def _concluded(folder: RunFolder, stopped: Stop, fault: str) -> RunResult:
    """Write summary and report; raise RobotFault where the run ended before its time."""
    try:
        result = replace(conclude(read_run(folder.log), folder), interrupted=stopped(), signal=stopped.number)
    except DataError as error:
        if fault:
            raise RobotFault(fault) from error
        raise
    if fault:
        raise RobotFault(fault, replace(result, fault=fault))
    return result


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
    final = _final_map(navigator, watch.last, watch.steps / seconds)
    if navigator.mapper.map.view != "full":
        condense(navigator.mapper.map)
    save_map(navigator.mapper.map, folder.map)
    watch.recorder.finish(replace(final, decisions=unsaid, fault=fault))


def _final_map(navigator: Navigator, last: StepRecord, steps_per_s: float) -> FinalMap:
    mapper = navigator.mapper
    topo = mapper.map
    stamps, poses = topo.trajectory(mapper.first)
    travel = last.travel.phase
    asked = last.goal.phase is Phase.TRAVEL
    return FinalMap(
        stamps,
        poses,
        tuple((i, n.stamp_ns, topo.pose(i), n.snapshot is not None) for i, n in enumerate(topo.nodes)),
        _edges(topo),
        mapper.optimisation.state,
        mapper.graph_hash(),
        steps_per_s,
        travel is Phase.ARRIVED if asked else None,
        last.goal.node,
        trust=mapper.optimisation.trust,
        mount=mapper.mount,
        topology_hash=mapper.topology_hash(),
    )


def map_now(topo: TopoMap) -> MapNow:
    """Return the map as it stands, for viewers."""
    return MapNow(tuple((i, topo.pose(i), n.snapshot is not None) for i, n in enumerate(topo.nodes)), _edges(topo))


def _edges(topo: TopoMap) -> tuple[tuple[int, int, str], ...]:
    return tuple((a, b, data["kind"]) for a, b, data in topo.graph.edges(data=True))


def report_log(path: Path, out: Path, force: bool = False) -> RunResult:
    """Write the summary and the report of a log into a folder. Raises DataError."""
    run = read_run(path)
    folder = RunFolder.beside(out, path, force)
    with folder.owned():
        return conclude(run, folder)
