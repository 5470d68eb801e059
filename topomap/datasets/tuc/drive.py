"""A TUC recording as the stack maps it: a drive with a node at each stamp that a candidate names, and its claims."""

from __future__ import annotations

import numpy as np

from topomap.datasets.tuc.recording import TucRecording
from topomap.mapping.place_claims import PlaceClaims
from topomap.mapping.recorded_drive import RecordedDrive


def drive_of(recording: TucRecording) -> RecordedDrive:
    """Cut a recording into nodes; candidates outside its time get none."""
    named = np.union1d(recording.query_ns, recording.match_ns)
    increments = recording.increments(named)
    stamps = np.concatenate([recording.stamps_ns[:1], increments.stamps_ns])
    inside = named[(named >= stamps[0]) & (named <= stamps[-1])]
    marks = np.union1d([0, len(stamps) - 1], np.searchsorted(stamps, inside))
    return RecordedDrive(stamps, increments, marks)


def claims_of(recording: TucRecording, drive: RecordedDrive) -> PlaceClaims:
    """Return the recording's loop candidates as claims about the drive's nodes."""
    return PlaceClaims(
        recording.query_ns,
        recording.match_ns,
        drive.node_at(recording.query_ns),
        drive.node_at(recording.match_ns),
        recording.similarity,
    )
