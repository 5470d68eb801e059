"""The solver of pose graphs without systematic errors: against dense algebra, and against the general solver."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lapped import lapped

from topomap.core.arrays import FloatArray
from topomap.core.errors import TopomapError
from topomap.mapping.closures.drive import HELD
from topomap.mapping.closures.working_map import CLOSING, GROWING
from topomap.mapping.optimizer import HeldSolver, Problem, solve
from topomap.mapping.optimizer.block_cholesky import BlockPattern


def _matrix(nodes: int, edges: int, seed: int) -> tuple[BlockPattern, FloatArray, FloatArray]:
    """A positive definite matrix over a random graph, as blocks and as it is."""
    rng = np.random.default_rng(seed)
    pairs = np.array([rng.choice(nodes, 2, replace=False) for _ in range(edges)])
    pattern = BlockPattern(nodes, pairs[:, 0], pairs[:, 1])
    blocks, dense = pattern.blocks(), np.zeros((3 * nodes, 3 * nodes))
    for (i, j), at in zip(pairs.tolist(), pattern.at.tolist(), strict=True):
        a = rng.normal(size=(3, 6))
        part = a.T @ a + 0.1 * np.eye(6)
        rows = np.concatenate([3 * i + np.arange(3), 3 * j + np.arange(3)])
        dense[np.ix_(rows, rows)] += part
        blocks[pattern.first[pattern.place[i]]] += part[:3, :3]
        blocks[pattern.first[pattern.place[j]]] += part[3:, 3:]
        blocks[at] += part[:3, 3:] if pattern.place[i] > pattern.place[j] else part[3:, :3]
    dense += np.eye(3 * nodes)
    blocks[pattern.first[:-1]] += np.eye(3)
    return pattern, blocks, dense


@pytest.mark.parametrize(("nodes", "edges", "seed"), [(2, 1, 0), (30, 40, 1), (60, 400, 2), (40, 10, 3)])
def test_the_factor_solves_as_dense_algebra_does(nodes: int, edges: int, seed: int) -> None:
    pattern, blocks, dense = _matrix(nodes, edges, seed)
    right = np.random.default_rng(seed).normal(size=(nodes, 3))
    assert pattern.factor(blocks)
    assert pattern.solve(blocks, right).ravel() == pytest.approx(np.linalg.solve(dense, right.ravel()), abs=1e-9)
    assert pattern.log_determinant(blocks) == pytest.approx(np.linalg.slogdet(dense)[1])


def test_the_inverse_is_that_of_dense_algebra_where_the_factor_has_blocks() -> None:
    pattern, blocks, dense = _matrix(40, 120, 4)
    assert pattern.factor(blocks)
    inverse, expected = pattern.inverse(blocks), np.linalg.inv(dense)
    node = np.argsort(pattern.place)
    for column in range(40):
        for at in range(pattern.first[column], pattern.first[column + 1]):
            rows, columns = 3 * node[pattern.rows[at]] + np.arange(3), 3 * node[column] + np.arange(3)
            assert inverse[at] == pytest.approx(expected[np.ix_(rows, columns)], abs=1e-9)


def test_a_pattern_is_taken_over_where_it_has_a_block_for_every_edge() -> None:
    pattern = BlockPattern(5, np.array([0, 1, 2, 3, 0]), np.array([1, 2, 3, 4, 3]))
    fewer = pattern.joining(np.array([3, 0]), np.array([4, 3]))
    assert fewer is not None
    assert fewer.at.tolist() == [pattern.at[3], pattern.at[4]]
    assert pattern.at.tolist() == pattern.joining(np.array([1, 2, 3, 4, 3]), np.array([0, 1, 2, 3, 0])).at.tolist()
    lacking = [pattern.joining(np.array([a]), np.array([b])) is None for a in range(5) for b in range(a)]
    assert any(lacking)
    assert not all(lacking)


def test_a_solve_that_is_asked_for_again_is_not_made_again() -> None:
    drive, claims, _ = lapped(laps=3).engine_input()
    solver, closures = drive.solver, claims.closures()
    first = solver.solve(drive.poses, closures, CLOSING)
    assert solver.solve(drive.poses, claims[:].closures(), CLOSING) is first
    assert solver.solve(first.poses, closures, CLOSING) is not first
    assert solver.solve(first.poses, closures, GROWING) is not solver.solve(first.poses, closures, CLOSING)
    some = solver.solve(drive.poses, closures[:-3], CLOSING)
    assert len(some.inlier) == len(closures) - 3
    moved = replace(closures, relative=closures.relative + 0.1)
    assert not moved.same(closures)


def test_a_matrix_that_is_not_positive_definite_has_no_factor() -> None:
    pattern, blocks, _ = _matrix(10, 20, 0)
    blocks[pattern.first[4]] -= 100 * np.eye(3)
    assert not pattern.factor(blocks)


@pytest.mark.parametrize("blind", [False, True])
def test_it_ends_where_the_general_solver_ends(blind: bool) -> None:
    drive, claims, _ = lapped(laps=3).engine_input()
    if blind:
        claims.covariance[::2, 2, 2] = 100.0
    problem = Problem(drive.poses, drive.edges, claims.closures(), prior_sigmas=HELD)
    general = solve(problem, CLOSING)
    ended = drive.solver.solve(drive.poses, claims.closures(), CLOSING)
    assert ended.inlier.tolist() == (general.closure_weights > 0).tolist()
    assert ended.poses == pytest.approx(general.poses, abs=2e-3)


def test_the_same_closures_reordered_end_in_the_same_place() -> None:
    drive, claims, _ = lapped(laps=3).engine_input()
    solver = HeldSolver(drive.edges, drive.prior)
    one = solver.solve(drive.poses, claims.closures(), CLOSING)
    back = np.arange(len(claims))[::-1]
    other = solver.solve(drive.poses, claims[back].closures(), CLOSING)
    assert other.poses == pytest.approx(one.poses, abs=1e-9)
    assert other.inlier[back].tolist() == one.inlier.tolist()


def test_an_odometry_that_says_nothing_is_undetermined() -> None:
    drive, claims, _ = lapped(laps=3).engine_input()
    drive.solver.odometry.information[5] = 0.0
    with pytest.raises(TopomapError, match="isn't determined"):
        drive.solver.solve(drive.poses, claims[:0].closures(), CLOSING)
