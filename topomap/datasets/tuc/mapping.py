"""A TUC recording through the closure engine, as a run."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.records import CalibrationState, Estimate
from topomap.core.run_data import NodeData, RunData
from topomap.datasets.tuc.drive import claims_of, drive_of
from topomap.datasets.tuc.recording import TucRecording
from topomap.mapping.drive_engine import AlongSettings, DriveMap, map_drive
from topomap.mapping.odometry.calibration import calibration_state
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.recorded_drive import RecordedDrive


def map_tuc(
    recording: TucRecording, settings: AlongSettings | None = None, versions: Mapping[str, str] | None = None
) -> RunData:
    """Map a recording and return it as a run at the odometry's stamps; the mapping never sees the truth."""
    chosen = settings or AlongSettings()
    drive = drive_of(recording)
    found = map_drive(drive, claims_of(recording, drive), chosen)
    at = np.searchsorted(drive.stamps_ns, recording.stamps_ns)
    _, final = drive.between_nodes(found.poses, found.calibration)
    accepted = [(c.match, c.query, "closure") for c in found.ledger.accepted if c.query is not None]
    odometry = zip(drive.edges.i.tolist(), drive.edges.j.tolist(), strict=True)
    return RunData(
        world=recording.name + (" (building axes assumed)" if chosen.building_axes else ""),
        seed=None,
        config=chosen.model_dump(mode="json"),
        versions=dict(versions or {}),
        stamps_ns=recording.stamps_ns,
        dead_reckoning=drive.dead_reckoning(Calibration())[at],
        online=found.online[at],
        final=final[at],
        truth=None if recording.truth is None else recording.truth.at(recording.stamps_ns),
        nodes=_nodes(drive, found.poses),
        edges=(*((i, j, "odometry") for i, j in odometry), *accepted),
        decisions=tuple(found.ledger.decisions),
        calibration=_calibration(found),
        graph_hash=_hash(found.poses, accepted),
        false_distance_m=2.0,
    )


def _calibration(found: DriveMap) -> CalibrationState:
    """Return what is known of the odometer; loops alone never show its distance scale."""
    state = calibration_state(found.calibration, found.calibration_covariance, found.prior_sigmas)
    return replace(state, distance_scale=Estimate(1.0, found.prior_sigmas[2], False))


def _nodes(drive: RecordedDrive, poses: FloatArray) -> tuple[NodeData, ...]:
    stamps = drive.node_stamps.tolist()
    return tuple(NodeData(k, stamps[k], poses[k], snapshot=False) for k in range(len(stamps)))


def _hash(poses: FloatArray, accepted: list[tuple[int, int, str]]) -> str:
    text = poses.tobytes() + repr(sorted(accepted)).encode()
    return hashlib.sha256(text).hexdigest()
