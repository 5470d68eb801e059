"""What the appendix proves, by numbers: Jacobians of moments, vectors of cylinders, fields without distances."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU
from topomap.vision.homing.moment import Moment
from topomap.vision.homing.run_down import FIELDS

LANDMARKS = np.random.default_rng(7).uniform(-3.0, 3.0, (9, 2))
COLOURS = np.random.default_rng(8).uniform(0.2, 1.0, 9)
PLACES = [(0.0, 0.0), (0.6, -0.4), (-1.1, 0.9), (1.5, 1.2)]


def gradient(at: FloatArray, n: float) -> FloatArray:
    """The gradient of M_n = sum C |p - a|^n."""
    away = at - LANDMARKS
    return (COLOURS * n * np.hypot(*away.T) ** (n - 2)) @ away


def jacobian(field: Callable[[FloatArray], FloatArray], at: FloatArray) -> FloatArray:
    step = 1e-5
    columns = [(field(at + step * e) - field(at - step * e)) / (2 * step) for e in np.eye(2)]
    return np.column_stack(columns)


def printed_determinant(at: FloatArray, n: float) -> float:
    """(A.9), (A.10) with alpha_i = n C_i r_i^(n - 4), written out pair by pair."""
    x, y = (at - LANDMARKS).T
    alpha = n * COLOURS * np.hypot(x, y) ** (n - 4)
    total = float(((n - 1) * alpha**2 * (x**2 + y**2) ** 2).sum())
    for i in range(len(alpha)):
        for j in range(i + 1, len(alpha)):
            cross, dot = x[i] * y[j] - x[j] * y[i], x[i] * x[j] + y[i] * y[j]
            total += alpha[i] * alpha[j] * (((n - 1) ** 2 + 1) * cross**2 + 2 * (n - 1) * dot**2)
    return total


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("n", [1.0, 1.5, 2.0, 3.0, 4.0])
def test_the_moments_determinant_is_as_printed_and_positive(n: float, place: tuple[float, float]) -> None:
    """(A.10), (A.11): for n >= 1 the potential is convex, so that it has one minimum and no other place of rest."""
    at = np.array(place)
    found = jacobian(lambda p: gradient(p, n), at)
    assert np.linalg.det(found) == pytest.approx(printed_determinant(at, n), rel=1e-4)
    assert np.linalg.det(found) > 0.0
    assert found[0, 0] > 0.0
    assert found[1, 1] > 0.0


def test_below_order_one_the_potential_is_not_convex_everywhere() -> None:
    """(A.11): for 0 < n < 1 it need not be; for n < 0 a landmark pushes away, but M_xx < 0, as printed, holds across
    the line of sight only: the Laplacian n^2 r^(n - 2) is positive.
    """
    assert min(np.linalg.eigvalsh(jacobian(lambda p: gradient(p, 0.5), np.array((0.3, 0.2))))) < 0.0
    beside = LANDMARKS[0] + (0.2, 0.0)
    assert -gradient(beside, -1.0)[0] > 0.0
    bend = jacobian(lambda p: gradient(p, -1.0), beside)
    assert bend[1, 1] < 0.0 < bend[0, 0]
    assert np.trace(bend) > 0.0


@pytest.mark.parametrize("distance", [1.0, 2.0, 5.0])
@pytest.mark.parametrize("radius", [0.1, 0.4])
def test_a_cylinders_pixels_add_up_to_twice_its_radius_over_its_distance(radius: float, distance: float) -> None:
    """(A.13), (A.14): the unit vectors to a cylinder's pixels sum to 2 R / r towards its centre, per radian."""
    width = 72_000
    angles = np.arange(width) * TAU / width
    half = math.asin(radius / distance)
    seen = np.abs(np.angle(np.exp(1j * (angles - 0.7)))) <= half
    vector = np.array([np.cos(angles[seen]).sum(), np.sin(angles[seen]).sum()]) * TAU / width
    assert math.hypot(*vector) == pytest.approx(2 * radius / distance, rel=1e-3)
    assert math.atan2(vector[1], vector[0]) == pytest.approx(0.7, abs=1e-3)


