# ruff: noqa: RUF005
"""What each compiled loop of the map makes of a few small numbers: the same as before, compiled or not."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from kept import as_before

from topomap.mapping.closures.agreement_kernels import loop_distance2, short_loops
from topomap.mapping.closures.noise import _fitted
from topomap.mapping.closures.odds import _density, _mahalanobis
from topomap.mapping.odometry.preintegration import accumulate
from topomap.mapping.optimizer import block_kernels
from topomap.mapping.optimizer.block_cholesky import BlockPattern
from topomap.mapping.optimizer.calibration_jacobian import _along as carried_along
from topomap.mapping.optimizer.elimination import COLUMNS, EDGE, STRETCH, _along, _back
from topomap.mapping.optimizer.pose_network import Links
from topomap.mapping.uncertainty.network_kernels import bounds, distances, path_errors, tree_errors
from topomap.mapping.uncertainty.network_search import NEVER, _signposts
from topomap.mapping.uncertainty.path_covariance import best_way, joined_way, seen_from_all
from topomap.mapping.uncertainty.small import distance2, moved_by, relative, seen_from, wrapped

RNG = np.random.default_rng


def spreads(rng: np.random.Generator, count: int, size: float = 0.1) -> np.ndarray:
    """Covariances (count, 3, 3), none diagonal."""
    roots = rng.normal(size=(count, 3, 3)) * size + np.eye(3) * size
    return roots @ roots.transpose(0, 2, 1)


def poses(rng: np.random.Generator, count: int) -> np.ndarray:
    """A way (count, 3) that turns to and fro."""
    heading = np.cumsum(rng.normal(0.2, 0.5, count))
    steps = np.column_stack([np.cos(heading), np.sin(heading)])
    return np.column_stack([np.cumsum(steps, axis=0), np.remainder(heading + math.pi, math.tau) - math.pi])


def chain(seed: int = 0, count: int = 9) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Poses, random (N, 3, 3) and systematic (N, 3, 3) errors along them, and a calibration's covariance (3, 3)."""
    rng = RNG(seed)
    random = np.cumsum(spreads(rng, count, 0.05), axis=0) - spreads(RNG(seed), 1, 0.05)
    systematic = np.cumsum(rng.normal(size=(count, 3, 3)) * 0.2, axis=0)
    return poses(rng, count), random, systematic, spreads(rng, 1, 0.03)[0]


def test_covariances_are_moved_and_measured_as_before() -> None:
    rng, told = RNG(1), list[float]()
    for errors, (x, y, heading) in zip(spreads(rng, 4), rng.normal(size=(4, 3)), strict=True):
        out, moved = np.zeros((3, 3)), np.eye(3)
        seen_from(errors, heading, x, y, out)
        moved_by(errors + np.triu(errors), heading, x, y, moved)
        told += [*out.ravel(), *moved.ravel(), *distance2(errors, x, y, heading, False)]
        told += [*distance2(errors, x, y, heading, True), *relative(out[0], errors[1])]
    told += [wrapped(one) for one in (-math.pi, math.pi, 3.0, -7.0, 9.5, 0.0)]
    as_before("kernels small", {"told": told})


def test_ways_over_closures_are_as_before() -> None:
    where, random, systematic, calibration = chain()
    ends, closures = np.array([[1, 6], [2, 7], [4, 8]]), spreads(RNG(5), 3, 0.02)
    told = [np.zeros(0)]
    for i, j in ((0, 8), (8, 1), (3, 4), (5, 5), (2, 6)):
        x, y = where[j, :2]
        told.append(best_way(random, systematic, calibration, i, j, x, y, ends, closures).ravel())
        told.append(joined_way(random, systematic, calibration, i, j, ends, closures).ravel())
        told.append(joined_way(random, systematic, calibration, i, j, ends[:1], closures[:1]).ravel())
        seen = seen_from_all(random, systematic, calibration, j, x, y, ends, closures, 1e-3)
        told.append(seen.ravel() / 100.0)
    as_before("kernels ways", {"told": np.concatenate(told)})


def network() -> tuple[np.ndarray, ...]:
    """Seven nodes in a row and three closures, as lists of edges by node."""
    rng = RNG(7)
    start, end = np.array([0, 1, 2, 3, 4, 5, 0, 1, 6]), np.array([1, 2, 3, 4, 5, 6, 4, 5, 2])
    at, edge = np.concatenate([start, end]), np.tile(np.arange(9), 2)
    order = np.argsort(at, kind="stable")
    first = np.searchsorted(at[order], np.arange(8))
    random, systematic = spreads(rng, 9, 0.1), rng.normal(size=(9, 3, 3)) * 0.3
    return first, edge[order], start, end, random, systematic, np.array([NEVER] * 6 + [0, 1, 0])


