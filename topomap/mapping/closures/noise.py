"""How large a pose graph's noise really is: the files state covariances up to a factor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import chdtri, expit

from topomap.core.arrays import FloatArray
from topomap.core.geometry import between, wrap_all
from topomap.mapping.pose_graph import PoseGraph
from topomap.mapping.uncertainty.agreement import Claims, loops, neighbours
from topomap.mapping.uncertainty.odometry_chain import Chain

WINDOW = 8.0  # both ends of two closures whose loop is heard lie within [m]
LONGEST = 8 * WINDOW  # and a closure's own loop with odometry is at most so long [m]
STARTS = (1.0, 1e-1, 1e-2, 1e-3, 1e-4)
ROUNDS, FEWEST = 30, 10
SHARE = (
    0.99  # of the true loops, to the limit of a closure that fits; more than their mean square where tails are heavy
)


def rescaled(graph: PoseGraph, factor: float) -> PoseGraph:
    """Return the graph with all its covariances times a factor; its optimum stays the same."""
    return replace(graph, covariance=factor * graph.covariance, odometry_covariance=factor * graph.odometry_covariance)


def variance_factor(graph: PoseGraph, chain: Chain, volume: float) -> float:
    """Return the factor, at most 1, by which the stated covariances are too large (the variance of unit weight).

    Short loops, through two neighbouring closures and odometry or through one and odometry, miss of closing by the
    noise if they are true and by anything in the volume [m^2 rad] if one is false: a mixture of the two is fitted
    (expectation and maximisation) from several starts. With fewer than 10 true loops the statement stands: 1.
    """
    gap, spread = _short_loops(graph, chain)
    chi2 = (gap * np.linalg.solve(spread, gap[:, :, None])[:, :, 0]).sum(axis=1)
    peak = -0.5 * np.linalg.slogdet(spread)[1] - 1.5 * np.log(2 * np.pi) + np.log(volume)
    fits = [_mixture(chi2, peak, start) for start in STARTS] if len(chi2) >= FEWEST else []
    _, factor, true = max(fits, default=(0.0, 1.0, 0.0))
    return min(1.0, factor) if true >= FEWEST else 1.0


def _short_loops(graph: PoseGraph, chain: Chain) -> tuple[FloatArray, FloatArray]:
    """Return what the loops (n,) miss of closing (n, 3) and its covariance (n, 3, 3)."""
    claims = Claims(graph.i, graph.j, graph.relative, np.zeros(len(graph.i), bool), np.ones(len(graph.i)))
    a, b = neighbours(claims, chain.travelled, WINDOW)
    gap, spread = loops(graph.relative, graph.covariance, graph.i, graph.j, chain, a, b)
    short = chain.path(graph.i, graph.j) <= LONGEST
    i, j = graph.i[short], graph.j[short]
    own = between(chain.poses[i], chain.poses[j]) - graph.relative[short]
    own[:, 2] = wrap_all(own[:, 2])
    return np.concatenate([gap, own]), np.concatenate([spread, chain.covariance(i, j) + graph.covariance[short]])


def _mixture(chi2: FloatArray, peak: FloatArray, factor: float) -> tuple[float, float, float]:
    """Return log likelihood, factor and number of true loops; chi2, peak (n,): log density at 0 over the false one."""
    order, true, likelihood = np.argsort(chi2), 0.5, -np.inf
    weight = np.zeros(len(chi2))
    for _ in range(ROUNDS):
        density = peak - 1.5 * np.log(factor) - chi2 / (2 * factor)
        likelihood = float(np.logaddexp(np.log(true) + density, np.log1p(-true)).sum())
        weight = expit(np.log(true) - np.log1p(-true) + density)
        true = float(np.clip(weight.mean(), 1e-6, 1 - 1e-6))
        total = np.cumsum(weight[order])
        last = min(int(np.searchsorted(total, SHARE * total[-1])), len(order) - 1)
        factor = max(float(chi2[order][last]) / float(chdtri(3, 1 - SHARE)), 1e-12)
    return likelihood, factor, float(weight.sum())
