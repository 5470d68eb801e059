"""The map: nodes in travel order, joined by odometry, and closures that join places seen again."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import networkx as nx
import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import Pose2, between, compose, wrap_all
from topomap.core.recorded import Spans
from topomap.mapping.experience import Experience
from topomap.mapping.graph_hash import Hashed, graph_hash, topology_hash
from topomap.mapping.nodes import Node as Node
from topomap.mapping.nodes import Snapshot as Snapshot
from topomap.mapping.odometry.chain_increments import ChainIncrements
from topomap.mapping.odometry.gap import bridged
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements, Increments, integrate, track
from topomap.mapping.odometry.noise import OdometerNoise
from topomap.mapping.optimizer.problem import ClosureEdge, OdometryEdges, TurnEdge

BETWEEN_DRIVES_NS = 3_600_000_000_000
"""[ns] Time set between two drives whose clocks would overlap, as a simulated clock begins anew with each."""

SHARE = 0.33
"""Share of the chain from which on a piece of it is cut from the whole, which is kept. Of 13,438 edges, one by one, all
take 16 ms, the last 4,500 3 to 6, the last 200 0.2; cut, any piece takes 2 to 3."""


class TopoMap:
    """Nodes, their poses, odometry edges along the travelled chain, closures, and turns measured between snapshots.

    Nodes are counted in the order of creation; `chain` lists them in travel order (a pose node that was inserted
    later stands between its neighbours). Only Mapper changes a map, but for `experience`, which journeys write.

    names: each node's number for people, which stays when others are taken out; places: a name given to a node's
    number; jumps: nodes that can't be driven to from the one before them on the chain, as another drive begins there,
    or as the way between was taken out; view: what is kept of a snapshot.
    """

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self.names: list[int] = []
        self.places: dict[str, int] = {}
        self.jumps: set[int] = set()
        self.view = "full"
        self.chain: list[int] = []
        self.closures: list[ClosureEdge] = []
        self.turns: list[TurnEdge] = []
        self.calibration = Calibration()
        self.experience = Experience()
        self.graph: nx.Graph[int] = nx.Graph()
        self.next_name = 0  # no node ever had it: one that was left out keeps its number for itself
        self._poses = np.zeros((64, 3))
        self._increments = ChainIncrements()

    @property
    def noise(self) -> OdometerNoise:
        """What the odometry's declared variances are taken times."""
        return self._increments.noise

    @property
    def poses(self) -> FloatArray:
        """The nodes' poses (N, 3) in the map frame, by node id."""
        return self._poses[: len(self.nodes)]

    def pose(self, node: int) -> Pose2:
        """Return the pose of a node."""
        return Pose2.of(self.poses[node])

    def length(self, a: int, b: int) -> float:
        """Return the map distance between two nodes [m]."""
        return float(np.hypot(*(self.poses[a, :2] - self.poses[b, :2])))

    def add(self, node: Node, increments: Increments | None, jump: bool = False) -> int:
        """Append a node to the chain, `increments` after the last one (None for the first); return its id.

        jump: the way between can't be driven.
        """
        if increments is None:
            return self._store(node, np.zeros(3), len(self.chain))
        last = self.chain[-1]
        delta, _, _ = integrate(increments, self.calibration)
        new = self._store(node, compose(self.poses[last], delta), len(self.chain))
        if jump:
            self.jumps.add(new)
        self._join(last, new, increments)
        return new

    def pose_at(self, stamp_ns: int) -> Pose2:
        """Return the pose at a stamp between the first node and the last."""
        place = bisect_left(self.chain, stamp_ns, key=lambda node: self.nodes[node].stamp_ns)
        if self.nodes[self.chain[place]].stamp_ns == stamp_ns:
            return self.pose(self.chain[place])
        a, b = self.chain[place - 1], self.chain[place]
        whole = self._increments[a, b]
        return Pose2.of(self._steps(a, b, whole)[int(np.searchsorted(whole.stamps_ns, stamp_ns))])

    def insert(self, stamp_ns: int) -> int:
        """Return the node at a stamp, splitting the odometry edge it lies on if there is none yet."""
        place = bisect_left(self.chain, stamp_ns, key=lambda node: self.nodes[node].stamp_ns)
        if self.nodes[self.chain[place]].stamp_ns == stamp_ns:
            return self.chain[place]
        a, b = self.chain[place - 1], self.chain[place]
        return self._split(a, b, place, stamp_ns)

    def close(self, edge: ClosureEdge) -> None:
        """Add an accepted closure (`edge.i` the old node, `edge.j` the new one)."""
        self.closures.append(edge)
        if not self.graph.has_edge(edge.i, edge.j):
            self.graph.add_edge(edge.i, edge.j, kind="closure")

    def remove(self, edge: ClosureEdge) -> None:
        """Take an accepted closure back."""
        self.closures.remove(edge)
        if self.graph.edges[edge.i, edge.j]["kind"] == "closure":
            self._part(edge.i, edge.j)

    def move(self, poses: FloatArray, calibration: Calibration, others: int = 0) -> None:
        """Set the poses (n, 3) of the first nodes and the calibration: what a solution does.

        Nodes that came since lie after them on the chain, or between them, as they did, but for what the calibration
        changes of odometry. others: how many of the first edges were driven by other odometers, which it isn't of: they
        are kept as the one that it is of would have read them.
        """
        since = {}
        for before, node in pairwise(self.chain):
            if node >= len(poses):
                then, now = (integrate(self._increments[before, node], c)[0] for c in (self.calibration, calibration))
                since[before, node] = between(self.poses[before], self.poses[node]) + now - then
        self.poses[: len(poses)] = poses
        if others and calibration != self.calibration:
            self._increments.read_by(list(pairwise(self.chain[: others + 1])), self.calibration, calibration)
        self.calibration = calibration
        self._lay(since)

    def place(self, node: int, pose: Pose2) -> None:
        """Move a node and all behind it on the chain as a whole, so that it lies at `pose`; before it is a gap then."""
        k = self.chain.index(node)
        before, rest = self.chain[k - 1], np.array(self.chain[k:])
        moved = compose(pose.array(), between(self.poses[node], self.poses[rest]))
        target = self.pose(before).to(pose)
        self._increments[before, node] = bridged(self._increments[before, node], self.calibration, target)
        self.poses[rest] = moved

    def shift(self, nodes: IntArray, poses: FloatArray) -> None:
        """Set the poses (n, 3) of some nodes (n,), in travel order and to what was the end of the chain.

        Nodes that came since lie after them on the chain, or between them, as they did.
        """
        known = set(nodes.tolist())
        way = pairwise(self.chain[self.chain.index(int(nodes[0])) :])
        since = {(a, b): between(self.poses[a], self.poses[b]) for a, b in way if b not in known}
        self.poses[nodes] = poses
        self._lay(since)

    def restate(self, node: int, roll: float, pitch: float, hidden: Spans) -> None:
        """Let a snapshot's camera have leant so [rad] and this be hidden. Raises ValueError for a node without one."""
        held = self.nodes[node]
        if held.snapshot is None:
            raise ValueError(f"node {node} is a pose node without a view")
        rig = replace(held.snapshot.rig, roll=roll, pitch=pitch, hidden=hidden)
        self.nodes[node] = replace(held, snapshot=replace(held.snapshot, rig=rig))

    def judge(self, noise: OdometerNoise) -> None:
        """Take the odometry's errors for what the data says."""
        self._increments.judge(noise)

    def settle(self) -> None:
        """Let the odometry so far be as sure as it says, whatever is judged from now on: a loaded map's was judged."""
        self._increments.settle()

    def weigh(self, turns: Sequence[TurnEdge]) -> None:
        """Replace the measured turns: the same ones with other sigmas, or some left out."""
        self.turns[:] = turns

    def end_before(self, stamp_ns: int) -> None:
        """Set all stamps back, as one, so far that another drive can begin at a stamp [ns]; nothing if it can."""
        last = self.nodes[self.chain[-1]].stamp_ns
        if last < stamp_ns:
            return
        back = last + BETWEEN_DRIVES_NS - stamp_ns
        self.nodes = [replace(node, stamp_ns=node.stamp_ns - back) for node in self.nodes]
        self._increments.set_back(back)

    def node_named(self, name: int) -> int | None:
        """Return the node of a number for people, None where the map has none of that number."""
        return self.names.index(name) if name in self.names else None

    def odometry_edges(self) -> Iterator[tuple[int, int, Increments]]:
        """Yield (a, b, increments) along the chain, their covariances as judged."""
        return self.edges_from(0)

    def replace_way(self, a: int, b: int, increments: Increments) -> None:
        """Set the odometry from a node to the next on the chain; it must lead to where the old one did."""
        self._increments[a, b] = increments

    def edges_from(self, place: int) -> Iterator[tuple[int, int, Increments]]:
        """Yield (a, b, increments) along the chain from a place in it on, their covariances as judged."""
        edges = list(pairwise(self.chain[place:]))
        for (a, b), judged in zip(edges, self._increments.judged(edges), strict=True):
            yield a, b, judged

    def odometry(self, place: int = 0) -> OdometryEdges:
        """Return the edges along the chain from a place in it on, in one piece, their covariances as judged."""
        nodes = np.array(self.chain[place:], np.int64)
        if len(nodes) > SHARE * len(self.chain):
            increments = self._increments.whole(list(pairwise(self.chain))).after(place)
        else:
            increments = EdgeIncrements.of(self._increments.judged(list(pairwise(self.chain[place:]))))
        return OdometryEdges(nodes[:-1], nodes[1:], increments)

    def way(self, a: int, b: int) -> Increments:
        """Return the increments as declared from node a to node b, which comes later on the chain and not long before
        its end.
        """
        last = len(self.chain) - 1 - self.chain[::-1].index(b)
        first = last - self.chain[last::-1].index(a)
        nodes = self.chain[first : last + 1]
        return Increments.concatenate([self._increments[pair] for pair in pairwise(nodes)])

    def dead_reckoning(self) -> FloatArray:
        """Return the nodes' poses (N, 3) by odometry as read, from the first on."""
        poses = self.poses.copy()
        for before, node in pairwise(self.chain):
            delta, _, _ = integrate(self._increments[before, node], Calibration())
            poses[node] = compose(poses[before], delta)
        return poses

    def trajectory(self, first: int | None = None) -> tuple[IntArray, FloatArray]:
        """Return stamps (K,) and poses (K, 3) of every step up to the last node, on the corrected route.

        first: the node to begin at instead of the chain's first.
        """
        begin = 0 if first is None else self.chain.index(first)
        stamps = [np.array([self.nodes[self.chain[begin]].stamp_ns])]
        poses = [self.poses[self.chain[begin : begin + 1]]]
        for a, b, increments in self.edges_from(begin):
            stamps.append(increments.stamps_ns)
            poses.append(self._steps(a, b, increments))
        return np.concatenate(stamps), np.concatenate(poses)

    def hash(self, verdicts: list[tuple[int, int, str, str]]) -> str:
        """Return the SHA-256 over nodes, views, edges, poses and verdicts (stamp, match, verdict, reason)."""
        return graph_hash(self._hashed(), verdicts)

    def topology_hash(self, verdicts: list[tuple[int, int, str]]) -> str:
        """Return the SHA-256 of all but the numbers: nodes, views, edges and verdicts (stamp, match, verdict).

        It is the same on every machine; poses may differ there in their last digits.
        """
        return topology_hash(self._hashed(), verdicts)

    def _hashed(self) -> Hashed:
        return Hashed(self.nodes, self.names, self.chain, self.jumps, self.closures, self.poses)

    def restore(
        self,
        nodes: list[Node],
        poses: FloatArray,
        chain: list[int],
        edges: list[Increments],
        closures: list[ClosureEdge],
        turns: list[TurnEdge],
        names: list[int] | None = None,
        jumps: set[int] | None = None,
        next_name: int = 0,
    ) -> None:
        """Fill an empty map with saved contents: edges (len(chain) - 1) along the chain. Raises ValueError.

        next_name: least number that the next node is given, which nodes that were left out have not had.
        """
        if sorted(chain) != list(range(len(nodes))) or poses.shape != (len(nodes), 3):
            raise ValueError("nodes, poses and chain don't fit together")
        for node, pose in zip(nodes, poses, strict=True):
            self._store(node, pose, len(self.chain))
        self.chain = list(chain)
        self.names = self.names if names is None else list(names)
        self.next_name = max(next_name, max(self.names, default=-1) + 1)
        self.jumps = set(jumps or ())
        for a, b, increments in zip(chain, chain[1:], edges, strict=False):
            self._join(a, b, increments)
        for edge in closures:
            self.close(edge)
        self.turns = turns

    def _lay(self, ways: dict[tuple[int, int], FloatArray]) -> None:
        """Lay nodes behind those before them on the chain, each by its way (3,)."""
        for (before, node), way in ways.items():
            self.poses[node] = compose(self.poses[before], way)

    def _store(self, node: Node, pose: FloatArray, place: int) -> int:
        new = len(self.nodes)
        if new == len(self._poses):
            self._poses = np.concatenate([self._poses, np.zeros_like(self._poses)])
        self.nodes.append(node)
        self.names.append(self.next_name)
        self.next_name += 1
        self._poses[new] = pose
        self.chain.insert(place, new)
        self.graph.add_node(new)
        return new

    def _join(self, a: int, b: int, increments: Increments) -> None:
        self._increments[a, b] = increments
        if b not in self.jumps:
            self.graph.add_edge(a, b, kind="odometry")

    def _part(self, a: int, b: int) -> None:
        """Take away what joins two nodes in the graph, but for the closures there are between them."""
        self.graph.remove_edge(a, b)
        if any({c.i, c.j} == {a, b} for c in self.closures):
            self.graph.add_edge(a, b, kind="closure")

    def _split(self, a: int, b: int, place: int, stamp_ns: int) -> int:
        whole = self._increments.pop((a, b))
        first, second = whole.split(int(np.searchsorted(whole.stamps_ns, stamp_ns)) + 1)
        travel = self.nodes[a].travel + float(np.abs(first.deltas[:, 0]).sum())
        pose = self._steps(a, b, whole)[len(first) - 1]
        new = self._store(Node(stamp_ns, travel, None), pose, place)
        self._part(a, b)
        self._join(a, new, first)
        self._join(new, b, second)
        return new

    def _steps(self, a: int, b: int, increments: Increments) -> FloatArray:
        """Return (K, 3) the corrected poses after each increment of an edge.

        What the edge's odometry misses of the corrected end is spread evenly along its steps.
        """
        steps = track(increments, self.calibration, self.pose(a))[1:]
        rest = self.poses[b] - steps[-1]
        rest[2] = wrap_all(rest[2])
        steps += rest * (np.arange(1, len(steps) + 1) / len(steps))[:, None]
        steps[:, 2] = wrap_all(steps[:, 2])
        return steps
