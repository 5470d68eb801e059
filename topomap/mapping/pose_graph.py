"""A pose graph in the plane, as files hold it: chains of odometry, and closures that may be false."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import wrap_all

# How little is known of a step without odometry. Ten times the drive's own extent is no knowledge of a place, yet its
# information stays some 1e-8 of an edge's, which double precision carries; a sigma of pi is no knowledge of a heading.
GAP_EXTENTS, GAP_HEADING = 10.0, np.pi  # [extents of the drive, rad]


def _no_flags() -> BoolArray:
    return np.zeros(0, np.bool_)


def _no_names() -> IntArray:
    return np.zeros(0, np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class PoseGraph:
    """N poses in travel order, their odometry and M closures, all as `i_from_j`, closures in the order of their file.

    odometry (N - 1, 3) from each pose to the next; odometry_covariance (N - 1, 3, 3); i < j (M,), relative (M, 3),
    covariance (M, 3, 3). Covariances are of x, y [m] and heading [rad] in the frame of i. gaps (N - 1,): which steps
    have no odometry, so that they are as good as unknown, none if left out; names (N,): the poses' ids in their file,
    0 to N - 1 if left out.
    """

    name: str
    odometry: FloatArray
    odometry_covariance: FloatArray
    i: IntArray
    j: IntArray
    relative: FloatArray
    covariance: FloatArray
    gaps: BoolArray = field(default_factory=_no_flags)
    names: IntArray = field(default_factory=_no_names)

    def __post_init__(self) -> None:
        if not len(self.gaps):
            object.__setattr__(self, "gaps", np.zeros(len(self.odometry), np.bool_))
        if not len(self.names):
            object.__setattr__(self, "names", np.arange(self.nodes))

    @property
    def nodes(self) -> int:
        """How many poses there are."""
        return len(self.odometry) + 1

    def dead_reckoning(self) -> FloatArray:
        """Return the poses (N, 3) by odometry alone, from the first pose on."""
        heading = np.concatenate([[0.0], np.cumsum(self.odometry[:, 2])])
        c, s = np.cos(heading[:-1]), np.sin(heading[:-1])
        x, y = self.odometry[:, 0], self.odometry[:, 1]
        steps = np.column_stack([c * x - s * y, s * x + c * y])
        return np.column_stack([np.vstack([np.zeros(2), np.cumsum(steps, axis=0)]), wrap_all(heading)])


def gap_covariance(poses: FloatArray) -> FloatArray:
    """Return the covariance (3, 3) of a step without odometry in a drive along poses (N, 3)."""
    extent = max(1.0, float(np.ptp(poses[:, :2], axis=0).max()))
    return np.diag(np.square([GAP_EXTENTS * extent, GAP_EXTENTS * extent, GAP_HEADING]))
