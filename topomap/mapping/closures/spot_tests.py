"""The tests of where the robot can be: whether odometry leaves it at the claimed spot, how near the two spots lie."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr

from topomap.core.arrays import FloatArray
from topomap.core.evidence import FALSE_DISTANCE
from topomap.core.geometry import between
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import Knowledge
from topomap.mapping.closures.odds import mahalanobis, relative_covariances

SAME_PLACE = 0.75  # [m] what lies nearer is the same place, as recall is counted
CERTAIN = 100.0  # odds that odometry gives at most: its covariance isn't known better
ANY_HEADING = (2 * math.pi) ** 2  # [rad^2]
LINES = 41  # 5 cm apart, over which a probability is summed: within 0.005 of what a hundred thousand draws say


@dataclass(frozen=True, slots=True)
class AtPlace:
    """Whether the robot can be at the claimed spot at all, for claims whose places were chosen within odometry's reach.

    Among places within reach a false claim fits odometry as well as a true one. What odometry then tells is how much
    there is besides: the probability that it leaves for the spot and 0.75 m about it, against all the rest. The heading
    isn't counted, as false matches are turned right in 7 of 10 cases (bench looks): walls are alike along corridors.
    """

    name: str = "at place"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return the log odds (n,)."""
        covariance = claims.covariance.copy()
        covariance[:, 2, 2] = ANY_HEADING
        chi2, determinant = mahalanobis(replace(claims, covariance=covariance), knowledge.poses, knowledge.errors)
        unsure = (claims.covariance[:, 0, 0] + claims.covariance[:, 1, 1]) / 2.0
        spot = np.maximum(SAME_PLACE**2, unsure)  # what sight can't tell apart is one spot
        expected = math.pi * spot * np.exp(-chi2 / 2) / (2 * math.pi * np.sqrt(determinant))
        return np.log(np.expm1(np.clip(expected, math.log1p(1 / CERTAIN), math.log1p(CERTAIN))))


@dataclass(frozen=True, slots=True)
class Beside:
    """Refuses a claim whose two spots lie apart by what it measured and odometry together: near a place isn't at it.

    Where views change slowly many places look like the very one, and odometry tells better which of them it is.
    """

    most: float
    name: str = "beside"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return 0 or minus infinity (n,)."""
        return np.where(self._apart(claims, knowledge) > self.most, -np.inf, 0.0)

    def reason(self, claims: Claims, knowledge: Knowledge) -> str:
        """Say how far apart a single claim's spots are."""
        apart = float(self._apart(claims, knowledge)[0])
        return f"beside it rather than there: {apart:.1f} m apart by odometry and sight (at most {self.most:g})"

    def _apart(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return how far apart the spots of n claims are [m]: the mean of both, each by its covariance."""
        mean, _, missed = _met(claims, knowledge)
        own = claims.covariance
        unsure = np.sqrt(own[:, 0, 0] + own[:, 1, 1])  # within it, sight says nothing of where
        return np.maximum(np.hypot(mean[:, 0], mean[:, 1]), np.minimum(np.hypot(missed[:, 0], missed[:, 1]), unsure))


@dataclass(frozen=True, slots=True)
class Placed:
    """Refuses a claim that is likelier false by definition than not: sight and odometry together leave it to chance
    whether its two spots lie within a metre.
    """

    least: float
    name: str = "placed"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return 0 or minus infinity (n,)."""
        return np.where(self._within(claims, knowledge) < self.least, -np.inf, 0.0)

    def reason(self, claims: Claims, knowledge: Knowledge) -> str:
        """Say how likely a single claim's spots are one place."""
        share = float(self._within(claims, knowledge)[0])
        return (
            f"sight and odometry don't tell where: within {FALSE_DISTANCE:g} m of it with probability {share:.2f} "
            f"(at least {self.least:g})"
        )

    def _within(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return (n,) probabilities that the two spots lie within the distance beyond which a closure is false."""
        mean, covariance, _ = _met(claims, knowledge)
        variances, axes = np.linalg.eigh(covariance)
        along = (axes.transpose(0, 2, 1) @ mean[:, :, None])[:, :, 0]
        sigmas = np.sqrt(np.maximum(variances, 1e-12))
        # over lines across the longer axis, as far as the circle reaches: each holds a share of the shorter one
        x = np.linspace(-1.0, 1.0, LINES) * FALSE_DISTANCE
        half = np.sqrt(np.maximum(FALSE_DISTANCE**2 - x**2, 0.0))
        density = ndtr((x[1:] - along[:, 1:]) / sigmas[:, 1:]) - ndtr((x[:-1] - along[:, 1:]) / sigmas[:, 1:])
        middle = (half[1:] + half[:-1]) / 2
        inside = ndtr((middle - along[:, :1]) / sigmas[:, :1]) - ndtr((-middle - along[:, :1]) / sigmas[:, :1])
        return np.asarray((density * inside).sum(axis=1))


def _met(claims: Claims, knowledge: Knowledge) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return where sight and odometry together have the second spots of n claims, seen from the first: means (n, 2),
    covariances (n, 2, 2), and how far odometry has them from what is claimed (n, 2) [m].
    """
    own = claims.covariance[:, :2, :2]
    both = own + relative_covariances(claims, knowledge.poses, knowledge.errors)[:, :2, :2]
    missed = between(knowledge.poses[claims.i], knowledge.poses[claims.j])[:, :2] - claims.relative[:, :2]
    mean = claims.relative[:, :2] + (own @ np.linalg.solve(both, missed[:, :, None]))[:, :, 0]
    return mean, own - own @ np.linalg.solve(both, own), missed
