"""The injection test: pose graphs with false closures, given to the engine and to gtsam's optimisers."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from topomap.bench.pool import Store
from topomap.bench.pose_graphs.clean import clean_optimum
from topomap.bench.pose_graphs.injection import KINDS, Injected, inject
from topomap.bench.pose_graphs.peers import MethodRun, PeerProcess, nothing
from topomap.core.arrays import FloatArray
from topomap.core.errors import TopomapError
from topomap.evaluation.trajectory import ate
from topomap.mapping.graph_engine import optimise_graph, warm_up
from topomap.mapping.optimizer.peers import PEERS
from topomap.mapping.pose_graph import PoseGraph

OURS = "topomap"
SHARES = (0.0, 0.2, 0.5, 0.8, 0.9)
NONE = "none"  # the kind of false closures where there are none


@dataclass(frozen=True, slots=True)
class Row:
    """One method on one graph: closures offered and kept, ate [m] to the clean optimum after SE(2) alignment, time.

    precision is None where nothing was kept, ate where the method failed, recall, too, where it ran out of time.
    cpu_seconds: the processor's; building_seconds: what making gtsam's graph took a peer beside its seconds;
    asked: whether it was run, or is taken for stopped as it was where fewer were false.
    """

    graph: str
    nodes: int
    kind: str
    false_share: float
    method: str
    seed: int
    true: int
    false: int
    kept_true: int
    kept_false: int
    precision: float | None
    recall: float | None
    ate_m: float | None
    odometry_ate_m: float
    seconds: float
    cpu_seconds: float
    building_seconds: float
    stopped: bool
    asked: bool = True


@dataclass(frozen=True, slots=True)
class Design:
    """What is run: kinds of false closures, their shares, seeds, peers and how long a peer may take [s].

    Raises TopomapError for what there isn't.
    """

    kinds: Sequence[str] = KINDS
    shares: Sequence[float] = SHARES
    seeds: Sequence[int] = (0, 1, 2)
    peers: Sequence[str] = tuple(PEERS)
    limit: float = 120.0

    def __post_init__(self) -> None:
        for word, asked, known in (("kind", self.kinds, KINDS), ("peer", self.peers, tuple(PEERS))):
            if unknown := [name for name in asked if name not in known]:
                raise TopomapError(f"no {word} '{unknown[0]}': there are {', '.join(known)}")

    def cells(self) -> list[tuple[str, float, int]]:
        """Return kind, share and seed of each graph made; without false closures kind and seed change nothing."""
        bare = [(NONE, 0.0, self.seeds[0])] if 0.0 in self.shares else []
        return bare + [(kind, share, seed) for kind in self.kinds for share in self.shares if share
                       for seed in self.seeds]  # fmt: skip


class Contest:
    """One graph with what is asked of it; code: a digest of all code that decides a result."""

    def __init__(self, graph: PoseGraph, design: Design, process: PeerProcess, code: str = "") -> None:
        self.graph, self.design, self.process = graph, design, process
        arrays = (graph.odometry, graph.odometry_covariance, graph.i, graph.j, graph.relative, graph.covariance)
        files = hashlib.sha256(b"".join(part.tobytes() for part in (*arrays, graph.gaps)))
        self.digest = [graph.name, files.hexdigest(), [*design.peers], design.limit, code]

    @cached_property
    def clean(self) -> FloatArray:
        """The poses (N, 3) that the true closures make, which false ones and errors are told by."""
        warm_up()
        return clean_optimum(self.graph)


@dataclass(frozen=True, slots=True)
class GraphTask:
    """One graph made: a pool Task whose result is a row a method; slow: peers that it isn't given to."""

    contest: Contest
    kind: str
    share: float
    seed: int
    slow: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        """All that decides the result."""
        return json.dumps(["graphs", *self.contest.digest, self.kind, self.share, self.seed, *self.slow])

    def perform(self) -> tuple[Row, ...]:
        """Inject false closures and give the graph to each method. Raises TopomapError where there is no room."""
        contest, clean, kind = self.contest, self.contest.clean, self.kind if self.kind != NONE else KINDS[0]
        drift = ate(contest.graph.dead_reckoning(), clean)
        rng = np.random.default_rng([self.seed, round(1000 * self.share), (*KINDS, NONE).index(self.kind)])
        injected = inject(contest.graph, clean, kind, self.share, rng)
        rows = []
        for method in (OURS, *contest.design.peers):
            run = self._run(method, injected.graph)
            rows.append(_row(injected, clean, drift, (self.kind, self.share, self.seed), method, run))
        return tuple(rows)

    def _run(self, method: str, graph: PoseGraph) -> MethodRun | None:
        if method == OURS:
            return _ours(graph)
        return None if method in self.slow else self.contest.process.run(method, graph)


def bench(graph: PoseGraph, design: Design, store: Store | None = None, code: str = "") -> Iterator[tuple[Row, ...]]:
    """Yield the rows of each graph made, one a method, as they come; what the store knows isn't measured again.

    A peer that was stopped isn't asked where more closures of the same kind and seed are false, as it would be stopped
    again: so it was in 31 of 32 such graphs (CSAIL, intel, manhattan; DCS, GNC, Huber).
    code: a digest of all code that decides a result. Raises TopomapError.
    """
    store = store or Store(None)
    stopped: list[Row] = []
    with PeerProcess(design.limit) as process:
        contest = Contest(graph, design, process, code)
        for cell in design.cells():
            task = GraphTask(contest, *cell, slow=_slow(stopped, *cell))
            rows = store.get(task)
            if rows is None:
                rows = task.perform()
                store.put(task.key, rows)
            stopped += [row for row in rows if row.stopped]
            yield rows


def _slow(stopped: Sequence[Row], kind: str, share: float, seed: int) -> tuple[str, ...]:
    """Return the peers that were stopped where fewer closures were false."""
    return tuple(sorted({row.method for row in stopped if row.false_share < share
                         and (row.kind == NONE or (row.kind, row.seed) == (kind, seed))}))  # fmt: skip


def _ours(graph: PoseGraph) -> MethodRun:
    begin, worked = time.perf_counter(), time.process_time()
    verdicts = optimise_graph(graph)
    seconds, cpu = time.perf_counter() - begin, time.process_time() - worked
    return MethodRun(verdicts.poses, verdicts.inlier, seconds, cpu, 0.0, False)


def _row(
    injected: Injected,
    clean: FloatArray,
    drift: float,
    cell: tuple[str, float, int],
    method: str,
    made: MethodRun | None,
) -> Row:
    false, run = injected.false, made or nothing(injected.graph, 0.0, 0.0, stopped=True)
    right, wrong = int((run.inlier & ~false).sum()), int((run.inlier & false).sum())
    return Row(
        graph=injected.graph.name,
        nodes=injected.graph.nodes,
        kind=cell[0],
        false_share=cell[1],
        method=method,
        seed=cell[2],
        true=int((~false).sum()),
        false=int(false.sum()),
        kept_true=right,
        kept_false=wrong,
        precision=right / (right + wrong) if right + wrong else None,
        recall=None if run.stopped else right / max(1, int((~false).sum())),
        ate_m=ate(run.poses, clean) if np.isfinite(run.poses).all() else None,
        odometry_ate_m=drift,
        seconds=run.seconds,
        cpu_seconds=run.cpu_seconds,
        building_seconds=run.building_seconds,
        stopped=run.stopped,
        asked=made is not None,
    )
