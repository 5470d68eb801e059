"""The finished map in one file: a zip of NumPy arrays and JSON, no pickle; loads back equal."""

from __future__ import annotations

import io
import json
import os
import zipfile
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.errors import DataError
from topomap.core.geometry import Pose2
from topomap.core.recorded import RecordedRig
from topomap.mapping.graph import Node, Snapshot, TopoMap
from topomap.mapping.odometry.increments import Calibration, Increments
from topomap.mapping.optimizer.problem import ClosureEdge, TurnEdge

FORMAT = 2
"""What is written. Format 1, which is still read, kept no measured turns."""
READ = (1, 2)


def save_map(topo: TopoMap, path: Path | str) -> None:
    """Write the map, wholly or not at all. Raises DataError where it can't be written."""
    path = Path(path)
    try:
        temporary = path.with_name(path.name + ".part")
        temporary.write_bytes(to_bytes(topo))
        os.replace(temporary, path)
    except OSError as error:
        raise DataError(f"{path}: the map can't be written ({error.strerror})") from error


def load_map(path: Path | str) -> TopoMap:
    """Read a map. Raises DataError where the file is missing, damaged or no map."""
    try:
        return from_bytes(Path(path).read_bytes())
    except OSError as error:
        raise DataError(f"{path}: the map can't be read ({error.strerror})") from error
    except (zipfile.BadZipFile, EOFError, KeyError, ValueError, TypeError, IndexError) as error:
        raise DataError(f"{path}: not a topomap map, or damaged ({error})") from error


def to_bytes(topo: TopoMap) -> bytes:
    """Return the file's bytes; the same map gives the same bytes."""
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **_arrays(topo))
    return buffer.getvalue()


def _arrays(topo: TopoMap) -> dict[str, Any]:
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
        "chain": np.array(topo.chain, np.int64),
        "image_ends": np.cumsum([len(e) for e in encoded], dtype=np.int64),
        "images": np.frombuffer(b"".join(encoded), np.uint8),
        "has_ranges": np.array([s is not None and s.ranges is not None for s in snapshots], bool),
        "ranges": np.array(ranges, np.float32) if ranges else np.zeros((0, 0), np.float32),
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
    }


def _meta(topo: TopoMap) -> dict[str, Any]:
    rigs = sorted({n.snapshot.rig for n in topo.nodes if n.snapshot}, key=repr)
    names = [rigs.index(n.snapshot.rig) if n.snapshot else -1 for n in topo.nodes]
    return {
        "format": FORMAT,
        "calibration": asdict(topo.calibration),
        "rigs": [asdict(rig) for rig in rigs],
        "rig_of": names,
    }


def from_bytes(data: bytes) -> TopoMap:
    """Return the map of a file's bytes. Raises ValueError, KeyError, TypeError, IndexError, EOFError or BadZipFile."""
    with np.load(io.BytesIO(data), allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    meta = json.loads(arrays["meta"].tobytes())
    if meta["format"] not in READ:
        raise ValueError(f"map format {meta['format']}, this version reads {' and '.join(map(str, READ))}")
    topo = TopoMap()
    topo.calibration = Calibration(**meta["calibration"])
    _restore(topo, _nodes(arrays, meta), arrays, [] if meta["format"] == 1 else _turns(arrays))
    return topo


def _nodes(arrays: dict[str, Any], meta: dict[str, Any]) -> list[Node]:
    rigs = [RecordedRig(**rig) for rig in meta["rigs"]]
    images, ends = arrays["images"].tobytes(), [0, *arrays["image_ends"].tolist()]
    ranges = iter(arrays["ranges"])
    nodes = []
    for i, stamp in enumerate(arrays["stamps_ns"].tolist()):
        snapshot = None
        if meta["rig_of"][i] >= 0:
            own = next(ranges) if arrays["has_ranges"][i] else None
            snapshot = Snapshot(images[ends[i] : ends[i + 1]], own, rigs[meta["rig_of"][i]])
        nodes.append(Node(stamp, float(arrays["travel"][i]), snapshot))
    return nodes


def _restore(topo: TopoMap, nodes: list[Node], arrays: dict[str, Any], turns: list[TurnEdge]) -> None:
    chain = arrays["chain"].tolist()
    ends = [0, *arrays["edge_ends"].tolist()]
    edges = [
        Increments(arrays["increment_stamps_ns"][a:b], arrays["deltas"][a:b], arrays["covariances"][a:b])
        for a, b in pairwise(ends)
    ]
    topo.restore(nodes, arrays["poses"], chain, edges, _closures(arrays), turns)


def _closures(arrays: dict[str, FloatArray]) -> list[ClosureEdge]:
    rows = zip(
        arrays["closure_ends"].tolist(),
        arrays["closure_relative"],
        arrays["closure_covariance"],
        arrays["closure_weight"].tolist(),
        strict=True,
    )
    # not Pose2.of: what is loaded must equal what was saved, to the bit
    return [
        ClosureEdge(int(i), int(j), Pose2(*relative.tolist()), covariance, weight)
        for (i, j), relative, covariance, weight in rows
    ]


def _turns(arrays: dict[str, Any]) -> list[TurnEdge]:
    rows = zip(arrays["turn_ends"].tolist(), arrays["turns"].tolist(), strict=True)
    return [TurnEdge(i, j, turn, sigma) for (i, j), (turn, sigma) in rows]
