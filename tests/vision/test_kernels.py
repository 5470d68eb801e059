"""Dynamic time warping against the textbook recursion written out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topomap.core.arrays import Float32Array
from topomap.vision.matching.difference_kernels import block_differences
from topomap.vision.matching.dtw_kernels import dtw_path


def plain_cost(home: Float32Array, current: Float32Array, band: int) -> float:
    """The least sum of differences over all monotone paths."""
    length = home.shape[1]
    total = np.full((length + 1, length + 1), np.inf)
    total[0, 0] = 0.0
    for i in range(length):
        for j in range(max(0, i - band), min(length, i + band + 1)):
            least = min(total[i, j], total[i, j + 1], total[i + 1, j])
            total[i + 1, j + 1] = least + np.abs(home[:, i] - current[:, j]).sum()
    return float(total[length, length])


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.integers(2, 24), st.integers(1, 10))
def test_the_path_costs_the_least(seed: int, length: int, band: int) -> None:
    rng = np.random.default_rng(seed)
    home, current = (rng.normal(size=(3, length)).astype(np.float32) for _ in range(2))
    shift, mean_cost = dtw_path(home, current, min(band, length - 1))
    steps = plain_cost(home, current, min(band, length - 1)) / 3 / mean_cost
    assert steps == pytest.approx(round(steps), abs=1e-3)
    assert length <= round(steps) <= 2 * length - 1
    assert np.abs(shift).max() <= band
    assert (np.diff(np.arange(length) + shift) >= -1e-9).all(), "the match never runs backwards"


def test_a_sequence_matches_itself_and_a_shifted_bump_is_found() -> None:
    t = np.arange(60, dtype=np.float32)
    home = np.exp(-0.5 * np.square((t - 25) / 3))[np.newaxis].astype(np.float32)
    moved = np.exp(-0.5 * np.square((t - 31) / 3))[np.newaxis].astype(np.float32)
    assert np.abs(dtw_path(home, home, 10)[0]).max() == 0.0
    assert dtw_path(home, home, 10)[1] == 0.0
    assert dtw_path(home, moved, 10)[0][25] == pytest.approx(6.0, abs=1.0)


def test_blocks_differ_least_where_the_ring_has_moved() -> None:
    ring = np.random.default_rng(2).normal(size=(3, 40)).astype(np.float32)
    found = block_differences(ring, np.roll(ring, 3, axis=1), 6, 2)
    assert (found.argmin(axis=1) == 6 + 3).all()
    assert np.abs(found.min(axis=1)).max() == 0.0
