"""The compiled 3 x 3 algebra is numpy's."""

from __future__ import annotations

import numpy as np
import pytest

from topomap.core.arrays import FloatArray
from topomap.core.geometry import between, wrap_all
from topomap.mapping.uncertainty.small import distance2, moved_by, relative, seen_from, wrapped

SEEDS = range(20)


def rotation(heading: float) -> FloatArray:
    c, s = np.cos(heading), np.sin(heading)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def lever(x: float, y: float) -> FloatArray:
    """What a turn about the origin does to the point x, y."""
    return np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])


def drawn(seed: int) -> tuple[FloatArray, float, float, float]:
    """A covariance with all its correlations, a heading and a point."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(3, 3))
    heading, x, y = rng.uniform(-7, 7), *rng.normal(scale=5.0, size=2)
    return root @ root.T + 0.01 * np.eye(3), float(heading), float(x), float(y)


@pytest.mark.parametrize("seed", SEEDS)
def test_errors_about_the_origin_are_seen_from_a_pose(seed: int) -> None:
    errors, heading, x, y = drawn(seed)
    found = np.full((3, 3), 99.0)
    seen_from(errors, heading, x, y, found)
    by = rotation(-heading) @ lever(x, y)
    assert np.allclose(found, by @ errors @ by.T, rtol=1e-12, atol=1e-10)


@pytest.mark.parametrize("seed", SEEDS)
def test_errors_moved_by_a_turn_and_a_lever_are_added_to_what_was_there(seed: int) -> None:
    errors, heading, x, y = drawn(seed)
    before = np.random.default_rng(seed + 100).normal(size=(3, 3))
    found = before.copy()
    moved_by(errors, heading, x, y, found)
    by = lever(x, y) @ rotation(heading)
    assert np.allclose(found - before, by @ errors @ by.T, rtol=1e-12, atol=1e-10)


@pytest.mark.parametrize("seed", SEEDS)
def test_distances_and_determinants_are_those_of_the_inverse(seed: int) -> None:
    covariance, heading, x, y = drawn(seed)
    off = np.array([x, y, heading])
    missed, determinant = distance2(covariance, x, y, heading, False)
    assert missed == pytest.approx(off @ np.linalg.solve(covariance, off), rel=1e-9)
    assert determinant == pytest.approx(np.linalg.det(covariance), rel=1e-9)
    flat = covariance[:2, :2]
    missed, determinant = distance2(covariance, x, y, heading, True)
    assert missed == pytest.approx(off[:2] @ np.linalg.solve(flat, off[:2]), rel=1e-9)
    assert determinant == pytest.approx(np.linalg.det(flat), rel=1e-9)


def test_angles_are_wrapped_from_minus_pi_up_to_pi() -> None:
    angles = np.linspace(-20.0, 20.0, 401)
    found = np.array([wrapped(angle) for angle in angles])
    assert ((found >= -np.pi) & (found < np.pi)).all()
    assert np.allclose(wrap_all(found - angles), 0.0, atol=1e-12)
    assert wrapped(np.pi) == -np.pi


@pytest.mark.parametrize("seed", SEEDS)
def test_relative_poses_are_those_of_the_geometry(seed: int) -> None:
    a, b = np.random.default_rng(seed).normal(scale=4.0, size=(2, 3))
    x, y, heading = relative(a, b)
    expected = between(a, b)
    assert (x, y) == pytest.approx(expected[:2])
    assert heading == pytest.approx(b[2] - a[2])  # not wrapped: whoever adds turns up wraps once
