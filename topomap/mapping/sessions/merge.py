"""Two maps of overlapping ground as one: what the second holds of the first are claims for the closure engine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import IntArray
from topomap.core.errors import TopomapError
from topomap.mapping.closures.batch import Batch, Judgement
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.drive import Drive
from topomap.mapping.experience import Experience
from topomap.mapping.graph import BETWEEN_DRIVES_NS, Node, TopoMap
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements, Increments
from topomap.mapping.odometry.known import KEPT_SIGMAS
from topomap.mapping.optimizer import OdometryEdge, OdometryEdges, TurnEdge
from topomap.mapping.optimizer.problem import ClosureEdge
from topomap.mapping.pose_graph import gap_covariance
from topomap.mapping.sessions.cross_claims import CrossClaims, Seen

FAR = 100.0
"""[m] Way set between the drives: all of the first map counts as left long ago."""
FEWEST = 3
"""Closures between maps below which they aren't merged: as many as a robot asks for where odometry tells nothing."""

Told = Callable[[float, str], None]


class Merged(NamedTuple):
    """Two maps as one; offset: what the second one's node numbers were raised by; proposed, across: closures between
    the two that looks propose, and that stand; lost: closures within one of them that no longer stand.
    """

    map: TopoMap
    offset: int
    proposed: int
    across: int
    lost: int


def merge(first: TopoMap, second: TopoMap, claims: CrossClaims, told: Told) -> Merged:
    """Return both maps in the first one's frame and numbers. Raises TopomapError where they share no ground.

    claims: finds places of the second in the first; told: hears the share done and what is being done.
    """
    if first.view != second.view:
        raise TopomapError(f"one map holds {first.view} views, the other {second.view}: make one of one kind")
    seen = claims.between(first, second, lambda share: told(0.3 * share, "places seen in both"))
    joined, offset = _joined(first, second)
    count = len(first.nodes)
    own = [*first.closures, *(replace(c, i=c.i + count, j=c.j + count) for c in second.closures)]
    at = [replace(one, j=one.j + count) for one in seen]
    judged, edges = _judged(joined, own, at, lambda share, what: told(0.3 + 0.3 * share, what))
    stand = _across(judged, edges, count)
    if len(stand) >= FEWEST:
        laid, _ = _joined(first, second)  # the engine begins again with what odometry alone says
        _lay(laid, judged)
        standing = [one for one in at if (one.i, one.j) in stand]
        at = claims.near(laid, count, standing, lambda share: told(0.6 + 0.1 * share, "places beside one another"))
        judged, edges = _judged(joined, own, at, lambda share, what: told(0.7 + 0.3 * share, what))
        stand = _across(judged, edges, count)
    if len(stand) < FEWEST:
        raise TopomapError(
            f"the maps share no ground that is sure: {len(stand)} of {len(at)} closures between them are likely, "
            f"{FEWEST} are needed"
        )
    _settle(joined, judged, edges)
    kept = int(judged.inlier.sum()) - len(stand)
    return Merged(joined, offset, len(at), len(stand), len(own) - kept)


def _across(judged: Judgement, edges: list[ClosureEdge], count: int) -> set[tuple[int, int]]:
    """Return the nodes that closures join which stand between the maps, the first one's before."""
    stand = (edge for edge, inlier in zip(edges, judged.inlier.tolist(), strict=True) if inlier)
    return {(edge.i, edge.j) for edge in stand if (edge.i < count) != (edge.j < count)}


def _joined(first: TopoMap, second: TopoMap) -> tuple[TopoMap, int]:
    """Return both drives in one map, a gap between them, and what the second one's numbers were raised by."""
    count, offset = len(first.nodes), first.next_name
    last, begin = first.nodes[first.chain[-1]], second.nodes[second.chain[0]]
    later = last.stamp_ns + BETWEEN_DRIVES_NS - begin.stamp_ns
    further = last.travel + FAR
    gap = Increments(np.array([last.stamp_ns + BETWEEN_DRIVES_NS]), np.zeros((1, 3)), _unknown(first, second)[None])
    own = [increments for _, _, increments in first.odometry_edges()]
    other = [_read_as(increments, second.calibration, first.calibration, later)
             for _, _, increments in second.odometry_edges()]  # fmt: skip
    moved = [Node(n.stamp_ns + later, n.travel + further, n.snapshot) for n in second.nodes]
    start = first.pose(first.chain[-1]) @ second.pose(second.chain[0]).inverse()
    poses = [start @ second.pose(k) for k in range(len(second.nodes))]
    result = TopoMap()
    result.calibration, result.view = first.calibration, first.view
    result.restore(
        [*first.nodes, *moved],
        np.vstack([first.poses, [pose.array() for pose in poses]]),
        [*first.chain, *(node + count for node in second.chain)],
        [*own, gap, *other],
        [],
        [*first.turns, *(TurnEdge(t.i + count, t.j + count, t.turn, t.sigma) for t in second.turns)],
        [*first.names, *(name + offset for name in second.names)],
        {*first.jumps, second.chain[0] + count, *(node + count for node in second.jumps)},
        second.next_name + offset,
    )
    result.places = {**{name: node + offset for name, node in second.places.items()}, **first.places}
    shifted = (replace(row, a=row.a + count, b=row.b + count) for row in second.experience)
    result.experience = Experience([*first.experience, *shifted])
    return result, offset


