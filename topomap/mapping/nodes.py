"""The map's nodes: places on the route, most with a snapshot."""

from __future__ import annotations

from dataclasses import dataclass

from topomap.core.arrays import Float32Array
from topomap.core.recorded import RecordedRig


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """What is kept of a place: the encoded panorama as logged, ranges (W,) [m] or None, and the rig."""

    encoded: bytes
    ranges: Float32Array | None
    rig: RecordedRig


@dataclass(frozen=True, slots=True)
class Node:
    """A place on the route; snapshot is None for a bare pose node; travel: raw odometer way so far [m]."""

    stamp_ns: int
    travel: float
    snapshot: Snapshot | None
