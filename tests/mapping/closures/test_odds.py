"""Log odds of a claim: how densely true ones lie about the map, and how densely false ones do."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import between, wrap_all
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.odds import (
    FURTHEST,
    NEAREST,
    PAIRS,
    SPREAD,
    TAILS,
    log_chance,
    log_crowding,
    log_density,
    mahalanobis,
)

NO, YES = np.zeros(1, bool), np.ones(1, bool)
ANY_HEADING = 40.0


def density(chi2: float, determinant: float, blind: BoolArray) -> float:
    return float(np.exp(log_density(np.array([chi2]), np.array([determinant]), blind))[0])


def claim(relative: FloatArray, sigmas: tuple[float, float, float], i: int = 0, j: int = 1) -> Claims:
    return Claims.of(np.array([i]), np.array([j]), np.array([relative], float), np.diag(np.square(sigmas))[None])


@pytest.mark.parametrize("determinant", [1e-8, 1.0, 50.0])
def test_true_claims_have_a_density_of_one_in_all(determinant: float) -> None:
    """In shells of Mahalanobis distance r: a ball's surface in 3 dof and a circle in 2, stretched by the root."""
    root = np.sqrt(determinant)
    ball = quad(lambda r: 4 * np.pi * r**2 * root * density(r**2, determinant, NO), 0, np.inf)[0]
    circle = quad(lambda r: 2 * np.pi * r * root * density(r**2, determinant, YES), 0, np.inf)[0]
    assert (ball, circle) == pytest.approx((1.0, 1.0), abs=1e-6)


def test_tails_are_heavy() -> None:
    """Beyond 5 sigmas in one direction lies one true claim in 150 and not one in two million."""
    assert TAILS == 4.0
    marginal = quad(lambda x: 2 * (1 + x**2 / TAILS) ** (-(TAILS + 1) / 2), 5, np.inf)[0]
    whole = quad(lambda x: (1 + x**2 / TAILS) ** (-(TAILS + 1) / 2), -np.inf, np.inf)[0]
    assert marginal / whole == pytest.approx(0.0075, abs=0.0002)
    ratio = density(25.0, 1.0, NO) / density(0.0, 1.0, NO)
    assert ratio == pytest.approx((1 + 25 / 4) ** -3.5)
    assert ratio > 1000 * np.exp(-12.5) / 4


def test_false_claims_are_even_over_the_area_and_all_headings() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [30.0, 5.0, 1.0], [10.0, 20.0, -3.0]])
    both = log_chance(poses, np.array([False, True]))
    assert both == pytest.approx([-np.log(30 * 20 * 2 * np.pi), -np.log(30 * 20)])
    line = poses * [1.0, 0.0, 1.0]
    assert log_chance(line, NO) == pytest.approx(-np.log(30 * 2 * np.pi))  # no drive is narrower than 1 m
    assert log_chance(np.zeros((1, 3)), YES) == pytest.approx(0.0)


@pytest.mark.parametrize("seed", range(5))
def test_distances_are_from_the_map_in_its_errors_and_the_claims(seed: int) -> None:
    rng = np.random.default_rng(seed)
    poses = rng.normal(scale=5.0, size=(12, 3))
    i, j = rng.integers(0, 12, (2, 6))
    root = rng.normal(size=(2, 6, 3, 3))
    errors, own = root @ root.transpose(0, 1, 3, 2) + 0.1 * np.eye(3)
    own *= 0.05  # less than what is called an unknown heading
    own[3:, 2, 2] += ANY_HEADING
    claims = Claims.of(i, j, rng.normal(scale=3.0, size=(6, 3)), own)
    chi2, determinant = mahalanobis(claims, poses, errors)
    off = between(poses[i], poses[j]) - claims.relative
    off[:, 2] = wrap_all(off[:, 2])
    for n in range(6):
        c, s = np.cos(poses[i[n], 2]), np.sin(poses[i[n], 2])
        x, y = poses[j[n], :2]
        by = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) @ np.array([[1, 0, -y], [0, 1, x], [0, 0, 1]])
        dof = 2 if n >= 3 else 3
        spread = (by @ errors[n] @ by.T + own[n])[:dof, :dof]
        assert chi2[n] == pytest.approx(off[n, :dof] @ np.linalg.solve(spread, off[n, :dof]), rel=1e-8)
        assert determinant[n] == pytest.approx(np.linalg.det(spread), rel=1e-8)


def lattice(count: int = 400, seed: int = 0) -> FloatArray:
    """Poses on a lattice of 1 m, all in one heading."""
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.integers(0, 20, (count, 2)), np.zeros(count)]).astype(float)


def scattered(count: int = 400, seed: int = 0) -> FloatArray:
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(0, 20, (count, 2)), rng.uniform(-np.pi, np.pi, count)])


def crowding(poses: FloatArray, one: Claims, sigma: float = 0.0) -> float:
    return float(log_crowding(one, poses, np.diag([sigma, sigma, 0.0])[None] ** 2)[0])


def all_pairs(poses: FloatArray) -> tuple[IntArray, IntArray]:
    low, high = np.triu_indices(len(poses), NEAREST)
    return low, high


def slow_crowding(poses: FloatArray, one: Claims) -> float:
    """The same from every pair of places and not from some drawn."""
    low, high = all_pairs(poses)
    off = between(poses[low], poses[high]) - one.relative
    off[:, 2] = wrap_all(off[:, 2])
    dof = 2 if one.blind[0] else 3
    close = np.hypot(off[:, 0], off[:, 1]) <= 0.5
    if dof == 3:
        close &= np.abs(off[:, 2]) <= np.deg2rad(10)
    spread = one.covariance[0][:dof, :dof]
    chi2 = (off[:, :dof] @ np.linalg.inv(spread) * off[:, :dof]).sum(axis=1)
    falls = np.where(close, 0.0, np.exp(-chi2 / 2)) / np.sqrt(np.linalg.det(2 * np.pi * spread))
    return max(0.0, float(np.log(falls.mean()) - log_chance(poses, one.blind)[0]))