def test_best_paths_are_as_before() -> None:
    edges, unsure, none = network(), spreads(RNG(8), 1, 0.2)[0], np.empty((7, 0))
    i, j = np.array([0, 6, 2, 5, 3, 1, 4]), np.array([6, 0, 5, 0, 3, 6, 2])
    found = {}
    for name, calibration in (("sure", np.zeros((3, 3))), ("unsure", unsure)):
        away = distances(*edges, calibration, np.array([0, 3, 6, 1, 5]))
        random, systematic = tree_errors(*edges, calibration, np.array([0, 4]))
        found[f"{name} distances"] = away
        found[f"{name} trees"] = [random, systematic]
        found[f"{name} bounds"] = bounds(random, systematic, calibration, i, j)
        for skip in (-1, 0, 1):
            told = path_errors(*edges, calibration, none, i, j, np.full(7, skip))
            found[f"{name} without {skip}"] = told
        if name == "sure":
            closed = path_errors(*edges, calibration, away, i, j, np.full(7, -1))
            np.testing.assert_allclose(closed, found["sure without -1"], rtol=1e-9)
    chosen = np.empty(4, np.int64)
    _signposts(RNG(3).random((7, 5)), 2, 6, chosen)
    as_before("kernels paths", {**found, "chosen": chosen})


def test_increments_add_up_as_before() -> None:
    rng = RNG(2)
    deltas = rng.normal(size=(9, 3)) * [0.2, 0.05, 0.4]
    found = accumulate(deltas, spreads(rng, 9, 0.02), np.array([0, 4, 4, 9]), 0.95, 0.07)
    as_before("kernels increments", {str(k): one for k, one in enumerate(found)})


def test_stretches_are_condensed_and_filled_as_before() -> None:
    rng = RNG(4)
    edges = rng.normal(size=(6, EDGE, COLUMNS))
    edges[:, :3, 6:9] = 0.0
    edges[2, 3:], edges[4, 4] = 0.0, 0.0
    kept = np.array([0, 1, 4, 6])
    rows, inner = np.zeros((3, STRETCH, COLUMNS)), np.zeros((7, 3, 13))
    _along(edges, kept, rows, inner)
    steps, calibration = rng.normal(size=(7, 3)), rng.normal(size=3)
    calibration.flags.writeable = False
    _back(kept, inner, steps, calibration)
    carried = np.zeros((5, 3, 3))
    carried_along(
        np.repeat(np.arange(4), 2)[::2],
        np.repeat(np.arange(1, 5), 2)[::2],
        rng.normal(size=(4, 3, 3)),
        rng.normal(size=(4, 3, 3)),
        carried,
    )
    as_before("kernels stretches", {"rows": np.abs(rows), "inner": np.abs(inner), "steps": steps, "carried": carried})


def test_blocks_are_factored_solved_and_inverted_as_a_dense_matrix_is() -> None:
    rng, i, j = RNG(6), np.array([0, 1, 2, 3, 4, 0, 1, 5, 2]), np.array([1, 2, 3, 4, 5, 4, 3, 0, 6])
    nodes = 7
    pattern = BlockPattern(nodes, i, j)
    where = poses(rng, nodes)
    blind = np.array([False, True] * 4 + [False])
    information = np.linalg.inv(spreads(rng, 9, 0.2))
    information[blind] = np.diag([9.0, 9.0, 0.0])
    links = Links(i, j, rng.normal(size=(9, 3)), information, blind)
    weights = np.array([1.0, 0.5, 0.0, 1.0, 2.0, 1.0, -1.0, 1.0, 1.0])
    blocks, right = links.normal_equations(pattern, where, weights)
    for own in pattern.first[:-1]:
        blocks[own] += 0.3 * np.eye(3)
    dense, places = np.zeros((3 * nodes, 3 * nodes)), np.argsort(pattern.place)
    for column in range(nodes):
        for p in range(pattern.first[column], pattern.first[column + 1]):
            row = pattern.rows[p]
            dense[3 * row : 3 * row + 3, 3 * column : 3 * column + 3] = blocks[p]
            dense[3 * column : 3 * column + 3, 3 * row : 3 * row + 3] = blocks[p].T
    kept = blocks.copy()
    assert pattern.factor(blocks)
    solved = pattern.solve(blocks, right)
    np.testing.assert_allclose(solved[places].ravel(), np.linalg.solve(dense, right[places].ravel()), rtol=1e-8)
    inverse, whole = pattern.inverse(blocks), np.linalg.inv(dense)
    for column in range(nodes):
        for p in range(pattern.first[column], pattern.first[column + 1]):
            row = pattern.rows[p]
            expected = whole[3 * row : 3 * row + 3, 3 * column : 3 * column + 3]
            np.testing.assert_allclose(inverse[p], expected, rtol=1e-7, atol=1e-10)
    assert pattern.log_determinant(blocks) == np.linalg.slogdet(dense)[1].round(9) or math.isclose(
        pattern.log_determinant(blocks), np.linalg.slogdet(dense)[1], rel_tol=1e-9
    )
    bad = kept.copy()
    bad[pattern.first[2]] = -np.eye(3)
    assert not pattern.factor(bad)
    missing = block_kernels.found_blocks(pattern.first, pattern.rows, np.array([0, 1]), np.array([6, 5]))
    as_before("kernels blocks", {
        "blocks": kept, "right": right, "chi2": links.chi2(where), "seen": links.seen(where), "missing": missing,
        "known": links.known(pattern, pattern.at, where, inverse), "first": pattern.first, "rows": pattern.rows,
    })  # fmt: skip


