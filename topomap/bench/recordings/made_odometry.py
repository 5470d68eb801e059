"""Odometry made from a drive's true positions, with drift and noise by a seed: for experiments, never in the stack.

Recordings of real cameras often tell where the camera was and not what wheels would have read. Made odometry reads the
true increments as the simulator's odometer reads them (`topomap.core.records`: what the systematic errors do), by
default with its drift and noise, and declares the noise that was added, or a multiple of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.errors import DataError
from topomap.core.geometry import Pose2
from topomap.core.run_data import TrueCalibration
from topomap.datasets.drive_folder import DriveFolder
from topomap.datasets.drive_folder.table import POSED, driven_covariances, increments
from topomap.mapping.odometry.increments import Calibration, Increments, track

FLOOR = np.diag([1e-4, 1e-4, 1e-5]) ** 2  # a standstill has no error, and stays invertible


@dataclass(frozen=True, slots=True)
class MadeErrors:
    """What the made odometer gets wrong: systematic errors, each times uniform(1 - spread, 1 + spread), and noise.

    forward_noise [m per square-root m], turn_noise [rad per square-root m]; declared: what the covariances say, as a
    multiple of the true ones.
    """

    rotation_scale: float = 1.04
    distance_scale: float = 0.95
    curvature: float = 0.003
    spread: float = 0.2
    forward_noise: float = 0.02
    turn_noise: float = math.radians(0.5)
    declared: float = 1.0


DEFAULT = MadeErrors()


def scaled(drive: DriveFolder, factor: float) -> DriveFolder:
    """Return a drive in a world that is so many times larger: positions and the camera's height."""
    table, rig = drive.table, drive.rig
    deltas, truth = table.deltas.copy(), _truth(drive).copy()
    deltas[:, :2] *= factor
    truth[:, :2] *= factor
    rig = replace(rig, camera_height=rig.camera_height * factor)
    return replace(drive, rig=rig, table=replace(table, deltas=deltas, truth=truth))


def thinned(drive: DriveFolder, every: int) -> DriveFolder:
    """Return every so many-th reading of a drive. The odometry is that of the true poses."""
    table = drive.table
    truth = _truth(drive)[::every]
    deltas = increments(truth)
    return replace(
        drive,
        table=replace(
            table, stamps_ns=table.stamps_ns[::every], images=table.images[::every], truth=truth, deltas=deltas,
            covariances=np.tile(FLOOR, (len(truth), 1, 1)),
        ),
    )  # fmt: skip


def with_made_odometry(
    drive: DriveFolder, seed: int, errors: MadeErrors = DEFAULT
) -> tuple[DriveFolder, TrueCalibration]:
    """Return a drive whose odometry is made from its true poses, and the systematic errors that were drawn.

    Raises DataError where the drive's truth has no positions or no headings.
    """
    truth = _truth(drive)
    true = increments(truth)
    drift, noise = np.random.default_rng(np.random.SeedSequence([seed, 1])), np.random.SeedSequence([seed, 2])
    factor = drift.uniform(1 - errors.spread, 1 + errors.spread, 3).tolist()
    known = TrueCalibration(
        1 + (errors.rotation_scale - 1) * factor[0],
        1 + (errors.distance_scale - 1) * factor[1],
        errors.curvature * factor[2],
    )
    covariances = driven_covariances(true, errors.forward_noise, errors.turn_noise)
    draws = np.random.default_rng(noise).standard_normal((len(true), 3))
    read = _read(true, known) + draws * np.sqrt(np.diagonal(covariances, axis1=1, axis2=2)) * [1.0, 0.0, 1.0]
    read[0] = 0.0
    table = replace(
        drive.table, deltas=read, truth=truth, covariances=errors.declared * covariances,
        odometry=f"made from the true positions, seed {seed}",
    )  # fmt: skip
    return replace(drive, table=table, notes=(f"odometry: {table.odometry}", *drive.notes[1:])), known


def _read(true: FloatArray, known: TrueCalibration) -> FloatArray:
    """Return what an odometer with systematic errors reads of true increments (N, 3)."""
    assert known.rotation_scale is not None
    assert known.distance_scale is not None
    assert known.curvature is not None
    forward, left, turn = true.T
    turned = known.rotation_scale * turn + known.curvature * forward
    return np.column_stack([known.distance_scale * forward, known.distance_scale * left, turned])


def _truth(drive: DriveFolder) -> FloatArray:
    """Return the true poses (N, 3): told as such, or the poses that would be taken for the odometer's own."""
    table = drive.table
    if table.truth is not None:
        if not bool(np.isfinite(table.truth).all()):
            raise DataError(f"{drive.name}: no odometry can be made: heading_rad is missing")
        return table.truth
    if table.odometry != POSED:
        raise DataError(f"{drive.name}: no odometry can be made: x_m, y_m and heading_rad are missing")
    return track(Increments(table.stamps_ns[1:], table.deltas[1:], table.covariances[1:]), Calibration(), Pose2())
