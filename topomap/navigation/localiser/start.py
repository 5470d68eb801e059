"""What is known of where the robot is before its first view."""

from __future__ import annotations

from dataclasses import dataclass

from topomap.core.geometry import Pose2


@dataclass(frozen=True, slots=True)
class Start:
    """Where a belief begins.

    pose: in the map frame; node: at that snapshot node, looking its way (`pose` goes before it); unknown: anywhere on
    the map, looking any way. With none of them the robot is where the map's track ends, as in a run that began there.
    """

    pose: Pose2 | None = None
    node: int | None = None
    unknown: bool = False


HERE = Start()
ANYWHERE = Start(unknown=True)
