"""bench drive: a folder's drive through the whole stack, as `topomap map` drives it, without a log."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from topomap.app.config import RunConfig, StackConfig
from topomap.app.wiring import build_navigator
from topomap.bench.pool import Store, workers
from topomap.bench.recordings import drives
from topomap.bench.recordings.made_odometry import DEFAULT, scaled, thinned, with_made_odometry
from topomap.core.run_data import NodeData, RunData, TrueCalibration
from topomap.datasets.drive_folder import DriveFolder, FolderRobot, read_folder
from topomap.evaluation.summary import write_whole
from topomap.experiments.results import add_results

NOBODY = TrueCalibration()


@dataclass(frozen=True, slots=True)
class DriveTask:
    """Map a drive one way: a pool Task."""

    folder: Path
    variation: drives.DriveVariation
    stack: StackConfig

    @property
    def key(self) -> str:
        """All that decides the result but the drive itself."""
        return repr((str(self.folder), self.variation, self.stack))

    def perform(self) -> drives.DriveRow:
        """Make the odometry, map and judge."""
        v = self.variation
        drive = thinned(scaled(read_folder(self.folder), v.scale), v.every)
        drive, known = with_made_odometry(drive, v.draw, replace(DEFAULT, declared=v.declared))
        begin = time.perf_counter()
        run = map_readings(drive, self.stack, known)
        return drives.drive_row(v, run, time.perf_counter() - begin)


def map_readings(drive: DriveFolder, stack: StackConfig, known: TrueCalibration = NOBODY) -> RunData:
    """Take a drive through the stack; known: the odometer's true errors. Raises DataError."""
    navigator, robot = build_navigator(stack), FolderRobot(drive)
    mapper = navigator.mapper
    online, raw, stamps, truths = [], [], [], []
    while (reading := robot.sense()) is not None:
        _, record = navigator.step(reading)
        online.append(record.change.pose.array())
        raw.append(mapper.track.raw.array())
        stamps.append(reading.stamp_ns)
        truth = robot.truth()
        truths.append((np.nan,) * 3 if truth is None else (truth.x, truth.y, truth.heading))
    mapper.finish(stamps[-1])
    at, poses = mapper.map.trajectory()
    final = poses[np.searchsorted(at, np.array(stamps, np.int64))]
    nodes = tuple(
        NodeData(k, node.stamp_ns, mapper.map.pose(k).array(), node.snapshot is not None)
        for k, node in enumerate(mapper.map.nodes)
    )
    return RunData(
        world=drive.name, seed=None, config={}, versions={}, stamps_ns=np.array(stamps, np.int64),
        dead_reckoning=np.array(raw), online=np.array(online), final=final,
        truth=None if drive.table.truth is None else np.array(truths), nodes=nodes,
        decisions=tuple(mapper.ledger.decisions), calibration=mapper.optimisation.state, true_calibration=known,
        graph_hash=mapper.graph_hash(), trust=mapper.optimisation.trust, mount=mapper.mount,
    )  # fmt: skip


def bench_drive(
    path: Path,
    variations: Sequence[drives.DriveVariation],
    config: RunConfig,
    jobs: int,
    progress: Callable[[int], None],
    keep: Path | None = None,
) -> list[drives.DriveRow]:
    """Map a folder's drive in every given way with made odometry, on so many processes. Raises DataError.

    keep: file of figures that each row is added to as it comes.
    """
    with_made_odometry(read_folder(path), 0)  # a broken file is told before any process starts
    done = itertools.count(1)
    tasks = [DriveTask(path, v, config.stack) for v in variations]

    def take(row: drives.DriveRow) -> None:
        if keep is not None:
            add_results(keep, drives.KEPT, [drives.kept_row(path.resolve().name, row)], keys=drives.KEYS)

    with workers(jobs, Store(None)) as hands:
        return hands.run(tasks, lambda: progress(next(done)), take)


def write_drive_bench(rows: Sequence[drives.DriveRow], out: Path) -> tuple[Path, ...]:
    """Write drive.json and drive.csv."""
    write_whole(out / "drive.json", drives.to_json(rows))
    write_whole(out / "drive.csv", drives.to_csv(rows))
    return out / "drive.json", out / "drive.csv"