def cylinders(x: float, y: float, width: int = 7200) -> tuple[FloatArray, FloatArray]:
    """Distances (W,) to the surfaces of four cylinders seen from a place, 0 where there is none, and their colour."""
    angles = np.arange(width) * TAU / width
    metres, colour = np.zeros(width), np.zeros(width)
    for k, (a, b) in enumerate(((3.0, 1.0), (-2.0, 3.0), (-3.0, -2.0), (1.0, -3.5))):
        away = math.hypot(a - x, b - y)
        near = np.abs(np.angle(np.exp(1j * (angles - math.atan2(b - y, a - x))))) <= math.asin(0.25 / away)
        metres[near], colour[near] = away, 0.4 + 0.2 * k
    return metres, colour


def test_the_square_of_the_distance_makes_pixels_of_cylinders_points() -> None:
    """(A.15), (A.20): pixel-wise, r^2 u sums to R r towards each centre, so the difference is the metric way home."""
    moment = Moment(2.0, "grey", "pixel")
    (here, colour), (there, goal_colour) = cylinders(0.5, -0.3), cylinders(0.0, 0.0)
    found = moment.vector(here, colour[np.newaxis]) - moment.vector(there, goal_colour[np.newaxis])
    # m = 3: 3 sum r^2 C u / W, over 2 R/r pixels per radian: 3/(2 pi) sum 2 R r C u
    scale = 3.0 / TAU * 2 * 0.25 * sum(0.4 + 0.2 * k for k in range(4))
    np.testing.assert_allclose(found / scale, (-0.5, 0.3), rtol=0.02)


def colour_only(at: FloatArray) -> FloatArray:
    """(A.31): what pixels tell without distances, sum C/r^2 (a - p), relative to home at (0, 0)."""
    away, home = LANDMARKS - at, LANDMARKS
    return (COLOURS / (away**2).sum(axis=1)) @ away - (COLOURS / (home**2).sum(axis=1)) @ home


def test_without_distances_the_field_is_a_saddle_and_two_of_four_home() -> None:
    """(A.33), (A.37): det of the plain field is -(M_xx^2 + M_xy^2); reflected it is positive, and of each pair one
    attracts.
    """
    plain = jacobian(colour_only, np.zeros(2))
    assert np.linalg.det(plain) < 0.0
    reflected = [np.array(field).reshape(2, 2) @ plain for field in FIELDS]
    for one, other in ((0, 1), (2, 3)):
        assert np.linalg.det(reflected[one]) == pytest.approx(-np.linalg.det(plain))
        np.testing.assert_allclose(reflected[one], -reflected[other])
    homing = [k for k, j in enumerate(reflected) if max(np.linalg.eigvals(j).real) < 0.0]
    assert len(homing) == 2
    assert {k // 2 for k in homing} == {0, 1}


@pytest.mark.parametrize("place", PLACES)
def test_with_distances_the_field_of_pixels_converges(place: tuple[float, float]) -> None:
    """(A.25), (A.26): sum R C (a - p)/r has det = sum over pairs of cross^2/(r_i r_j)^3 > 0, weights of one."""
    at = np.array(place)

    def field(p: FloatArray) -> FloatArray:
        away = p - LANDMARKS
        return (1.0 / np.hypot(*away.T)) @ away

    x, y = (at - LANDMARKS).T
    r = np.hypot(x, y)
    pairs = sum((x[i] * y[j] - x[j] * y[i]) ** 2 / (r[i] * r[j]) ** 3 for j in range(len(r)) for i in range(j))
    assert np.linalg.det(jacobian(field, at)) == pytest.approx(pairs, rel=1e-4)
    assert pairs > 0.0
