"""Recordings of real robots, mapped and written as a run is: TUC recordings, and folders of panoramas."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from topomap.app.config import RunConfig, load_config
from topomap.app.export import write_tum
from topomap.app.folder import RunFolder
from topomap.app.logged_run import Progress
from topomap.app.runs import RunResult, conclude, execute
from topomap.app.wiring import versions
from topomap.bench.pool import Store, workers
from topomap.bench.recordings.figure import firmness
from topomap.bench.recordings.made_odometry import with_made_odometry
from topomap.bench.recordings.stability import RecordingRow, RecordingTask, Variation, to_csv, to_json
from topomap.core.run_data import TrueCalibration
from topomap.datasets.drive_folder import DriveFolder, FolderRobot, read_folder
from topomap.datasets.tuc.mapping import map_tuc as map_recording
from topomap.datasets.tuc.recording import read_tuc
from topomap.evaluation.summary import write_whole
from topomap.mapping.drive_engine import AlongSettings
from topomap.recording.encode import run_header
from topomap.report.figures.style import png


def map_tuc(path: Path, out: Path, building_axes: bool = False, force: bool = False) -> RunResult:
    """Map a folder in the TUC format; write trajectories, summary and report. Raises DataError.

    force: replace what an earlier run left in the folder.

    building_axes: assume that straight stretches run along two axes of the building; the result is named so.
    """
    recording = read_tuc(path)
    folder = RunFolder.create(out, force=force)
    data = map_recording(recording, AlongSettings(building_axes=building_axes), versions())
    with folder.owned():
        folder.clear()
        result = conclude(data, folder)
    return replace(result, files=(*write_tum(data, out), folder.summary, folder.report))


def _quiet(_: int) -> None:
    """Take the number of steps and do nothing."""


def map_folder(
    folder: Path | str,
    out: Path | str,
    *,
    config: Path | str | None = None,
    settings: Iterable[str] = (),
    force: bool = False,
    progress: Progress = _quiet,
) -> RunResult:
    """Map a drive from a folder with drive.csv, rig.json and panoramas; write log, map, summary and report.

    out: folder for them; config: TOML file with settings; settings: words as `stack.mapper.snapshots.threshold=0.6`;
    force: replace what an earlier run left there; progress: is told the steps done. The format is told by
    `topomap.datasets.drive_folder`. Raises DataError and ConfigError.
    """
    chosen = load_config(None if config is None else Path(config), settings)
    return map_drive(read_folder(Path(folder)), RunFolder.create(Path(out), force=force), chosen, progress)


def map_drive(
    drive: DriveFolder, folder: RunFolder, config: RunConfig, progress: Progress, made_odometry: int | None = None
) -> RunResult:
    """Map a drive that was read from a folder.

    made_odometry: seed of an odometry that is made from the true positions, an experiment; None: that of the drive.
    """
    known = TrueCalibration()
    if made_odometry is not None:
        drive, known = with_made_odometry(drive, made_odometry)
    robot = FolderRobot(drive)
    stored = {part: values for part, values in config.resolved().items() if part != "sim"}
    start = robot.truth()
    header = run_header(drive.name, drive.rig, made_odometry, stored, versions(), start, known)
    result = execute(robot, robot if start is not None else None, header, config, folder, progress)
    return replace(result, notes=(*drive.notes, *result.notes))


def bench(
    path: Path, variations: Sequence[Variation], jobs: int, progress: Callable[[int], None]
) -> list[RecordingRow]:
    """Map a recording in every given way, on so many processes. Raises DataError."""
    read_tuc(path)  # a broken file is told before any process starts
    done = itertools.count(1)
    with workers(jobs, Store(None)) as hands:
        return hands.run([RecordingTask(path, v) for v in variations], lambda: progress(next(done)))


def write_bench(rows: Sequence[RecordingRow], out: Path) -> tuple[Path, ...]:
    """Write recording.json, recording.csv and recording.png."""
    write_whole(out / "recording.json", to_json(rows))
    write_whole(out / "recording.csv", to_csv(rows))
    write_whole(out / "recording.png", png(firmness(rows)))
    return tuple(out / f"recording.{kind}" for kind in ("json", "csv", "png"))
