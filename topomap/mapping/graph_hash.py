"""The hashes of a map: the same readings, settings and seed make the same map, and these say so."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence, Set
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.mapping.nodes import Node
from topomap.mapping.optimizer.problem import ClosureEdge


class Hashed(NamedTuple):
    """What of a map is hashed; see `TopoMap`."""

    nodes: Sequence[Node]
    names: list[int]
    chain: list[int]
    jumps: Set[int]
    closures: Sequence[ClosureEdge]
    poses: FloatArray


def graph_hash(topo: Hashed, verdicts: list[tuple[int, int, str, str]]) -> str:
    """Return the SHA-256 over nodes, views, edges, poses and verdicts (stamp, match, verdict, reason)."""
    digest = hashlib.sha256()
    for node in topo.nodes:
        digest.update(f"{node.stamp_ns} {float(node.travel)!r}".encode())
        digest.update(node.snapshot.encoded if node.snapshot else b"pose")
    edges = [(c.i, c.j, list(c.relative.array())) for c in topo.closures]
    said = [(int(stamp_ns), int(match), verdict, reason) for stamp_ns, match, verdict, reason in verdicts]
    digest.update(json.dumps([topo.chain, edges, said]).encode())
    if topo.jumps or topo.names != list(range(len(topo.nodes))):
        digest.update(json.dumps([topo.names, sorted(topo.jumps)]).encode())
    digest.update(np.ascontiguousarray(topo.poses).tobytes())
    return digest.hexdigest()


def topology_hash(topo: Hashed, verdicts: list[tuple[int, int, str]]) -> str:
    """Return the SHA-256 of all but the numbers: nodes, views, edges and verdicts (stamp, match, verdict).

    It is the same on every machine; poses may differ there in their last digits.
    """
    digest = hashlib.sha256()
    for node in topo.nodes:
        digest.update(f"{int(node.stamp_ns)} ".encode())
        digest.update(node.snapshot.encoded if node.snapshot else b"pose")
    edges = [(int(c.i), int(c.j)) for c in topo.closures]
    said = [(int(stamp_ns), int(match), verdict) for stamp_ns, match, verdict in verdicts]
    digest.update(json.dumps([topo.chain, edges, said]).encode())
    return digest.hexdigest()
