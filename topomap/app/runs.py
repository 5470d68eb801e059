"""Runs from the first reading to the report: simulated or replayed, whole or interrupted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from logs.header import Header
from sim2d import worlds
from sim2d.errors import WorldError
from sim2d.robot import SimRobot
from topomap.app.config import RunConfig
from topomap.app.folder import RunFolder
from topomap.app.interrupt import Stop, stop_on_signal
from topomap.app.logged_run import Meet, Progress, run_logged
from topomap.app.mission_steps import expected_steps
from topomap.app.saved_map import SavedMap, write_truths
from topomap.app.stored_run import StoredRun
from topomap.app.warm_up import warm_up
from topomap.app.wiring import build_navigator, versions
from topomap.core.errors import DataError, RobotFault
from topomap.core.robot import Robot, TruthSource
from topomap.core.run_data import RunData, TrueCalibration
from topomap.evaluation.summary import summarise, write_summary
from topomap.recording.encode import run_header
from topomap.recording.run_reader import read_run
from topomap.report.report import write_report

STEPS_SPARE, STEPS_RATIO = 5000, 20
"""A simulated run may take so many steps, and so many times those of its route or of the ways to its goals: going home
takes less than once."""


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
    most = STEPS_SPARE + STEPS_RATIO * expected_steps(robot, config.stack.mission, saved)
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
        fault = run_logged(robot, truth, header, config, folder, progress, most_steps, meet, navigator, stopped, begun)
        result = _concluded(folder, stopped, fault)
        write_truths(read_run(folder.log), navigator.mapper.map, saved, folder.map)
        return replace(result, failure=navigator.failure)


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


def report_log(path: Path, out: Path, force: bool = False) -> RunResult:
    """Write the summary and the report of a log into a folder. Raises DataError."""
    run = read_run(path)
    folder = RunFolder.beside(out, path, force)
    with folder.owned():
        return conclude(run, folder)
