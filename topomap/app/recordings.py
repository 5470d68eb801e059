"""Recordings of real robots, mapped and written as a run is."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from topomap.app.export import write_tum
from topomap.app.folder import RunFolder
from topomap.app.runs import RunResult, conclude
from topomap.app.wiring import versions
from topomap.bench.pool import Store, workers
from topomap.bench.recordings.figure import firmness
from topomap.bench.recordings.stability import RecordingRow, RecordingTask, Variation, to_csv, to_json
from topomap.datasets.tuc.mapping import map_tuc as map_recording
from topomap.datasets.tuc.recording import read_tuc
from topomap.evaluation.summary import write_whole
from topomap.mapping.drive_engine import AlongSettings
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
