"""What became of a pose graph: its closures' verdicts, how well the poses fit, and both in numbers."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import between, wrap_all
from topomap.core.records import Verdict
from topomap.evaluation.summary_table import Summary
from topomap.evaluation.trajectory import ate, travel
from topomap.mapping.graph_engine import GraphVerdicts
from topomap.mapping.pose_graph import PoseGraph


@dataclass(frozen=True, slots=True)
class VerdictRow:
    """One closure of a pose graph under the ids of its file, i < j; log_odds is None where nothing was worked out."""

    i: int
    j: int
    verdict: Verdict
    log_odds: float | None
    reason: str


@dataclass(frozen=True, slots=True)
class GraphFit:
    """Squared errors of what stands, each by its covariance: at the optimised poses the odometry's and the accepted
    closures', at dead reckoning's poses the accepted closures' (its odometry has none); degrees of freedom."""

    odometry: float
    closures: float
    before: float
    freedom: int


def verdict_rows(graph: PoseGraph, verdicts: GraphVerdicts) -> list[VerdictRow]:
    """Return a row a closure, in the order of the file."""
    ends = zip(graph.names[graph.i].tolist(), graph.names[graph.j].tolist(), strict=True)
    told = zip(verdicts.inlier.tolist(), verdicts.log_odds.tolist(), verdicts.reason, strict=True)
    return [
        VerdictRow(i, j, Verdict.ACCEPTED if good else Verdict.REFUSED, odds if np.isfinite(odds) else None, reason)
        for (i, j), (good, odds, reason) in zip(ends, told, strict=True)
    ]


def graph_fit(graph: PoseGraph, verdicts: GraphVerdicts) -> GraphFit:
    """Return how well the poses fit odometry and accepted closures."""
    steps, kept = np.flatnonzero(~graph.gaps), verdicts.inlier
    odometry = (steps, steps + 1, graph.odometry[steps], graph.odometry_covariance[steps])
    closures = (graph.i[kept], graph.j[kept], graph.relative[kept], graph.covariance[kept])
    freedom = 3 * (len(steps) + int(kept.sum())) - 3 * (graph.nodes - 1)
    return GraphFit(
        odometry=_chi2(verdicts.poses, *odometry),
        closures=_chi2(verdicts.poses, *closures),
        before=_chi2(graph.dead_reckoning(), *closures),
        freedom=max(0, freedom),
    )


def _chi2(poses: FloatArray, i: IntArray, j: IntArray, relative: FloatArray, covariance: FloatArray) -> float:
    missed = between(poses[i], poses[j]) - relative
    missed[:, 2] = wrap_all(missed[:, 2])
    return float((missed * np.linalg.solve(covariance, missed[:, :, None])[:, :, 0]).sum())


def graph_summary(graph: PoseGraph, verdicts: GraphVerdicts, seconds: float) -> Summary:
    """Return an optimised pose graph in numbers, as plain JSON values; seconds: what the engine took."""
    fit, accepted, reckoned = graph_fit(graph, verdicts), int(verdicts.inlier.sum()), graph.dead_reckoning()
    return {
        "graph": graph.name,
        "poses": graph.nodes,
        "chains": 1 + int(graph.gaps.sum()),
        "odometry_edges": int((~graph.gaps).sum()),
        "travelled_m": float(travel(verdicts.poses)[-1]),
        "closures": {"offered": len(graph.i), "accepted": accepted, "refused": len(graph.i) - accepted},
        "reasons": dict(Counter(verdicts.reason).most_common()),
        "chi2": {
            "odometry": fit.odometry,
            "closures": fit.closures,
            "closures_at_dead_reckoning": fit.before,
            "degrees_of_freedom": fit.freedom,
        },
        "moved_m": ate(verdicts.poses, reckoned),
        "kept": verdicts.kept,
        "seconds": seconds,
    }


def graph_rows(graph: PoseGraph, verdicts: GraphVerdicts, seconds: float) -> list[tuple[str, str]]:
    """Return label and value of each row of the small table for people."""
    fit, accepted = graph_fit(graph, verdicts), int(verdicts.inlier.sum())
    chains = 1 + int(graph.gaps.sum())
    moved = ate(verdicts.poses, graph.dead_reckoning())
    return [
        ("graph", f"{graph.name}: {graph.nodes} poses, {'one chain' if chains == 1 else f'{chains} chains'}"),
        ("closures", f"{accepted} of {len(graph.i)} accepted, {len(graph.i) - accepted} refused"),
        ("solution kept", verdicts.kept),
        ("chi-squared", f"{fit.odometry + fit.closures:.1f} at {fit.freedom} degrees of freedom"),
        ("accepted closures alone", f"{fit.closures:.1f}, by dead reckoning {fit.before:.4g}"),
        ("moved from dead reckoning", f"{moved:.3f} m (rms, aligned)"),
        ("time", f"{seconds:.2f} s"),
    ]
