"""Recordings of real robots, mapped and written as a run is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from topomap.app.export import write_tum
from topomap.app.folder import RunFolder
from topomap.app.runs import RunResult, conclude
from topomap.app.wiring import versions
from topomap.study.datasets.tuc import read_tuc
from topomap.study.tuc_map import map_tuc as map_recording
from topomap.study.tuc_settings import TucSettings


def map_tuc(path: Path, out: Path, building_axes: bool = False) -> RunResult:
    """Map a folder in the TUC format; write trajectories, summary and report. Raises DataError.

    building_axes: assume that straight stretches run along two axes of the building; the result is named so.
    """
    recording = read_tuc(path)
    folder = RunFolder.create(out)
    data = map_recording(recording, TucSettings(building_axes=building_axes), versions())
    result = conclude(data, folder)
    return replace(result, files=(*write_tum(data, out), folder.summary, folder.report))
