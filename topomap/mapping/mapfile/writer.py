"""A map written: the same map gives the same bytes, and a file is there wholly or not at all."""

from __future__ import annotations

import json
import os
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from topomap.core.errors import DataError
from topomap.core.recorded import RecordedRig
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapfile.archive import Array, pack
from topomap.mapping.odometry.increments import Increments

FORMAT, LEANING, UPRIGHT = 5, 4, 3
"""What is written where a robot hides a part of its view, where a camera leans, and where neither does. Format 1 kept
no measured turns; format 2 no numbers of nodes, places or several drives; format 3 no leaning cameras."""


def save_map(topo: TopoMap, path: Path | str) -> None:
    """Write the map; a crash or a power cut leaves the old file whole. Raises DataError where it can't be written."""
    path = Path(path)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with temporary.open("wb") as file:
            file.write(to_bytes(topo))
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
        _sync_folder(path.parent)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise DataError(f"{path}: the map can't be written ({error.strerror})") from error


def _sync_folder(folder: Path) -> None:
    """See that the new name is on the disk, too."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def to_bytes(topo: TopoMap) -> bytes:
    """Return the file's bytes; the same map gives the same bytes."""
    return pack(_arrays(topo))


def _arrays(topo: TopoMap) -> dict[str, Array]:
    snapshots = [node.snapshot for node in topo.nodes]
    edges = [increments for _, _, increments in topo.odometry_edges()]
    joined = Increments.concatenate(edges)
    encoded = [snapshot.encoded if snapshot else b"" for snapshot in snapshots]
    ranges = [s.ranges for s in snapshots if s is not None and s.ranges is not None]
    return {
        "meta": np.frombuffer(json.dumps(_meta(topo)).encode(), np.uint8),
        "stamps_ns": np.array([n.stamp_ns for n in topo.nodes], np.int64),
        "travel": np.array([n.travel for n in topo.nodes], float),
        "poses": topo.poses,
        "names": np.array(topo.names, np.int64),
        "chain": np.array(topo.chain, np.int64),
        "jumps": np.array([node in topo.jumps for node in topo.chain], bool),
        "image_ends": np.cumsum([len(e) for e in encoded], dtype=np.int64),
        "images": np.frombuffer(b"".join(encoded), np.uint8),
        "has_ranges": np.array([s is not None and s.ranges is not None for s in snapshots], bool),
        "ranges": np.concatenate([np.zeros(0), *ranges]).astype(np.float32),
        "edge_ends": np.cumsum([len(e) for e in edges], dtype=np.int64),
        "increment_stamps_ns": joined.stamps_ns,
        "deltas": joined.deltas,
        "covariances": joined.covariances,
        "closure_ends": np.array([(c.i, c.j) for c in topo.closures], np.int64).reshape(-1, 2),
        "closure_relative": np.array([c.relative.array() for c in topo.closures]).reshape(-1, 3),
        "closure_covariance": np.array([c.covariance for c in topo.closures]).reshape(-1, 3, 3),
        "closure_weight": np.array([c.weight for c in topo.closures], float),
        "turn_ends": np.array([(t.i, t.j) for t in topo.turns], np.int64).reshape(-1, 2),
        "turns": np.array([(t.turn, t.sigma) for t in topo.turns], float).reshape(-1, 2),
        "experience_ends": np.array([(e.a, e.b) for e in topo.experience], np.int64).reshape(-1, 2),
        "experience_counts": np.array([(e.passed, e.failed, e.failed_ns) for e in topo.experience], np.int64).reshape(
            -1, 3
        ),
        "experience_seconds": np.array([e.seconds for e in topo.experience], float),
    }


def _meta(topo: TopoMap) -> dict[str, Any]:
    rigs = sorted({n.snapshot.rig for n in topo.nodes if n.snapshot}, key=repr)
    names = [rigs.index(n.snapshot.rig) if n.snapshot else -1 for n in topo.nodes]
    return {
        "format": _format(rigs),
        "writer": f"topomap {version('topomap')}",
        "calibration": asdict(topo.calibration),
        "rigs": [_rig(rig) for rig in rigs],
        "rig_of": names,
        "places": dict(sorted(topo.places.items())),
        "view": topo.view,
        **({"next_name": topo.next_name} if topo.next_name > max(topo.names, default=-1) + 1 else {}),
    }


def _format(rigs: list[RecordedRig]) -> int:
    if any(rig.hidden for rig in rigs):
        return FORMAT
    return LEANING if any(rig.roll or rig.pitch for rig in rigs) else UPRIGHT


def _rig(rig: RecordedRig) -> dict[str, Any]:
    """Return a rig's members; an upright one that sees all is written as it was before others were known."""
    members = asdict(rig)
    if not rig.hidden:
        del members["hidden"]
    if not (rig.roll or rig.pitch):
        del members["roll"], members["pitch"]
    return members