def _unknown(first: TopoMap, second: TopoMap) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return np.maximum(gap_covariance(first.poses), gap_covariance(second.poses))


def _read_as(increments: Increments, theirs: Calibration, ours: Calibration, later: int) -> Increments:
    """Return increments as the first map's odometer would have read them, stamps set later by [ns].

    One calibration holds for all of a map: what the second drive found of its odometer is applied before.
    """
    read = EdgeIncrements.of([increments]).read_by(theirs, ours)
    return Increments(increments.stamps_ns + later, read.deltas, read.covariances)


def _judged(
    joined: TopoMap, own: list[ClosureEdge], seen: list[Seen], told: Told
) -> tuple[Judgement, list[ClosureEdge]]:
    """Return what the engine makes of closures, within the maps and between them, and these in its order."""
    claimed = [
        *((edge, 0.0) for edge in own),
        *((ClosureEdge(s.i, s.j, s.relative, s.covariance), s.looks) for s in seen),
    ]
    place = np.empty(len(joined.chain), np.int64)
    place[joined.chain] = np.arange(len(joined.chain))
    ordered = sorted(claimed, key=lambda one: (_ends(one[0], place), one[1]))
    edges = [edge for edge, _ in ordered]
    claims = replace(_claims(edges, place), looks=np.array([looks for _, looks in ordered]))
    drive = Drive(
        joined.poses[joined.chain],
        OdometryEdges.of([OdometryEdge(int(place[a]), int(place[b]), way) for a, b, way in joined.odometry_edges()]),
        joined.calibration,
        KEPT_SIGMAS,
        tuple(TurnEdge(int(place[t.i]), int(place[t.j]), t.turn, t.sigma) for t in joined.turns),
    )
    return Batch(drive, claims, told=told).run(), edges


def _ends(edge: ClosureEdge, place: IntArray) -> tuple[int, int]:
    """Return the chain places that a closure joins, the earlier first."""
    a, b = int(place[edge.i]), int(place[edge.j])
    return min(a, b), max(a, b)


def _claims(edges: list[ClosureEdge], place: IntArray) -> Claims:
    """Return closures as claims, each from the earlier of its places."""
    ends = np.array([_ends(edge, place) for edge in edges], np.int64).reshape(-1, 2)
    turned = [edge if place[edge.i] < place[edge.j] else _reversed(edge) for edge in edges]
    relative = np.array([edge.relative.array() for edge in turned]).reshape(-1, 3)
    return Claims.of(ends[:, 0], ends[:, 1], relative, np.array([e.covariance for e in turned]).reshape(-1, 3, 3))


def _reversed(edge: ClosureEdge) -> ClosureEdge:
    """Return a closure as seen from its other end."""
    back = edge.relative.inverse()
    c, s = np.cos(edge.relative.heading), np.sin(edge.relative.heading)
    carry = np.array([[-c, -s, back.y], [s, -c, -back.x], [0.0, 0.0, -1.0]])
    return ClosureEdge(edge.j, edge.i, back, carry @ edge.covariance @ carry.T, edge.weight)


def _settle(joined: TopoMap, judged: Judgement, edges: list[ClosureEdge]) -> None:
    """Close what stands and move the nodes to where the engine has them."""
    for edge, inlier in zip(edges, judged.inlier.tolist(), strict=True):
        if inlier:
            joined.close(edge)
    _lay(joined, judged)


def _lay(joined: TopoMap, judged: Judgement) -> None:
    poses = np.empty_like(joined.poses)
    poses[joined.chain] = judged.state.poses
    joined.move(poses, judged.state.calibration)
