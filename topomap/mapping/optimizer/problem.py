"""Problem and Solution of the back end: odometry, closures and turns in; poses, calibration and inliers out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.errors import TopomapError
from topomap.core.geometry import Pose2
from topomap.core.records import UNKNOWN_HEADING as UNKNOWN_HEADING  # what closures say of it, the back end reads
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements, Increments

PRIOR_SIGMAS = (0.05, 0.01, 0.1)  # log rotation scale, curvature [rad/m], log distance scale


@dataclass(frozen=True, slots=True)
class OdometryEdge:
    """Raw increments from node i to node j."""

    i: int
    j: int
    increments: Increments


@dataclass(frozen=True, slots=True, eq=False)
class OdometryEdges:
    """E odometry edges in one piece, in travel order: i, j (E,) and their raw increments."""

    i: IntArray
    j: IntArray
    increments: EdgeIncrements

    def __len__(self) -> int:
        return len(self.i)

    @staticmethod
    def of(edges: Sequence[OdometryEdge]) -> OdometryEdges:
        """Return the edges in one piece."""
        return OdometryEdges(
            np.array([edge.i for edge in edges], np.int64),
            np.array([edge.j for edge in edges], np.int64),
            EdgeIncrements.of([edge.increments for edge in edges]),
        )


@dataclass(frozen=True, slots=True)
class ClosureEdge:
    """A closure: `i_from_j` with covariance (3, 3) of x, y [m], heading [rad].

    weight in (0, 1] scales its information.
    """

    i: int
    j: int
    relative: Pose2
    covariance: FloatArray
    weight: float = 1.0


@dataclass(frozen=True, slots=True)
class TurnEdge:
    """A turn [rad] measured from node i to node j, by scans or by the visual compass, with its sigma [rad]."""

    i: int
    j: int
    turn: float
    sigma: float


@dataclass(frozen=True, slots=True)
class AxisEdge:
    """Node i, on the way to j, looks along one of a building's axes (mod 90 degrees), with its sigma [rad].

    An assumption about the building, not a measurement: whoever uses it says so.
    """

    i: int
    j: int
    sigma: float


@dataclass(frozen=True, slots=True, eq=False)
class Closures:
    """M closures in one piece: i, j (M,), relative (M, 3), covariance (M, 3, 3), weight (M,)."""

    i: IntArray
    j: IntArray
    relative: FloatArray
    covariance: FloatArray
    weight: FloatArray

    def __len__(self) -> int:
        return len(self.i)

    @staticmethod
    def of(edges: Sequence[ClosureEdge]) -> Closures:
        """Return the edges in one piece."""
        return Closures(
            np.array([e.i for e in edges], np.int64),
            np.array([e.j for e in edges], np.int64),
            np.array([e.relative.array() for e in edges]).reshape(-1, 3),
            np.array([e.covariance for e in edges], float).reshape(-1, 3, 3),
            np.array([e.weight for e in edges], float),
        )

    def __getitem__(self, part: BoolArray | IntArray | slice) -> Closures:
        return Closures(self.i[part], self.j[part], self.relative[part], self.covariance[part], self.weight[part])

    def same(self, other: Closures) -> bool:
        """Return whether others say the same, number by number."""
        own = (self.i, self.j, self.relative, self.covariance, self.weight)
        others = (other.i, other.j, other.relative, other.covariance, other.weight)
        return all(np.array_equal(a, b) for a, b in zip(own, others, strict=True))


def no_closures() -> Closures:
    """Return an empty set."""
    return Closures.of(())


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """A pose graph with its odometry's systematic errors as unknowns.

    poses (N, 3): the start, made with `calibration`; node ids are 0..N-1; odometry: in travel order, an edge
    begins where the last one ended; prior, prior_sigmas (3,): mean and sigma of (log rotation scale,
    curvature [rad/m], log distance scale); anchor: the node that is held; others (E,): the odometry edges of other
    drives, whose errors are those of `calibration` and aren't sought, none if left out.
    Raises TopomapError for NaN, ids out of range, a broken chain or a missing anchor.
    """

    poses: FloatArray
    odometry: OdometryEdges
    closures: Closures = field(default_factory=no_closures)
    turns: tuple[TurnEdge, ...] = ()
    calibration: Calibration = field(default_factory=Calibration)
    prior: Calibration = field(default_factory=Calibration)
    prior_sigmas: tuple[float, float, float] = PRIOR_SIGMAS
    anchor: int = 0
    axes: tuple[AxisEdge, ...] = ()
    others: BoolArray | None = None

    def __post_init__(self) -> None:
        if self.poses.ndim != 2 or self.poses.shape[1] != 3 or len(self.poses) == 0:
            raise TopomapError(f"a pose graph needs poses (N, 3) with N >= 1, not {self.poses.shape}")
        if not 0 <= self.anchor < len(self.poses):
            raise TopomapError(f"the anchor {self.anchor} is none of the {len(self.poses)} nodes")
        self._check_ids()
        self._check_numbers()

    def _check_ids(self) -> None:
        pairs = [(t.i, t.j) for t in self.turns] + [(a.i, a.j) for a in self.axes]
        i, j = np.array(pairs, np.int64).reshape(-1, 2).T
        starts, ends = (
            np.concatenate(part)
            for part in ((self.odometry.i, i, self.closures.i), (self.odometry.j, j, self.closures.j))
        )
        named = np.concatenate([starts, ends])
        if named.size and (named.min() < 0 or named.max() >= len(self.poses)):
            raise TopomapError(f"an edge names a node outside 0..{len(self.poses) - 1}")
        if bool((starts == ends).any()):
            raise TopomapError("an edge joins a node with itself")
        breaks = np.flatnonzero(self.odometry.j[:-1] != self.odometry.i[1:])
        if len(breaks):
            a, b = self.odometry.j[breaks[0]], self.odometry.i[breaks[0] + 1]
            raise TopomapError(f"the odometry breaks between nodes {a} and {b}; edges follow the way travelled")

    def _check_numbers(self) -> None:
        increments = self.odometry.increments
        named = {
            "poses": [self.poses],
            "odometry": [increments.deltas, increments.covariances],
            "closures": [self.closures.relative, self.closures.covariance, self.closures.weight],
            "turn observations": [np.array([(t.turn, t.sigma) for t in self.turns], float)],
            "calibration": [self.calibration.vector(), self.prior.vector(), np.array(self.prior_sigmas)],
        }
        for name, arrays in named.items():
            if not bool(np.isfinite(np.concatenate([np.ravel(a) for a in arrays] or [np.zeros(0)])).all()):
                raise TopomapError(f"the {name} of the pose graph hold NaN or infinite numbers")


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """What the back end found; refused (improved False) it holds the problem's own poses and calibration.

    poses (N, 3); calibration_covariance (3, 3) of `Calibration.vector`; closure_weights (M,) in [0, 1], at least 0.5
    for an inlier; error_before, error_after: truncated squared error of start and
    result.
    """

    poses: FloatArray
    calibration: Calibration
    calibration_covariance: FloatArray
    closure_weights: FloatArray
    error_before: float
    error_after: float
    iterations: int
    improved: bool
