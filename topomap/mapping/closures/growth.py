"""A pose graph with doubtful closures, mapped by the stack's back end: noise, agreement, odds, growth, solve."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field
from scipy.special import chdtri

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import between, wrap_all
from topomap.mapping.closures.graph_odometry import HELD, chain_of, extended, odometry_edges, odometry_poses, volume
from topomap.mapping.closures.groups import Bar, credible_groups
from topomap.mapping.closures.noise import rescaled, variance_factor
from topomap.mapping.closures.odds import crowding, log_odds
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements
from topomap.mapping.optimizer import Closures, OptimizerSettings, Problem, solve
from topomap.mapping.optimizer.residuals import closure_chi2
from topomap.mapping.pose_graph import PoseGraph
from topomap.mapping.uncertainty.paths import Paths


def _growing() -> OptimizerSettings:
    return OptimizerSettings(cutoffs=(1e3, 1e3, 10.0), iterations=2, tolerance=0.02)


def _joining() -> OptimizerSettings:
    return OptimizerSettings(cutoffs=(1e5, 1e5, 1e4, 1e3, 1e2, 10.0), iterations=2, tolerance=0.02)


def _closing() -> OptimizerSettings:
    return OptimizerSettings(cutoffs=(6.0, 3.4), iterations=8, tolerance=0.005)


class GraphSettings(BaseModel):
    """Stages and their limits; the same for every pose graph."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    gate: float = Field(default=0.999, gt=0.5, lt=1, description="share of true closures that the map lets pass")
    risk: float = Field(default=0.1, gt=0, lt=1, description="closures believed by chance at most if all were false")
    known: float = Field(default=0.5, gt=0, description="headings of closures' ends are so well known in a group [rad]")
    strays: float = Field(default=0.01, gt=0, lt=1, description="members that a false closure joins by chance [share]")
    together: float = Field(default=0.03, gt=0, lt=1, description="groups believed by chance at most")
    clear: float = Field(
        default=1.5, ge=1, description="a group's log odds are so many times what they must be while more is to come"
    )
    standing: float = Field(
        default=200.0, gt=0, description="a believed one is so much likelier true than false by the rest of the map"
    )
    turn: float = Field(default=0.3, gt=0, description="what odometry's heading may be off between solves [rad]")
    solves: int = Field(default=20, ge=1, description="solves while growing at most")
    rounds: int = Field(default=40, ge=1, description="how often the finished map hears all closures again")
    growing: OptimizerSettings = Field(default_factory=_growing, description="the solve with new closures")
    joining: OptimizerSettings = Field(default_factory=_joining, description="the solve with groups, which move far")
    closing: OptimizerSettings = Field(default_factory=_closing, description="the last solves")


class Mapped(NamedTuple):
    """Poses (N, 3) and which closures (M,) are believed."""

    poses: FloatArray
    believed: BoolArray


def map_graph(graph: PoseGraph, settings: GraphSettings | None = None) -> Mapped:
    """Map a pose graph whose closures may be false and whose covariances hold up to a factor."""
    drift = odometry_poses(graph)
    raw = chain_of(drift, EdgeIncrements.of([e.increments for e in odometry_edges(graph)]).integrate(Calibration()))
    factor = variance_factor(graph, raw, volume(drift))
    growth = Growth(rescaled(graph, factor), settings or GraphSettings())
    growth.grow()
    return growth.close()


