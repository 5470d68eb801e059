"""Runs from the first reading to the report: simulated or replayed, whole or interrupted."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from logs.errors import LogError
from logs.header import Header
from logs.recorder import Recorder
from logs.replay import ReplayRobot
from sim2d import worlds
from sim2d.errors import WorldError
from sim2d.robot import SimRobot
from topomap.app.config import RunConfig
from topomap.app.folder import RunFolder
from topomap.app.interrupt import stop_on_signal
from topomap.app.saved_map import MAP, SavedMap
from topomap.app.stored_config import parse_stored
from topomap.app.warm_up import warm_up
from topomap.app.wiring import build_navigator, versions
from topomap.core.errors import DataError
from topomap.core.records import Phase, StepRecord
from topomap.core.robot import Reading, Robot, TruthSource
from topomap.core.run_data import RunData, TrueCalibration
from topomap.evaluation.summary import summarise, write_summary, write_whole
from topomap.evaluation.trajectory import true_pose
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapfile import save_map
from topomap.mapping.sessions.condense import condense
from topomap.navigation.navigator import Navigator
from topomap.navigation.runner import run
from topomap.recording.encode import run_header
from topomap.recording.recorder import FinalMap, MapNow, RunRecorder
from topomap.recording.run_reader import load_run
from topomap.recording.true_nodes import ATTACHMENT, Truths, truth_file, truths_text
from topomap.report.report import write_report

Progress = Callable[[int], None]


@dataclass(frozen=True)
class RunResult:
    """A finished run: its folder, its summary, whether it was interrupted, the files it wrote, notes for people, and
    why its mission couldn't be, if it couldn't.
    """

    folder: RunFolder
    summary: dict[str, Any]
    interrupted: bool
    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()
    failure: str = ""


def open_world(name: str, seed: int, config: RunConfig) -> SimRobot:
    """Return the robot in a named world. Raises DataError for an unknown world."""
    try:
        return SimRobot(worlds.load(name), config.sim, seed)
    except WorldError as error:
        raise DataError(str(error)) from error


def run_world(
    robot: SimRobot,
    seed: int,
    config: RunConfig,
    folder: RunFolder,
    progress: Progress,
    saved: SavedMap | None = None,
) -> RunResult:
    """Drive, map, close loops and travel in a simulated world; write log, map, summary and report.

    saved: a map to go on with.
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
    return execute(robot, robot, header, config, folder, progress, saved)


def replay_log(stored: StoredRun, folder: RunFolder, progress: Progress) -> RunResult:
    """Take a log's readings through the stack again and write what a run writes; journeys are then not made anew."""
    robot = stored.robot
    header = replace(robot.header, replayed=True)
    result = execute(robot, robot, header, stored.config, folder, progress, stored.saved)
    return replace(result, notes=stored.notes)


def conclude(data: RunData, folder: RunFolder, interrupted: bool = False) -> RunResult:
    """Write summary and report of a run. Raises DataError where they can't be written."""
    summary = summarise(data)
    try:
        write_summary(folder.summary, summary)
        write_report(data, folder.report, summary)
    except OSError as error:
        raise DataError(f"{folder.path}: can't be written ({error.strerror})") from error
    files = (folder.log, folder.map, folder.summary, folder.report)
    return RunResult(folder, summary, interrupted, tuple(path for path in files if path.exists()))


class _Watch:
    """Hands each step to the recorder and to the progress bar."""

    def __init__(self, recorder: RunRecorder, progress: Progress) -> None:
        self.recorder, self._progress = recorder, progress
        self.steps = 0
        self.last: StepRecord | None = None

    def observe(self, reading: Reading, record: StepRecord) -> None:
        self.recorder.observe(reading, record)
        self.steps, self.last = self.steps + 1, record
        self._progress(self.steps)


