"""Claims: node j was taken where node i was, at this relative pose, and it looks this much more like a revisit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import Pose2
from topomap.mapping.optimizer import Closures
from topomap.mapping.optimizer.problem import UNKNOWN_HEADING


@dataclass(frozen=True, slots=True, eq=False)
class Claims:
    """M claims about places on one travelled chain.

    i, j (M,): places on the chain, i < j; relative (M, 3) `i_from_j` [m, rad] with covariance (M, 3, 3), a heading
    variance above `UNKNOWN_HEADING` says that the heading isn't known; looks (M,): log of how much more likely the
    views are if both are one place than if not, 0 where nothing is known of looks; weight (M,) in (0, 1] scales what
    each counts in a solve.
    """

    i: IntArray
    j: IntArray
    relative: FloatArray
    covariance: FloatArray
    looks: FloatArray
    weight: FloatArray

    @staticmethod
    def of(i: IntArray, j: IntArray, relative: FloatArray, covariance: FloatArray) -> Claims:
        """Return claims of whose looks nothing is known."""
        return Claims(i, j, relative, covariance, np.zeros(len(i)), np.ones(len(i)))

    @staticmethod
    def of_one(i: int, j: int, relative: Pose2, covariance: FloatArray, looks: float = 0.0) -> Claims:
        """Return a single claim."""
        places = np.array([i]), np.array([j])
        return Claims(*places, relative.array()[None], covariance[None], np.array([looks]), np.ones(1))

    def __len__(self) -> int:
        return len(self.i)

    def __getitem__(self, part: BoolArray | IntArray | slice) -> Claims:
        return Claims(
            self.i[part],
            self.j[part],
            self.relative[part],
            self.covariance[part],
            self.looks[part],
            self.weight[part],
        )

    @property
    def blind(self) -> BoolArray:
        """(M,) which claims don't know the heading."""
        return np.asarray(self.covariance[:, 2, 2] > UNKNOWN_HEADING)

    def closures(self) -> Closures:
        """Return the claims as the optimizer takes them."""
        return Closures(self.i, self.j, self.relative, self.covariance, self.weight)
