"""Relative poses from range scans, against geometry."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topomap.core.arrays import FloatArray
from topomap.core.geometry import Pose2
from topomap.vision.matching.scan_match import match_scans

WALLS = [((0, 0), (6, 0)), ((6, 0), (6, 4)), ((6, 4), (0, 4)), ((0, 4), (0, 0)), ((2, 4), (2, 3)), ((4, 0), (4.5, 1))]
CORRIDOR = [((-50, 1), (50, 1)), ((50, -1), (-50, -1))]


def scan(walls: list, pose: Pose2, noise: float = 0.0, seed: int = 0) -> np.ndarray:
    """Ranges (720,) to the nearest wall, counter-clockwise from the nose."""
    angles = pose.heading + np.arange(720) * math.tau / 720
    ranges = np.full(720, np.inf)
    for (ax, ay), (bx, by) in walls:
        ux, uy, px, py = bx - ax, by - ay, ax - pose.x, ay - pose.y
        cross = np.cos(angles) * uy - np.sin(angles) * ux
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = (px * uy - py * ux) / cross
            along = (px * np.sin(angles) - py * np.cos(angles)) / cross
        hit = (distance > 0) & (along >= 0) & (along <= 1)
        ranges = np.where(hit, np.minimum(ranges, distance), ranges)
    ranges += np.random.default_rng(seed).normal(0.0, noise, 720) if noise else 0.0
    return np.where(ranges < 12.0, ranges, np.nan).astype(np.float32)


def relative(a: Pose2, b: Pose2) -> FloatArray:
    return a.to(b).array()


@settings(max_examples=30, deadline=None)
@given(
    st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-0.6, 0.6), st.floats(-math.pi, math.pi), st.integers(0, 99)
)
def test_a_near_scan_is_found_to_millimetres(dx: float, dy: float, turn: float, heading: float, seed: int) -> None:
    a = Pose2(3.0, 2.0, heading)
    b = a @ Pose2(dx, dy, turn)
    guess = relative(a, b) + np.array([0.05, -0.05, 0.05])
    found = match_scans(scan(WALLS, a, 0.01, seed), scan(WALLS, b, 0.01, seed + 100), guess)
    assert found is not None
    assert np.abs(found.relative - relative(a, b))[:2].max() < 0.01
    assert abs(found.relative[2] - relative(a, b)[2]) < math.radians(0.3)


def test_the_covariance_is_honest() -> None:
    a, b = Pose2(3.0, 2.0, 0.3), Pose2(3.3, 2.1, 0.4)
    off = []
    for seed in range(60):
        found = match_scans(scan(WALLS, a, 0.01, seed), scan(WALLS, b, 0.01, seed + 100), relative(a, b))
        assert found is not None
        off.append((found.relative - relative(a, b)) / np.sqrt(np.diag(found.covariance)))
    spread = np.sqrt(np.mean(np.square(off), axis=0))
    assert (spread < 1.5).all()
    assert (spread > 0.2).all()


def test_along_a_corridor_the_covariance_says_that_nothing_is_told() -> None:
    a, b = Pose2(0.0, 0.0, 0.0), Pose2(0.4, 0.1, 0.05)
    guess = relative(a, b) + np.array([0.2, 0.0, 0.0])
    found = match_scans(scan(CORRIDOR, a), scan(CORRIDOR, b), guess)
    assert found is not None
    assert found.covariance[0, 0] > 1.0
    assert found.relative[0] == pytest.approx(guess[0], abs=0.02), "where nothing is told, the guess stands"
    assert found.relative[1:] == pytest.approx(relative(a, b)[1:], abs=0.005)


def test_along_a_noisy_corridor_the_turn_is_told_exactly_though_the_way_is_not() -> None:
    a, b = Pose2(0.0, 0.2, 0.1), Pose2(0.4, 0.3, 0.15)
    off = []
    for seed in range(40):
        found = match_scans(scan(CORRIDOR, a, 0.01, seed), scan(CORRIDOR, b, 0.01, seed + 100), relative(a, b))
        assert found is not None
        along = Pose2(0.0, 0.0, a.heading)  # the corridor's direction in a's frame is -0.1 rad
        c, s = math.cos(along.heading), math.sin(along.heading)
        turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        covariance = turned @ found.covariance @ turned.T
        assert covariance[0, 0] > 1.0
        off.append((found.relative[2] - relative(a, b)[2]) / math.sqrt(covariance[2, 2]))
        assert math.sqrt(covariance[2, 2]) < math.radians(0.1)
    assert np.sqrt(np.mean(np.square(off))) < 1.5


def test_another_room_or_no_ranges_is_no_match() -> None:
    a = scan(WALLS, Pose2(3.0, 2.0, 0.0))
    nothing = np.full(720, np.nan, np.float32)
    assert match_scans(a, nothing, np.zeros(3)) is None
    assert match_scans(nothing, nothing, np.zeros(3)) is None
    circle = np.full(720, 0.8, np.float32)
    assert match_scans(a, circle, np.zeros(3)) is None
