"""A drive through the thesis's loop-closing rule: the baseline that the closure engine is held against."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.panorama import Panorama
from topomap.core.records import Motion
from topomap.core.robot import Reading
from topomap.mapping.closures.difference_rule import DifferenceRule, DifferenceRuleSettings, RuleClosure

__all__ = ["DifferenceMap", "DifferenceRuleSettings", "map_by_difference"]


@dataclass(frozen=True, slots=True, eq=False)
class DifferenceMap:
    """poses (N, 3) [m, rad] of every step as corrected in the end, online (N, 3) as known then, steps of the
    snapshots, and the closures.
    """

    poses: FloatArray
    online: FloatArray
    kept: tuple[int, ...]
    closures: tuple[RuleClosure, ...]


def map_by_difference(readings: Iterable[Reading], settings: DifferenceRuleSettings | None = None) -> DifferenceMap:
    """Map a drive by the rule of 5.2.4 alone."""
    rule, online = DifferenceRule(settings), []
    for reading in readings:
        m = reading.motion
        rule.advance(Panorama.from_reading(reading), Motion(m.forward, m.left, m.turn, m.covariance, m.dt))
        online.append(rule.path[-1].copy())
    return DifferenceMap(rule.path.copy(), np.array(online).reshape(-1, 3), rule.kept, tuple(rule.closures))