def execute(
    robot: Robot,
    truth: TruthSource | None,
    header: Header,
    config: RunConfig,
    folder: RunFolder,
    progress: Progress,
    saved: SavedMap | None = None,
) -> RunResult:
    """Run with a log that is closed whatever happens, then write map, summary and report. Raises DataError.

    truth: goes into the log, where there is one; the stack never sees it; saved: a map to go on with.
    """
    warm_up(config.stack)
    attachments = tuple(saved.attachments()) if saved else ()
    navigator = build_navigator(config.stack, saved=saved)
    try:
        with Recorder.of(folder.log, header, config.log) as recorder, stop_on_signal() as stopped:
            for attachment in attachments:
                recorder.attach(*attachment)
            watch = _Watch(RunRecorder(recorder, lambda: map_now(navigator.mapper.map), truth), progress)
            began = time.perf_counter()
            run(robot, navigator, (watch,), stopped)
            _finish(navigator, watch, time.perf_counter() - began, folder)
            interrupted = stopped()
    except LogError as error:
        raise DataError(str(error)) from error
    data = load_run(folder.log)
    _write_truths(data, navigator.mapper.map, saved.truths if saved else {}, folder)
    return replace(conclude(data, folder, interrupted), failure=navigator.failure)


def _write_truths(data: RunData, topo: TopoMap, known: Truths, folder: RunFolder) -> None:
    """Write the true poses of the map's nodes beside it, where they are known: for metrics of later runs on it."""
    if data.truth is None:
        return
    own = dict(known)
    for node in data.nodes:
        pose = true_pose(data, node.stamp_ns)
        if np.isfinite(pose).all():
            x, y, heading = pose.tolist()
            own[topo.names[node.node]] = x, y, heading
    if own:
        write_whole(truth_file(folder.map), truths_text(own))


def _finish(navigator: Navigator, watch: _Watch, seconds: float, folder: RunFolder) -> None:
    """End the map and write it into the log and beside it."""
    if watch.last is None:
        return
    said = len(navigator.mapper.ledger.decisions)
    navigator.mapper.finish(watch.last.stamp_ns)
    unsaid = tuple(navigator.mapper.ledger.decisions[said:])
    watch.recorder.finish(replace(_final_map(navigator, watch.last, watch.steps / seconds), decisions=unsaid))
    topo = navigator.mapper.map
    if topo.view != "full":
        condense(topo)
    save_map(topo, folder.map)


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
    )


def map_now(topo: TopoMap) -> MapNow:
    """Return the map as it stands, for viewers."""
    return MapNow(tuple((i, topo.pose(i), n.snapshot is not None) for i, n in enumerate(topo.nodes)), _edges(topo))


def _edges(topo: TopoMap) -> tuple[tuple[int, int, str], ...]:
    return tuple((a, b, data["kind"]) for a, b, data in topo.graph.edges(data=True))


@dataclass(frozen=True)
class StoredRun:
    """A log as a robot, its configuration, and a line for each of its settings that is no more."""

    robot: ReplayRobot
    config: RunConfig
    notes: tuple[str, ...]
    saved: SavedMap | None = None


def open_log(path: Path, settings: Iterable[str] = ()) -> StoredRun:
    """Return a log that can be replayed, its stored configuration changed by `section.key=value` words.

    Raises DataError or ConfigError.
    """
    try:
        robot = ReplayRobot(path)
        stored = json.loads(robot.header.config)
        config, notes = parse_stored(stored, f"{path}: its stored configuration", settings)
        begun = robot.attachment(MAP)
        saved = SavedMap.of(begun, config.stack.mission, robot.attachment(ATTACHMENT)) if begun else None
    except LogError as error:
        raise DataError(str(error)) from error
    return StoredRun(robot, config, notes, saved)


def report_log(path: Path, out: Path) -> RunResult:
    """Write the summary and the report of a log into a folder. Raises DataError."""
    folder = RunFolder.create(out)
    return conclude(load_run(path), folder)


def same_hash(path: Path, summary: Mapping[str, Any]) -> bool | None:
    """Return whether a summary has the graph hash of a log's run; None where the log was cut off before it had one."""
    recorded = load_run(path).graph_hash
    return summary["graph_hash"] == recorded if recorded else None
