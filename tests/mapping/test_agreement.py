"""Agreement among closures: true neighbours agree, false ones don't."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import between
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements, Increments
from topomap.mapping.uncertainty.agreement import Agreeing, company, support
from topomap.mapping.uncertainty.agreement import SupportSettings as Settings
from topomap.mapping.uncertainty.odometry_chain import Chain

N = 60


def two_passes() -> tuple[Chain, np.ndarray, np.ndarray, FloatArray]:
    """A drive out and back along a line: each node of the way back meets one of the way out, looking back."""
    deltas = np.tile([1.0, 0.0, 0.0], (N - 1, 1))
    deltas[N // 2 - 1] = [0.0, 0.0, np.pi]
    spread = np.tile(np.diag([0.02, 0.02, 0.01]) ** 2, (N - 1, 1, 1))
    edges = [Increments(np.array([k]), deltas[k : k + 1], spread[k : k + 1]) for k in range(N - 1)]
    whole = EdgeIncrements.of(edges).integrate(Calibration())
    poses = np.zeros((N, 3))
    poses[: N // 2, 0] = np.arange(N // 2)
    poses[N // 2 :, 0] = np.arange(N // 2)[::-1]
    poses[N // 2 :, 2] = np.pi
    i = np.arange(2, 12)
    j = N - 1 - i
    return Chain.of(poses, whole, Calibration(), np.zeros((3, 3))), i, j, between(poses[i], poses[j])


def test_company_counts_all_and_support_the_agreeing() -> None:
    chain, i, j, relative = two_passes()
    relative = relative.copy()
    relative[0, 0] += 20.0
    claims = Agreeing(i, j, relative, np.zeros(len(i), bool), np.ones(len(i)))
    around = company(claims, chain.travelled, 3.0)
    agreed = support(claims, chain.poses, chain.travelled, Settings(window=3.0))
    assert around[0] == 3
    assert agreed[0] == 0
    assert (agreed <= around).all()
    assert agreed[5] == around[5] == 6
