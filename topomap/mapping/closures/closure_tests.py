"""The tests that a claim passes, each a log likelihood ratio: what it saw if the claim is true over if it is false."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.special import chdtri

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import between, wrap_all
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.odds import (
    FALSE_DISTANCE,
    FALSE_ROTATION,
    log_chance,
    log_crowding,
    log_density,
    mahalanobis,
)


@dataclass(frozen=True, slots=True, eq=False)
class Knowledge:
    """What the map knows of n claims without believing them.

    poses (N, 3); errors (n, 3, 3): of the map between the claims' places, about the origin; size (n,): how many
    neighbouring claims each agrees with, itself included; prevalence (n,): log of how many such claims are true for one
    that is false; support (n,): what agrees with each over what is needed, 1 where nothing is.
    """

    poses: FloatArray
    errors: FloatArray
    size: IntArray
    prevalence: FloatArray
    support: FloatArray

    @staticmethod
    def of_one(poses: FloatArray, errors: FloatArray) -> Knowledge:
        """Return what is known of a single claim that stands alone: the map's errors (3, 3) between its places."""
        return Knowledge(poses, errors[None], np.ones(1, np.int64), np.zeros(1), np.ones(1))

    def among(self, part: IntArray) -> Knowledge:
        """Return what is known of some (n,) of the claims."""
        return Knowledge(self.poses, self.errors[part], self.size[part], self.prevalence[part], self.support[part])


class ClosureTest(Protocol):
    """A stage of the engine. Tests are asked in order; one that lowers isn't followed for claims it leaves unlikely."""

    @property
    def name(self) -> str: ...
    @property
    def lowers(self) -> bool:
        """Whether this test and all behind it can only speak against a claim."""

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return (n,) log likelihood ratios of n claims; minus infinity refuses."""


@dataclass(frozen=True, slots=True)
class Looks:
    """What the source of the claims saw."""

    name: str = "looks"
    lowers: bool = False

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return the claims' own log likelihood ratios (n,)."""
        return claims.looks


@dataclass(frozen=True, slots=True)
class Prevalence:
    """How often such claims, alone or in clusters of that size, are true in these data."""

    name: str = "prevalence"
    lowers: bool = False

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return the log prior odds (n,)."""
        return knowledge.prevalence


@dataclass(frozen=True, slots=True)
class Odometry:
    """How well the map, by odometry and the closures that stand, agrees, against a claim of any two places."""

    name: str = "odometry"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return the log density of each claim (n,) by the map over that of any claim.

        Where the map knows nothing, as across a gap in the odometry, a true claim is no less likely than any other.
        """
        chi2, determinant = mahalanobis(claims, knowledge.poses, knowledge.errors)
        blind = claims.blind
        even = log_chance(knowledge.poses, blind)
        peak = log_density(np.zeros(len(claims)), determinant, blind)
        return log_density(chi2, determinant, blind) - peak + np.maximum(peak, even) - even


@dataclass(frozen=True, slots=True)
class Apart:
    """Refuses what would be a false closure by its definition: the map has the places farther from what is claimed.

    Heavy tails let through what is off by several sigmas; more than 1 m or 20 degrees of it is another place, unless
    claim and map are as vague as that.
    """

    name: str = "apart"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return 0 or minus infinity (n,)."""
        missed = between(knowledge.poses[claims.i], knowledge.poses[claims.j]) - claims.relative
        far = np.hypot(missed[:, 0], missed[:, 1]) > FALSE_DISTANCE
        turned = ~claims.blind & (np.abs(wrap_all(missed[:, 2])) > FALSE_ROTATION)
        chi2, _ = mahalanobis(claims, knowledge.poses, knowledge.errors)
        sure = chi2 > chdtri(np.where(claims.blind, 2, 3), 0.01)
        return np.where((far | turned) & sure, -np.inf, 0.0)


@dataclass(frozen=True, slots=True)
class Crowding:
    """How many other places stand as the claim says: where places lie on a lattice, false claims fit more often."""

    name: str = "crowding"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return what is to be taken off (n,)."""
        return -log_crowding(claims, knowledge.poses, knowledge.errors)


@dataclass(frozen=True, slots=True)
class Supported:
    """Refuses a claim that too few of its neighbours agree with."""

    name: str = "support"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return 0 or minus infinity (n,)."""
        return np.where(knowledge.support >= 1.0, 0.0, -np.inf)


@dataclass(frozen=True, slots=True)
class Gate:
    """Refuses a claim that odometry can't explain; probability: share of true ones that pass."""

    probability: float
    name: str = "gate"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return 0 or minus infinity (n,)."""
        chi2, _ = mahalanobis(claims, knowledge.poses, knowledge.errors)
        return np.where(chi2 <= chdtri(np.where(claims.blind, 2, 3), 1 - self.probability), 0.0, -np.inf)


TESTS: tuple[ClosureTest, ...] = (Looks(), Prevalence(), Odometry(), Apart(), Crowding())
