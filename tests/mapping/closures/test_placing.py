"""A start for the solve across a gap: what a closure turns far is moved as a whole, behind the gap."""

from __future__ import annotations

import numpy as np
import pytest
from chains import chain_of

from topomap.core.geometry import between, compose, wrap_all
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.placing import placed
from topomap.mapping.uncertainty.odometry_chain import Chain

WEAK = 12  # the step that odometry knows least


def chain() -> Chain:
    noise = np.tile(np.diag([0.02, 0.02, 0.01]) ** 2, (30, 1, 1))
    noise[WEAK, 2, 2] = 9.0
    return chain_of(np.tile([1.0, 0.0, 0.05], (30, 1)), noise)


def claim(own: Chain, turned: float) -> Claims:
    i, j = np.array([4]), np.array([25])
    relative = between(own.poses[i], own.poses[j]) + np.array([[3.0, -2.0, turned]])
    relative[:, 2] = wrap_all(relative[:, 2])
    return Claims.of(i, j, relative, np.tile(1e-4 * np.eye(3), (1, 1, 1)))


@pytest.mark.parametrize("turned", [0.49, -0.49, 0.0])
def test_what_is_turned_little_is_left_to_the_solve(turned: float) -> None:
    own = chain()
    assert placed(own.poses, own, claim(own, turned)) is own.poses


@pytest.mark.parametrize("turned", [0.51, -0.51, 3.0])
def test_what_is_turned_far_is_placed_as_claimed_and_moved_behind_the_weakest_step(turned: float) -> None:
    own = chain()
    before, one = own.poses.copy(), claim(own, turned)
    found = placed(own.poses, own, one)
    assert np.array_equal(own.poses, before)
    assert np.array_equal(found[: WEAK + 1], before[: WEAK + 1])
    assert np.allclose(found[25], compose(before[4], one.relative[0]), atol=1e-9)
    behind = between(found[WEAK + 1 : -1], found[WEAK + 2 :])
    assert np.allclose(behind, between(before[WEAK + 1 : -1], before[WEAK + 2 :]), atol=1e-9)  # as one piece


def test_without_a_gap_a_drifted_drive_is_left_to_the_solve() -> None:
    noise = np.tile(np.diag([0.02, 0.02, 0.2]) ** 2, (30, 1, 1))  # 1.1 rad over the drive, 0.2 a step
    own = chain_of(np.tile([1.0, 0.0, 0.05], (30, 1)), noise)
    assert placed(own.poses, own, claim(own, 1.5)) is own.poses
