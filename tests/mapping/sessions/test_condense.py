"""One increment an edge leads where all of them led, and is as uncertain."""

from __future__ import annotations

import numpy as np
from maps import square

from topomap.mapping.mapfile import to_bytes
from topomap.mapping.odometry.increments import Calibration, Increments, integrate
from topomap.mapping.sessions.condense import condense, condensed

OWN = Calibration(1.04, 0.003, 0.95)


def wild(count: int = 30, seed: int = 0) -> Increments:
    rng = np.random.default_rng(seed)
    deltas = rng.normal([0.1, 0.0, 0.05], [0.02, 0.01, 0.2], (count, 3))
    spread = rng.normal(size=(count, 3, 3)) * 1e-3
    return Increments(np.arange(count) + 1, deltas, spread @ spread.transpose(0, 2, 1))


def test_pose_and_covariance_are_those_of_all_increments() -> None:
    before, after = integrate(wild(), OWN), integrate(condensed(wild(), OWN), OWN)
    assert np.allclose(after[0], before[0], atol=1e-12)
    assert np.allclose(after[1], before[1], atol=1e-12)


def test_another_calibration_moves_it_almost_alike() -> None:
    near = Calibration(1.05, 0.005, 0.95)
    edge = wild(8)
    moved = integrate(edge, near)[0] - integrate(edge, OWN)[0]
    as_one = integrate(condensed(edge, OWN), near)[0] - integrate(condensed(edge, OWN), OWN)[0]
    assert np.hypot(*moved[:2]) > 1e-3
    assert np.allclose(as_one, moved, atol=0.2 * np.abs(moved).max())


def test_a_condensed_map_is_smaller_and_its_nodes_stay() -> None:
    topo, size = square(), len(to_bytes(square()))
    condense(topo)
    assert len(to_bytes(topo)) < size
    assert topo.poses.tolist() == square().poses.tolist()
    assert np.allclose(topo.trajectory()[1][-1], square().trajectory()[1][-1], atol=1e-9)
    assert all(len(increments) == 1 for _, _, increments in topo.odometry_edges())
