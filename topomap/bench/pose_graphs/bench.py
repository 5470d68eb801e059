"""The injection test: pose graphs with false closures, mapped by this back end and by gtsam's optimisers."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from topomap.bench.pose_graphs.injection import Injected, inject
from topomap.bench.pose_graphs.peers import PeerProcess, PeerRun, closures_of
from topomap.core.arrays import FloatArray
from topomap.core.errors import TopomapError
from topomap.evaluation.rows import rows_csv
from topomap.evaluation.trajectory import ate
from topomap.mapping.closures.graph_odometry import odometry_poses
from topomap.mapping.closures.growth import map_graph
from topomap.mapping.optimizer.peers import PEERS, optimum
from topomap.mapping.pose_graph import PoseGraph

OURS = "topomap"
ODOMETRY = "odometry"
SHARES = (0.0, 0.2, 0.5, 0.8, 0.9)
LARGE = 2000  # nodes


@dataclass(frozen=True, slots=True)
class Row:
    """One method on one graph: closures offered and kept, ate [m] to the clean optimum after SE(2) alignment, time.

    precision is None where nothing was kept, ate where the method failed, recall, too, where it ran out of time.
    """

    graph: str
    nodes: int
    method: str
    false_share: float
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
    stopped: bool


@dataclass(frozen=True, slots=True)
class PeerLimits:
    """How long a peer may take [s], and on how many seeds of a graph with more than 2,000 nodes peers run."""

    seconds: float = 60.0
    large_seeds: int = 1


def bench(
    graph: PoseGraph,
    seeds: Sequence[int],
    shares: Sequence[float] = SHARES,
    peers: Sequence[str] = tuple(PEERS),
    limits: PeerLimits = PeerLimits(),
) -> Iterator[Row]:
    """Yield a row a method, share and seed; the clean optimum comes from all true closures (LAGO, then LM)."""
    if unknown := [name for name in peers if name not in PEERS]:
        raise TopomapError(f"no method '{unknown[0]}': there are {', '.join(PEERS)}")
    clean = optimum(graph.odometry, graph.odometry_covariance, closures_of(graph))
    drift = ate(odometry_poses(graph), clean)
    _warm_up()
    heard = seeds if graph.nodes <= LARGE else seeds[: limits.large_seeds]
    with PeerProcess(limits.seconds) as process:
        for share in shares:
            for seed in seeds:
                injected = inject(graph, clean, share, np.random.default_rng([seed, round(100 * share)]))
                yield _row(injected, clean, drift, share, seed, OURS, _ours(injected.graph))
                for method in peers if seed in heard else ():
                    run = process.run(method, injected.graph)
                    yield _row(injected, clean, drift, share, seed, method, run)


def _ours(graph: PoseGraph) -> PeerRun:
    begin = time.perf_counter()
    poses, believed = map_graph(graph)
    return PeerRun(poses, believed, time.perf_counter() - begin, False)


def _row(
    injected: Injected, clean: FloatArray, drift: float, share: float, seed: int, method: str, run: PeerRun
) -> Row:
    false = injected.false
    right, wrong = int((run.believed & ~false).sum()), int((run.believed & false).sum())
    return Row(
        graph=injected.graph.name,
        nodes=injected.graph.nodes,
        method=method,
        false_share=share,
        seed=seed,
        true=int((~false).sum()),
        false=int(false.sum()),
        kept_true=right,
        kept_false=wrong,
        precision=right / (right + wrong) if right + wrong else None,
        recall=None if run.stopped else right / max(1, int((~false).sum())),
        ate_m=ate(run.poses, clean) if np.isfinite(run.poses).all() else None,
        odometry_ate_m=drift,
        seconds=run.seconds,
        stopped=run.stopped,
    )


def _warm_up() -> None:
    """Compile the kernels, so that the first row's time is as good as the others'."""
    relative, spread = np.tile([1.0, 0.0, np.pi / 2], (8, 1)), np.tile(np.eye(3) * 1e-2, (8, 1, 1))
    ends = np.array([0, 1, 2, 3, 0])
    claims = np.zeros((5, 3))
    claims[4] = [5.0, 0.0, 0.0]
    map_graph(PoseGraph("", relative, spread, ends, np.array([4, 5, 6, 7, 6]), claims, spread[:5]))


def averages(rows: Sequence[Row]) -> list[dict[str, object]]:
    """Return one line a graph, share and method over the seeds: worst precision, mean and least recall, times."""
    groups: dict[tuple[str, float, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((row.graph, row.false_share, row.method), []).append(row)
    return [_average(key, own) for key, own in groups.items()]


def _average(key: tuple[str, float, str], own: list[Row]) -> dict[str, object]:
    precisions = [row.precision for row in own if row.precision is not None]
    ates = [row.ate_m for row in own if row.ate_m is not None]
    recalls = [row.recall for row in own if row.recall is not None]
    return {
        "graph": key[0],
        "false_share": key[1],
        "method": key[2],
        "runs": len(own),
        "stopped": sum(row.stopped for row in own),
        "precision_min": min(precisions) if precisions else None,
        "kept_false_max": max(row.kept_false for row in own),
        "recall_mean": float(np.mean(recalls)) if recalls else None,
        "recall_min": min(recalls) if recalls else None,
        "ate_m_mean": float(np.mean(ates)) if ates else None,
        "ate_m_max": max(ates) if ates else None,
        "odometry_ate_m": own[0].odometry_ate_m,
        "seconds_mean": float(np.mean([row.seconds for row in own])),
        "seconds_max": max(row.seconds for row in own),
    }


def to_json(rows: Sequence[Row]) -> str:
    """Return all rows and their averages as JSON."""
    return json.dumps({"rows": [asdict(row) for row in rows], "averages": averages(rows)}, indent=1) + "\n"


def to_csv(rows: Sequence[Row]) -> str:
    """Return all rows as CSV with a header."""
    return rows_csv(rows, Row)
