"""Whether what stands still before the robot goes along with it, as people who accompany it do."""

from __future__ import annotations

import math

from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.mapping.odometry.seen_way import parts_moved

PARTS = 2
"""Sectors of the view that moved as the odometry has it, from which on what stands still goes along with the robot:
amid people beside it 93 % of 165 looks of two worlds have as many, where ranges and most of the view show it standing
half a metre back; with wheels that spin amid people one of 264."""
COMPANY, IN_A_ROW = 20, 3
"""Looks for which somebody is reckoned with after that, 10 m: the robot stands only if so many in a row have no such
sector. In 2 % of those 165 looks there is none, in 98 % of the 264."""
STANDS, TWICE = 0.3, 2
"""Share of the usual way below which ranges show a standing robot, and looks in a row that have to, without company:
between bare walls nobody's view moves. What was counted meanwhile is taken back with the last."""


class Company:
    """Weighs each look by which the robot went less far than its odometry reads."""

    def __init__(self) -> None:
        self._left = 0  # looks for which somebody who went along lately is still reckoned with
        self._in_a_row = 0  # looks by which nothing moved

    @property
    def present(self) -> bool:
        """Whether somebody went along with the robot lately, so that most of the view may stand still."""
        return self._left > 0

    @property
    def nothing_moved(self) -> bool:
        """Whether by the last look no part of the view moved."""
        return self._in_a_row > 0

    def pass_by(self) -> None:
        """Take a look that shows the way that the odometry reads, or none."""
        self._left -= self._left > 0
        self._in_a_row = 0

    def explains(self, before: Panorama, now: Panorama, read: Pose2, shown: Pose2, usual: float) -> bool:
        """Return whether what shows less way goes along with the robot, or hasn't shown it often enough yet.

        before, now: with ranges, a look apart; read, shown: `now` seen from `before`, by the odometry and by what
        stands still; usual: the usual way between them [m].
        """
        self._left -= self._left > 0
        parts = parts_moved(before, now, read, shown)
        if parts >= PARTS:
            self._left = COMPANY
        self._in_a_row = self._in_a_row + 1 if parts == 0 else 0
        if self.present:
            return self._in_a_row < IN_A_ROW
        stands = math.hypot(shown.x, shown.y) < STANDS * usual
        return parts >= PARTS or (stands and self._in_a_row < TWICE)
