"""A pose graph in the plane, as files hold it: odometry along one chain and closures."""

from __future__ import annotations

from dataclasses import dataclass

from topomap.core.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class PoseGraph:
    """N poses in travel order, their odometry and M closures, all as `i_from_j`.

    odometry (N - 1, 3) from each pose to the next; odometry_covariance (N - 1, 3, 3); i < j (M,), relative (M, 3),
    covariance (M, 3, 3). Covariances are of x, y [m] and heading [rad] in the frame of i.
    """

    name: str
    odometry: FloatArray
    odometry_covariance: FloatArray
    i: IntArray
    j: IntArray
    relative: FloatArray
    covariance: FloatArray

    @property
    def nodes(self) -> int:
        """How many poses there are."""
        return len(self.odometry) + 1
