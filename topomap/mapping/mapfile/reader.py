"""A map read: whoever wrote the file, and whatever became of it since."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import IO, Any

import numpy as np

from topomap.core.errors import DataError
from topomap.core.files import regular
from topomap.core.geometry import Pose2
from topomap.mapping.experience import EdgeExperience, Experience
from topomap.mapping.graph import Node, Snapshot, TopoMap
from topomap.mapping.mapfile.archive import DAMAGED, Archive, Array
from topomap.mapping.mapfile.checks import check_arrays, check_meta, check_views, rig_of
from topomap.mapping.mapfile.foreign import kind_of
from topomap.mapping.mapfile.writer import FORMAT
from topomap.mapping.odometry.increments import Calibration, Increments
from topomap.mapping.optimizer.problem import ClosureEdge, TurnEdge

ARRAYS: tuple[tuple[str, str, tuple[int, ...], int], ...] = (
    ("stamps_ns", "<i8", (), 1),
    ("travel", "<f8", (), 1),
    ("poses", "<f8", (3,), 1),
    ("names", "<i8", (), 3),
    ("chain", "<i8", (), 1),
    ("jumps", "|b1", (), 3),
    ("image_ends", "<i8", (), 1),
    ("images", "|u1", (), 1),
    ("has_ranges", "|b1", (), 1),
    ("edge_ends", "<i8", (), 1),
    ("increment_stamps_ns", "<i8", (), 1),
    ("deltas", "<f8", (3,), 1),
    ("covariances", "<f8", (3, 3), 1),
    ("closure_ends", "<i8", (2,), 1),
    ("closure_relative", "<f8", (3,), 1),
    ("closure_covariance", "<f8", (3, 3), 1),
    ("closure_weight", "<f8", (), 1),
    ("turn_ends", "<i8", (2,), 2),
    ("turns", "<f8", (2,), 2),
    ("experience_ends", "<i8", (2,), 3),
    ("experience_counts", "<i8", (3,), 3),
    ("experience_seconds", "<f8", (), 3),
)
"""Name, type, columns, and the first format that has it."""


LARGEST = 2**34
"""[bytes] A map of ten thousand nodes has 2 % of them."""


class _Newer(Exception):
    """The file is of a format that isn't known yet; the text says whose."""


def load_map(path: Path | str) -> TopoMap:
    """Read a map. Raises DataError where the file is missing, damaged, of a newer version, or no map."""
    try:
        with regular(Path(path), LARGEST).open("rb") as file:
            return _load(file)
    except OSError as error:
        raise DataError(f"{path}: the map can't be read ({error.strerror or error})") from error
    except _Newer as error:
        raise DataError(f"{path}: {error}") from error
    except DAMAGED as error:
        raise DataError(f"{path}: not a topomap map, or damaged ({kind_of(Path(path)) or error})") from error
    except MemoryError as error:
        raise DataError(f"{path}: the map is too large for this machine's memory") from error


def from_bytes(data: bytes) -> TopoMap:
    """Return the map of a file's bytes. Raises DataError."""
    try:
        return _load(io.BytesIO(data))
    except _Newer as error:
        raise DataError(str(error)) from error
    except DAMAGED as error:
        raise DataError(f"not a topomap map, or damaged ({error})") from error


def _load(file: IO[bytes]) -> TopoMap:
    archive = Archive(file)
    meta = json.loads(archive.read("meta", "|u1").tobytes())
    _refuse_newer(meta)
    check_meta(meta)
    arrays = _arrays(archive, int(meta["format"]))
    check_arrays(arrays, meta)
    topo = TopoMap()
    topo.calibration = Calibration(**meta["calibration"])
    topo.view = meta.get("view", "full")
    nodes = list(_nodes(arrays, meta))
    check_views(nodes)
    _restore(topo, nodes, arrays, meta.get("next_name", 0))
    topo.places = dict(meta.get("places", {}))
    topo.experience = Experience(_experience(arrays))
    return topo


