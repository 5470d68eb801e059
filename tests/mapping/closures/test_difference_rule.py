"""The thesis's rule on a square loop: what it keeps, when it closes, and what its two corrections mend."""

from __future__ import annotations

import math

import numpy as np
import pytest

from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Motion
from topomap.core.rig import Rig
from topomap.mapping.closures.difference_rule import DifferenceRule, DifferenceRuleSettings

SMALL = Rig(90, 12, 5.5, 90 / TAU)
POSTS = np.random.default_rng(3).uniform(-2.0, 6.0, (40, 2))
LEG, STEP = 4.0, 0.1


def view(x: float, y: float, heading: float) -> Panorama:
    """Posts, the nearer the larger and each of its own brightness, on a dark ground."""
    angles = heading + np.arange(90) * TAU / 90
    row = np.zeros(90)
    for k, (a, b) in enumerate(POSTS):
        away = max(math.hypot(a - x, b - y), 0.3)
        apart = np.abs(np.angle(np.exp(1j * (angles - math.atan2(b - y, a - x)))))
        row += (60 + 17 * (k % 11)) * np.exp(-0.5 * (apart / (0.3 / away + 0.05)) ** 2)
    image = np.repeat(np.clip(row, 0, 255)[np.newaxis], 12, axis=0)
    return Panorama(np.repeat(image[:, :, np.newaxis], 3, axis=2).astype(np.uint8), None, SMALL)


def loop(laps: float) -> FloatArray:
    """True poses (N, 3) around a square, turning on the spot at its corners."""
    poses = [(0.0, 0.0, 0.0)]
    for _ in range(round(4 * laps)):
        x, y, heading = poses[-1]
        c, s = math.cos(heading), math.sin(heading)
        poses += [(x + c * STEP * k, y + s * STEP * k, heading) for k in range(1, round(LEG / STEP) + 1)]
        poses += [(*poses[-1][:2], heading + math.pi * k / 8) for k in (1, 2, 3, 4)]
    return np.array(poses)


def driven(poses: FloatArray, rotation: float, distance: float, settings: DifferenceRuleSettings) -> DifferenceRule:
    rule = DifferenceRule(settings)
    covariance = np.eye(3) * 1e-4
    for before, now in zip([poses[0], *poses[:-1]], poses, strict=True):
        forward = math.dist(now[:2], before[:2]) * distance
        rule.advance(view(*now), Motion(forward, 0.0, wrap(now[2] - before[2]) * rotation, covariance, 0.25))
        if rule.closures:  # the first loop: what follows is the next one's
            break
    return rule


SETTINGS = DifferenceRuleSettings(threshold=0.5)


def off(rule: DifferenceRule, poses: FloatArray) -> float:
    """The mean distance [m] of the path from the truth, both from the origin on."""
    return float(np.hypot(*(rule.path[:, :2] - poses[: len(rule.path), :2]).T).mean())


def test_a_drive_without_errors_is_left_alone_but_for_the_gap() -> None:
    poses = loop(1.25)
    rule = driven(poses, 1.0, 1.0, SETTINGS)
    assert rule.closures
    first = rule.closures[0]
    assert math.dist(poses[first.now, :2], poses[first.old, :2]) < 0.75
    assert off(rule, poses) < 0.15


@pytest.mark.parametrize("rotation", [1.04, 0.95])
def test_the_rotation_correction_undoes_a_wrong_scale_of_turns(rotation: float) -> None:
    poses = loop(1.25)
    rule = driven(poses, rotation, 1.0, SETTINGS)
    nothing = driven(poses, rotation, 1.0, DifferenceRuleSettings(threshold=0.5, travel=1e6))
    assert rule.closures[0].k_theta == pytest.approx(1.0 / rotation, abs=0.02)
    assert not nothing.closures
    end = len(rule.path)
    alone = float(np.hypot(*(nothing.path[:end, :2] - poses[:end, :2]).T).mean())
    assert off(rule, poses) < 0.7 * alone


def test_a_loop_closes_under_half_the_threshold_only() -> None:
    poses = loop(1.25)
    for rule in (driven(poses, 1.0, 1.0, SETTINGS), driven(poses, 1.0, 1.0, DifferenceRuleSettings(threshold=0.7))):
        assert all(c.difference < 0.5 * rule._s.threshold for c in rule.closures)
    none = driven(poses, 1.0, 1.0, DifferenceRuleSettings(threshold=1e-3))
    assert len(none.kept) >= len(driven(poses, 1.0, 1.0, SETTINGS).kept)


def test_snapshots_are_kept_as_differences_add_up() -> None:
    poses = loop(0.5)
    counts = [len(driven(poses, 1.0, 1.0, DifferenceRuleSettings(threshold=t)).kept) for t in (0.3, 1.0, 3.0)]
    assert counts[0] > counts[1] > counts[2] >= 1
