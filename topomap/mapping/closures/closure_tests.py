"""The tests that a claim passes, each a log likelihood ratio: what it saw if the claim is true over if it is false."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from scipy.special import chdtri

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.evidence import FALSE_DISTANCE, FALSE_ROTATION
from topomap.core.geometry import between, wrap_all
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.odds import log_chance, log_crowding, log_density, mahalanobis
from topomap.mapping.closures.seen import Seen


@dataclass(frozen=True, slots=True, eq=False)
class Knowledge:
    """What the map knows of n claims without believing them.

    poses (N, 3); errors (n, 3, 3): of the map between the claims' places, about the origin; size (n,): how many
    neighbouring claims each agrees with, itself included; prevalence (n,): log of how many such claims are true for one
    that is false; support (n,): what agrees with each over what is needed, 1 where nothing is; seen: what the robot saw
    of the places, None for claims of others.
    """

    poses: FloatArray
    errors: FloatArray
    size: IntArray
    prevalence: FloatArray
    support: FloatArray
    seen: Seen | None = None

    @staticmethod
    def of_one(poses: FloatArray, errors: FloatArray, seen: Seen | None = None, support: float = 1.0) -> Knowledge:
        """Return what is known of a single claim: the map's errors (3, 3) between its places; it stands alone unless
        support is given.
        """
        return Knowledge(poses, errors[None], np.ones(1, np.int64), np.zeros(1), np.array([support]), seen)

    def among(self, part: IntArray) -> Knowledge:
        """Return what is known of some (n,) of the claims."""
        seen = None if self.seen is None else self.seen.among(part)
        return Knowledge(
            self.poses, self.errors[part], self.size[part], self.prevalence[part], self.support[part], seen
        )


class ClosureTest(Protocol):
    """A stage of the engine. Tests are asked in order; one that lowers isn't followed for claims it leaves unlikely."""

    @property
    def name(self) -> str: ...
    @property
    def lowers(self) -> bool:
        """Whether this test and all behind it can only speak against a claim."""

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return (n,) log likelihood ratios of n claims; minus infinity refuses."""


@runtime_checkable
class Explains(Protocol):
    """A test that can say in plain words what it found."""

    def reason(self, claims: Claims, knowledge: Knowledge) -> str:
        """Return what it found of a single claim."""


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


TESTS: tuple[ClosureTest, ...] = (Looks(), Prevalence(), Odometry(), Apart(), Crowding())
