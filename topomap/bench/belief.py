"""Whether a belief is right, judged by the truth."""

from __future__ import annotations

import math

from topomap.core.geometry import Pose2, wrap
from topomap.core.records import Where

WRONG, WRONG_TURN = 1.0, math.radians(20.0)
"""[m], [rad] What a belief misses by, one of them at least, to be wrong: as a closure to be false."""


def is_wrong(where: Where, here: Pose2, node_truth: Pose2 | None, node_pose: Pose2 | None) -> bool:
    """Hold a belief against the true pose `here`, seen from the node it names: the map's errors elsewhere don't count.

    node_truth, node_pose: that node's true pose and its pose on the map; None: it names none.
    """
    if node_truth is None or node_pose is None:
        return True
    believed = node_truth @ node_pose.to(where.pose)
    apart = math.hypot(believed.x - here.x, believed.y - here.y)
    return apart > WRONG or abs(wrap(believed.heading - here.heading)) > WRONG_TURN
