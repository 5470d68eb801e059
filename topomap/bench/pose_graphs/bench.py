"""The injection test: pose graphs with false closures, given to the engine and to gtsam's optimisers."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from topomap.bench.pose_graphs.clean import clean_optimum
from topomap.bench.pose_graphs.injection import KINDS, Injected, inject
from topomap.bench.pose_graphs.peers import MethodRun, PeerProcess
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
    building_seconds: what making gtsam's graph took a peer beside its seconds.
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
    building_seconds: float
    stopped: bool


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


def bench(graph: PoseGraph, design: Design) -> Iterator[Row]:
    """Yield a row a graph made and method. Raises TopomapError."""
    clean = clean_optimum(graph)
    drift = ate(graph.dead_reckoning(), clean)
    warm_up()
    with PeerProcess(design.limit) as process:
        for kind, share, seed in design.cells():
            rng = np.random.default_rng([seed, round(1000 * share), (*KINDS, NONE).index(kind)])
            injected = inject(graph, clean, kind if kind != NONE else KINDS[0], share, rng)
            for method in (OURS, *design.peers):
                run = _ours(injected.graph) if method == OURS else process.run(method, injected.graph)
                yield _row(injected, clean, drift, (kind, share, seed), method, run)


def _ours(graph: PoseGraph) -> MethodRun:
    begin = time.perf_counter()
    verdicts = optimise_graph(graph)
    return MethodRun(verdicts.poses, verdicts.inlier, time.perf_counter() - begin, 0.0, False)


def _row(
    injected: Injected, clean: FloatArray, drift: float, cell: tuple[str, float, int], method: str, run: MethodRun
) -> Row:
    false = injected.false
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
        building_seconds=run.building_seconds,
        stopped=run.stopped,
    )