@pytest.mark.parametrize("sigmas", [(1.5, 1.5, 0.3), (2.0, 1.0, 0.9), (1.5, 1.5, 6.0)])
@pytest.mark.parametrize("make", [lattice, scattered])
def test_some_pairs_of_places_tell_what_all_of_them_would(make: type, sigmas: tuple[float, float, float]) -> None:
    poses = make()
    one = claim(np.array([2.3, -1.4, 0.1]), sigmas)
    assert crowding(poses, one) == pytest.approx(slow_crowding(poses, one), abs=0.25)


def test_on_a_lattice_false_claims_fit_more_often_than_among_places_that_are_scattered() -> None:
    one = claim(np.zeros(3), (1.5, 1.5, 0.1))
    assert crowding(lattice(), one) > np.log(10)
    assert crowding(scattered(), one) < np.log(4)


def test_who_stands_just_as_claimed_counts_for_nothing_as_it_would_make_the_claim_true() -> None:
    poses = lattice()
    sharp = (0.1, 0.1, 0.1)
    assert crowding(poses, claim(np.zeros(3), sharp)) == 0.0  # the next place of the lattice is 10 sigmas away
    within, beyond = (crowding(poses, claim(np.array([x, 0.0, 0.0]), (0.2, 0.2, 0.1))) for x in (0.49, 0.51))
    assert within > 0.5  # 2.5 sigmas from 1, 0
    assert beyond > within + 0.2  # and from 0, 0, too
    assert crowding(poses, claim(np.array([0.0, 0.0, np.deg2rad(9.5)]), sharp)) == 0.0
    assert crowding(poses, claim(np.array([0.0, 0.0, np.deg2rad(10.5)]), sharp)) > np.log(10)


def test_without_a_heading_all_who_stand_there_would_make_it_true() -> None:
    poses = scattered()
    poses[:, :2] = lattice()[:, :2]
    poses[:, 2] = np.random.default_rng(0).integers(0, 4, len(poses)) * np.pi / 2
    turned = claim(np.array([0.0, 0.0, 0.0]), (0.1, 0.1, 6.0))
    assert turned.blind[0]
    assert crowding(poses, turned) == 0.0
    assert crowding(poses, claim(np.array([0.0, 0.0, np.pi / 4]), (0.1, 0.1, 0.9))) > 0.0


def test_the_maps_own_errors_blur_what_is_claimed() -> None:
    """Alone the claim reaches no other place of the lattice; with the map unsure by a metre it does."""
    sharp = claim(np.zeros(3), (0.1, 0.1, 0.1))
    assert crowding(lattice(), sharp, 1.5) == pytest.approx(
        crowding(lattice(), claim(np.zeros(3), (1.5, 1.5, 0.1))), 0.05
    )


def test_crowding_never_speaks_for_a_claim() -> None:
    outside = claim(np.array([200.0, 0.0, 0.0]), (0.5, 0.5, 0.1))
    assert crowding(scattered(), outside) == 0.0


def test_places_less_than_ten_apart_on_the_way_are_no_pair() -> None:
    """On a line in steps of 1 m: who is 8 m on is 8 places on, who is 12 m on is a false claim's end."""
    assert NEAREST == 10
    line = np.column_stack([np.arange(400.0), np.zeros(400), np.zeros(400)])
    sigmas = (0.3, 0.1, 0.1)
    assert crowding(line, claim(np.array([8.6, 0.0, 0.0]), sigmas)) == 0.0
    assert crowding(line, claim(np.array([12.6, 0.0, 0.0]), sigmas)) > 1.0
    assert crowding(np.zeros((NEAREST, 3)), claim(np.array([2.0, 0.0, 0.0]), (1.0, 1.0, 0.1))) == 0.0  # no pair at all


def test_pairs_are_drawn_evenly_and_are_always_the_same() -> None:
    drawn = np.outer(np.arange(1, PAIRS + 1), SPREAD) % 1.0
    counts = np.histogram2d(*drawn.T, bins=10, range=[[0, 1], [0, 1]])[0]
    assert counts.min() > 0.8 * PAIRS / 100
    one = claim(np.zeros(3), (1.5, 1.5, 0.1))
    assert crowding(lattice(), one) == crowding(lattice(), one)
    assert log_crowding(one[:0], lattice(), np.zeros((0, 3, 3))).shape == (0,)


def test_pairs_beyond_seven_sigmas_count_for_nothing() -> None:
    assert FURTHEST == 50.0
    near = np.vstack([np.zeros((200, 3)), np.tile([6.9, 0.0, 0.0], (200, 1))])
    away = np.vstack([np.zeros((200, 3)), np.tile([7.2, 0.0, 0.0], (200, 1))])
    one = claim(np.zeros(3), (1.0, 1e-3, 1e-3))  # so sharp that even e^-24 of it is more than an even density
    assert crowding(near, one) == 0.0 == crowding(away, one)
    errors = np.zeros((1, 3, 3))
    thin = claim(np.zeros(3), (1.0, 1e-6, 1e-6))
    assert log_crowding(thin, near, errors)[0] > 0.0
    assert log_crowding(thin, away, errors)[0] == 0.0