class Growth:
    """The map of one pose graph as it grows."""

    def __init__(self, graph: PoseGraph, settings: GraphSettings) -> None:
        self._s, self._graph = settings, graph
        self._closures = Closures(graph.i, graph.j, graph.relative, graph.covariance, np.ones(len(graph.i)))
        self._edges = odometry_edges(graph)
        self._integrated = EdgeIncrements.of([e.increments for e in self._edges]).integrate(Calibration())
        self._odometry = chain_of(odometry_poses(graph), self._integrated)
        self._volume = volume(self._odometry.poses)
        self._limit = float(chdtri(3, 1 - settings.gate))
        self._log_count = np.log(max(1, len(self._closures)))
        self._poses = np.zeros((1, 3))
        self._believed = np.zeros(0, np.int64)

    def grow(self) -> None:
        """Follow the chain; hear the closures whenever odometry's heading has become uncertain."""
        for last in self._stops():
            self._poses = extended(self._poses, self._graph.odometry[len(self._poses) - 1 : last - 1])
            self._hear(self._possible(), self._s.clear)

    def _stops(self) -> list[int]:
        """Return how many nodes there are at each solve while growing."""
        variance = self._odometry.random[:, 2, 2]
        pieces = int(np.clip(np.ceil(variance[-1] / self._s.turn**2), 1, self._s.solves))
        ends = np.searchsorted(variance, variance[-1] * np.arange(1, pieces) / pieces)
        return [*np.unique(ends[ends > 1]).tolist(), self._graph.nodes]

    def _possible(self) -> IntArray:
        """Return the closures not believed so far that odometry alone allows."""
        waiting = np.setdiff1d(np.flatnonzero(self._closures.j < len(self._poses)), self._believed)
        some = self._closures[waiting]
        covariance = chain_of(self._poses, self._integrated).covariance(some.i, some.j)
        return np.asarray(waiting[closure_chi2(self._poses, some, covariance) <= self._limit])

    def _hear(self, which: IntArray, clear: float) -> IntArray:
        """Believe those of some closures that are credible one by one; if none, those that are in groups; return them.

        clear: of how many times the log odds needed groups must be.
        """
        some = self._closures[which]
        known = self._known(some, np.full(len(which), -1))
        chi2, spread = closure_chi2(self._poses, some, known), known + some.covariance
        odds = log_odds(chi2, spread, self._volume)
        fit = np.flatnonzero(chi2 <= self._limit)
        new = which[self._credible(some, odds, spread, fit)]
        settings = self._s.growing
        if not len(new):
            new, settings = self._together(which[fit], odds[fit], clear), self._s.joining
        if len(new):
            self._solve(np.concatenate([self._believed, new]), settings)
        return new

    def _credible(self, some: Closures, odds: FloatArray, spread: FloatArray, fit: IntArray) -> IntArray:
        """Return which of the fitting ones the map makes credible alone."""
        needed = self._log_count - np.log(self._s.risk)
        good = fit[odds[fit] >= needed]
        odds = odds[good] - np.log(crowding(self._poses, some[good], spread[good], self._volume))
        return np.asarray(good[odds >= needed])

    def _together(self, which: IntArray, odds: FloatArray, clear: float) -> IntArray:
        """Return those of some closures, with log odds (n,), that are credible in groups."""
        bar = Bar(clear * (self._log_count - np.log(self._s.together)), -np.log(self._s.strays), self._limit)
        good = credible_groups(self._closures[which], odds, self._poses, self._paths(), self._s.known, bar)
        return np.asarray(which[good])

    def _known(self, closures: Closures, without: IntArray) -> FloatArray:
        """Return (n, 3, 3) how well the map knows what closures claim, each without one of the believed ones."""
        return self._paths().covariance(closures.i, closures.j, without)

    def _paths(self) -> Paths:
        return Paths(chain_of(self._poses, self._integrated), self._closures[self._believed])

    def _solve(self, which: IntArray, settings: OptimizerSettings) -> None:
        edges = self._edges[: len(self._poses) - 1]
        solution = solve(Problem(self._poses, edges, self._closures[which], prior_sigmas=HELD), settings)
        self._poses, self._believed = solution.poses, which[solution.closure_weights > 0]

    def close(self) -> Mapped:
        """Hear every closure again until none is new, settle, and keep what the rest of the map stands by."""
        refused = np.zeros(0, np.int64)
        for _ in range(self._s.rounds):
            new = self._hear(np.setdiff1d(self._possible(), refused), 1.0)
            if not len(new):
                break
            refused = np.union1d(refused, np.setdiff1d(new, self._believed))
        self._solve(self._believed, self._s.closing)
        firm = self._believed[self._standing()]
        if len(firm) < len(self._believed):
            self._solve(firm, self._s.closing)
        return Mapped(self._poses, np.isin(np.arange(len(self._closures)), self._believed))

    def _standing(self) -> BoolArray:
        """Return which of the believed closures the rest of the map stands by: what each misses without itself."""
        some = self._closures[self._believed]
        spread = self._known(some, np.arange(len(some))) + some.covariance
        missed = between(self._poses[some.i], self._poses[some.j]) - some.relative
        missed[:, 2] = wrap_all(missed[:, 2])
        alone = (spread @ np.linalg.solve(some.covariance, missed[:, :, None]))[:, :, 0]
        chi2 = (alone * np.linalg.solve(spread, alone[:, :, None])[:, :, 0]).sum(axis=1)
        odds = log_odds(chi2, spread, self._volume) - np.log(crowding(self._poses, some, spread, self._volume))
        false = max(1, len(self._closures) - len(some))  # as good as all of the others, where it matters
        return np.asarray(odds >= np.log(self._s.standing * false / max(1, len(some))))
