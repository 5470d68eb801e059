"""Where another drive on a loaded map begins, as far as that is known."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import Pose2
from topomap.mapping.graph import TopoMap
from topomap.mapping.pose_graph import gap_covariance

TOLD = (0.5, 0.5, math.radians(10.0))
"""[m, m, rad] How exactly a robot is put where it is said to begin: by hand, at a place and looking a way."""


@dataclass(frozen=True, slots=True, eq=False)
class DriveStart:
    """A map that is gone on with: pose in its frame with covariance (3, 3); anywhere: the pose tells nothing."""

    map: TopoMap
    pose: Pose2
    covariance: FloatArray
    anywhere: bool = False

    @staticmethod
    def at(topo: TopoMap, pose: Pose2) -> DriveStart:
        """Return a drive that begins at a pose that somebody tells."""
        return DriveStart(topo, pose, np.diag(np.square(TOLD)))

    @staticmethod
    def somewhere(topo: TopoMap) -> DriveStart:
        """Return a drive that begins anywhere on the map or beside it, looking any way."""
        return DriveStart(topo, topo.pose(topo.chain[-1]), gap_covariance(topo.poses), anywhere=True)