def claims() -> tuple[np.ndarray, ...]:
    """Six claims on a chain of places, two of them blind."""
    rng = RNG(9)
    where, random, _, _ = chain(3, 12)
    i, j = np.array([[0, 6], [0, 8], [1, 7], [2, 8], [2, 9], [4, 11]]).T  # strided, as the engine has them
    claimed = rng.normal(size=(6, 3)) * 0.3
    for n in range(6):
        claimed[n] += relative(where[i[n]], where[j[n]])
    blind = np.array([False, False, True, False, True, False])
    return i, j, claimed, spreads(rng, 6, 0.2), blind, where, random


def test_loops_through_claims_miss_as_before() -> None:
    i, j, claimed, covariance, blind, where, random = claims()
    told = [
        min(loop_distance2(i, j, claimed, covariance, blind, where, random, a, b, turned, limit), 1e4)
        for a, b in product(range(6), range(6))
        if a != b
        for turned in (0.0, math.pi)
        for limit in (1e6, 2.0)
    ]
    first = np.searchsorted(i, np.arange(len(where) + 1))
    found = {f"{window} {limit}": short_loops(i, j, claimed, covariance, blind, where, random, first, window, limit,
                                              np.arange(6))
             for window in (1, 2, 5) for limit in (3.0, 1e5)}  # fmt: skip
    many = np.repeat(np.arange(30) // 15, 2)[::2]
    also, even = (5 + np.repeat(many, 2))[::2], np.tile(np.eye(3), (30, 1, 1))
    first = np.array([0, 15] + [30] * 11)
    crowd = short_loops(
        many, also, np.zeros((30, 3)), even, np.zeros(30, bool), where, random, first, 3, 1e6, np.arange(30)
    )
    as_before("kernels loops", {
        "told": told, **{name: np.concatenate(one) for name, one in found.items()}, "many": [len(crowd[0])],
    })  # fmt: skip


def test_claims_are_weighed_as_before() -> None:
    i, j, claimed, covariance, blind, where, _ = claims()
    errors = spreads(RNG(10), 6, 0.1)
    chi2, determinant = _mahalanobis(i, j, claimed, covariance, blind, where, errors)
    stand = np.concatenate([claimed, claimed[::-1] + [0.1, 0.1, 0.0], claimed + [0.0, 0.6, 0.3], claimed + 3.0])
    density = _density(i, j, claimed, covariance, blind, where, errors, stand)
    close = _density(i, j, claimed, covariance, blind, where, errors, claimed + [0.49, 0.0, math.radians(9.9)])
    apart = _density(i, j, claimed, covariance, blind, where, errors, claimed + [0.51, 0.0, math.radians(10.1)])
    as_before("kernels weighed", {"chi2": chi2, "det": determinant, "density": density, "close": close, "apart": apart})


def test_a_mixture_is_fitted_as_before() -> None:
    rng, found = RNG(11), list[float]()
    chi2 = np.concatenate([rng.chisquare(3, 40) * 0.1, rng.chisquare(3, 15) * 40.0, [1e4, 0.0]])
    peak = rng.normal(3.0, 0.5, 57)
    for scale, wide, tails, rounds in ((1.0, 1e3, 4.0, 6), (0.1, 30.0, 16.0, 3), (1e-3, 1.0, 4.0, 25)):
        one = _fitted(chi2, peak, scale, wide, np.array([0.4, 0.2, 0.4]), tails, rounds)
        found += [one[0], one[1], one[2], *one[3], one[4], one[5]]
    as_before("kernels mixture", {"found": found})
