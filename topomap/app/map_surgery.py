"""Closures of a finished map taken back or put in by hand: solved anew, written to another file."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from topomap.core.errors import TopomapError
from topomap.core.geometry import Pose2
from topomap.mapping.graph import TopoMap
from topomap.mapping.map_problem import map_problem
from topomap.mapping.mapfile import load_map, save_map
from topomap.mapping.optimizer import ClosureEdge, solve
from topomap.mapping.places.view_cache import ViewCache
from topomap.vision.image.compare import rotation_difference, signature

POSITION_SIGMA, HEADING_SIGMA = 0.35, math.radians(4.0)


@dataclass(frozen=True)
class Surgery:
    """What became of the map: the new file and rows for people."""

    file: Path
    rows: list[tuple[str, str]]


def withdraw(path: Path, a: int, b: int, out: Path) -> Surgery:
    """Take the closures between nodes a and b back. Raises DataError, and TopomapError where there is none."""
    topo = load_map(path)
    gone = [edge for edge in topo.closures if {edge.i, edge.j} == {a, b}]
    if not gone:
        raise TopomapError(f"{path}: no closure between nodes {a} and {b} ({_known(topo)})")
    for edge in gone:
        topo.remove(edge)
    return _solved(topo, path, out, f"withdrawn: nodes {a} and {b}")


def add(path: Path, a: int, b: int, out: Path) -> Surgery:
    """Claim that nodes a and b, both with a view, are one place; their rotation is found by sight.

    Raises DataError, and TopomapError where a node has no view or the other evidence contradicts: nothing is written.
    """
    topo = load_map(path)
    _check(topo, path, a, b)
    album = ViewCache(topo)
    difference, rotation = rotation_difference(signature(album.panorama(b)), signature(album.panorama(a)))
    covariance = np.diag([POSITION_SIGMA**2, POSITION_SIGMA**2, HEADING_SIGMA**2])
    topo.close(ClosureEdge(a, b, Pose2(0.0, 0.0, rotation), covariance))
    seen = f"added: nodes {a} and {b}, turned by {math.degrees(rotation):.1f} degrees, difference {difference:.2f}"
    return _solved(topo, path, out, seen)


def _check(topo: TopoMap, path: Path, a: int, b: int) -> None:
    for node in (a, b):
        if not 0 <= node < len(topo.nodes):
            raise TopomapError(f"{path}: no node {node}: the map has nodes 0 to {len(topo.nodes) - 1}")
        if topo.nodes[node].snapshot is None:
            raise TopomapError(f"{path}: node {node} is a pose node without a view")
    if a == b:
        raise TopomapError("a closure joins two nodes, not one with itself")
    if any({edge.i, edge.j} == {a, b} for edge in topo.closures):
        raise TopomapError(f"{path}: nodes {a} and {b} are closed already")


def _known(topo: TopoMap) -> str:
    pairs = [f"{edge.i}-{edge.j}" for edge in topo.closures]
    more = ", ..." if len(pairs) > 8 else ""
    return f"there are {', '.join(pairs[:8])}{more}" if pairs else "it has none"


def _solved(topo: TopoMap, path: Path, out: Path, what: str) -> Surgery:
    before, calibration = topo.poses.copy(), topo.calibration
    solution = solve(map_problem(topo))
    lost = [topo.closures[k] for k in np.flatnonzero(solution.closure_weights < 0.5).tolist()]
    if what.startswith("added") and topo.closures[-1] in lost:
        raise TopomapError(f"{path}: the rest of the map contradicts it ({what}); nothing was written")
    for edge in lost:
        topo.remove(edge)
    topo.move(solution.poses, solution.calibration)
    save_map(topo, out)
    moved = np.hypot(*(topo.poses[:, :2] - before[:, :2]).T)
    found = topo.calibration
    return Surgery(
        out,
        [
            ("done", what),
            ("closures", f"{len(topo.closures)}, {len(lost)} no longer fit"),
            ("moved", f"mean {moved.mean():.3f} m, most {moved.max():.3f} m at node {int(moved.argmax())}"),
            ("error", f"{solution.error_before:.2f} before, {solution.error_after:.2f} after"),
            ("rotation scale", f"{calibration.rotation_scale:.4f} before, {found.rotation_scale:.4f} after"),
            ("curvature", f"{calibration.curvature:.5f} before, {found.curvature:.5f} rad/m after"),
            ("graph", f"{len(topo.nodes)} nodes"),
        ],
    )
