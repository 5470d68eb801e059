"""A map made anew of some of its nodes: numbers, names and what joins them stay."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from topomap.core.geometry import Pose2
from topomap.mapping.experience import Experience
from topomap.mapping.graph import TopoMap
from topomap.mapping.odometry.increments import Increments, leading
from topomap.mapping.pose_graph import gap_covariance
from topomap.mapping.sessions.condense import condensed


def only(topo: TopoMap, keep: set[int], parting: set[int]) -> TopoMap:
    """Return the map of the nodes to keep; poses stay as they are.

    parting: nodes left out between which and their neighbours nobody can drive any more; over others that are left out
    the way goes on.
    """
    new = {old: k for k, old in enumerate(sorted(keep))}
    chain = [node for node in topo.chain if node in keep]
    edges, jumps = _ways(topo, chain, parting)
    result = TopoMap()
    result.calibration, result.view = topo.calibration, topo.view
    result.restore(
        [topo.nodes[old] for old in new],
        topo.poses[list(new)],
        [new[node] for node in chain],
        edges,
        [replace(c, i=new[c.i], j=new[c.j]) for c in topo.closures if c.i in keep and c.j in keep],
        [replace(t, i=new[t.i], j=new[t.j]) for t in topo.turns if t.i in keep and t.j in keep],
        [topo.names[old] for old in new],
        {new[node] for node in jumps},
        topo.next_name,
    )
    result.places = dict(topo.places)
    kept = (row for row in topo.experience if row.a in keep and row.b in keep)
    result.experience = Experience(replace(row, a=new[row.a], b=new[row.b]) for row in kept)
    return result


def _ways(topo: TopoMap, chain: list[int], parting: set[int]) -> tuple[list[Increments], set[int]]:
    """Return the odometry between the nodes that are kept, and to which of them nobody can drive from the one before.

    Over nodes left out it is condensed; where another drive begins between two of them, it is a gap once more.
    """
    own = {(a, b): increments for a, b, increments in topo.odometry_edges()}
    place = {node: k for k, node in enumerate(topo.chain)}
    edges, jumps = [], set()
    for a, b in pairwise(chain):
        between = topo.chain[place[a] : place[b] + 1]
        ways = [own[pair] for pair in pairwise(between)]
        begins = [node for node in between[1:] if node in topo.jumps]
        if begins or parting & set(between[1:-1]):
            jumps.add(b)
        if len(ways) == 1:
            edges.append(ways[0])
        elif begins and not _joined(topo, begins, own, place):
            deltas = leading(topo.pose(a).to(Pose2.of(topo.poses[b])), topo.calibration)[None]
            edges.append(Increments(ways[-1].stamps_ns[-1:], deltas, gap_covariance(topo.poses)[None]))
        else:
            edges.append(condensed(Increments.concatenate(ways), topo.calibration))
    return edges, jumps


def _joined(topo: TopoMap, begins: list[int], own: dict[tuple[int, int], Increments], place: dict[int, int]) -> bool:
    """Return whether the jumps to these nodes are ways that odometry knows, left out once, and not other drives."""
    ends = [(topo.chain[place[node] - 1], node) for node in begins]
    return all(float(own[pair].covariances[:, 2, 2].max()) < 1.0 for pair in ends)