def _refuse_newer(meta: Any) -> None:
    """Say whose file this is before anything in it is held against this version's rules."""
    number = meta.get("format") if isinstance(meta, dict) else None
    if not isinstance(number, int) or isinstance(number, bool) or number < 1:
        raise ValueError("it doesn't say which format it has")
    if number > FORMAT:
        writer = meta.get("writer")
        by = f", written by {writer[:40]}" if isinstance(writer, str) and writer.isprintable() else ""
        raise _Newer(f"map format {number}{by}; this version reads formats 1 to {FORMAT}: a newer topomap is needed")


def _arrays(archive: Archive, number: int) -> dict[str, Array]:
    arrays = {name: archive.read(name, kind, columns) for name, kind, columns, since in ARRAYS if since <= number}
    count = len(arrays["stamps_ns"])
    if number < 3:
        arrays["names"], arrays["jumps"] = np.arange(count), np.zeros(count, bool)
        arrays["ranges"] = archive.read("ranges", "<f4", (0,)).reshape(-1)
        arrays |= {"experience_ends": np.zeros((0, 2), np.int64), "experience_counts": np.zeros((0, 3), np.int64)}
        arrays["experience_seconds"] = np.zeros(0)
    else:
        arrays["ranges"] = archive.read("ranges", "<f4")
    if number < 2:
        arrays["turn_ends"], arrays["turns"] = np.zeros((0, 2), np.int64), np.zeros((0, 2))
    return arrays


def _nodes(arrays: dict[str, Array], meta: dict[str, Any]) -> Iterator[Node]:
    rigs = [rig_of(rig) for rig in meta["rigs"]]
    images, ends = arrays["images"].tobytes(), [0, *arrays["image_ends"].tolist()]
    begin = 0
    rows = zip(arrays["stamps_ns"].tolist(), arrays["travel"].tolist(), meta["rig_of"], strict=True)
    for k, (stamp, travel, rig) in enumerate(rows):
        snapshot = None
        if rig >= 0:
            ranges = None
            if arrays["has_ranges"][k]:
                end = begin + rigs[rig].width
                ranges, begin = arrays["ranges"][begin:end], end
            snapshot = Snapshot(images[ends[k] : ends[k + 1]], ranges, rigs[rig])
        yield Node(stamp, travel, snapshot)


def _restore(topo: TopoMap, nodes: list[Node], arrays: dict[str, Array], next_name: int) -> None:
    chain = arrays["chain"].tolist()
    parts = [arrays["increment_stamps_ns"], arrays["deltas"], arrays["covariances"]]
    edges = [Increments(*(part[a:b] for part in parts)) for a, b in pairwise([0, *arrays["edge_ends"].tolist()])]
    jumps = set(arrays["chain"][arrays["jumps"]].tolist())
    names = arrays["names"].tolist()
    topo.restore(nodes, arrays["poses"], chain, edges, _closures(arrays), _turns(arrays), names, jumps, next_name)


def _closures(arrays: dict[str, Array]) -> list[ClosureEdge]:
    parts = (arrays["closure_relative"], arrays["closure_covariance"], arrays["closure_weight"].tolist())
    # not Pose2.of: what is loaded must equal what was saved, to the bit
    return [
        ClosureEdge(i, j, Pose2(*relative.tolist()), covariance, weight)
        for (i, j), relative, covariance, weight in zip(arrays["closure_ends"].tolist(), *parts, strict=True)
    ]


def _turns(arrays: dict[str, Array]) -> list[TurnEdge]:
    rows = zip(arrays["turn_ends"].tolist(), arrays["turns"].tolist(), strict=True)
    return [TurnEdge(i, j, turn, sigma) for (i, j), (turn, sigma) in rows]


def _experience(arrays: dict[str, Array]) -> Iterator[EdgeExperience]:
    parts = (arrays["experience_counts"].tolist(), arrays["experience_seconds"].tolist())
    for (a, b), (passed, failed, failed_ns), seconds in zip(arrays["experience_ends"].tolist(), *parts, strict=True):
        yield EdgeExperience(a, b, passed, failed, seconds, failed_ns)
