"""The objective: all residuals at a state, what each counts, and how far off they are together."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import wrap_all
from topomap.mapping.odometry.increments import Calibration, Preintegrated
from topomap.mapping.optimizer.calibration_jacobian import calibration_jacobian
from topomap.mapping.optimizer.problem import Problem
from topomap.mapping.optimizer.residuals import (
    Residuals,
    axis_residuals,
    closure_residuals,
    odometry_residuals,
    turn_residuals,
)
from topomap.mapping.uncertainty.odometry_chain import Chain

FIRM = 1e-5  # prior sigmas up to which a calibration is held


def geman_mcclure(chi2: FloatArray, cutoff: float | FloatArray) -> FloatArray:
    """Return the weights (n,) of squared errors (n,) (Yang et al. 2020, eq. 12, mu c^2 = cutoff^2).

    cutoff: one for all or one each (n,).
    """
    return np.asarray((cutoff**2 / (chi2 + cutoff**2)) ** 2)


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """An estimate: poses (N, 3) and calibration."""

    poses: FloatArray
    calibration: Calibration

    def stepped(self, poses: FloatArray, calibration: FloatArray, length: float) -> State:
        """Return the state moved by a share of a step of poses (N, 3) and calibration (3,)."""
        moved = self.poses + length * poses
        moved[:, 2] = wrap_all(moved[:, 2])
        return State(moved, Calibration.of(self.calibration.vector() + length * calibration))


@dataclass(frozen=True, slots=True, eq=False)
class Linearised:
    """All residuals at a state, and how the poses move with the calibration (N, 3, 3) if odometry alone counts."""

    odometry: Residuals
    closures: Residuals
    turns: Residuals
    axes: Residuals
    prior: FloatArray
    calibration_jacobian: FloatArray


class Objective:
    """A problem in one piece: evaluates and linearises it at any state.

    pairs (E, 2): the odometry edges' nodes; order (E + 1,): the nodes in travel order; turn_on_edge, axis_on_edge:
    which measured turns and axes join neighbours on the way, each edge's first; turn_cutoffs, axis_cutoff: beyond which
    they fade out [sigmas]; sigmas (3,): of the calibration's prior.
    """

    def __init__(self, problem: Problem, turn_cutoff: float) -> None:
        self.problem = problem
        self._edges = problem.odometry.increments
        self.pairs = np.column_stack([problem.odometry.i, problem.odometry.j])
        self._turn_pairs = _pairs([(t.i, t.j) for t in problem.turns])
        self._turns = np.array([(t.turn, t.sigma) for t in problem.turns]).reshape(-1, 2)
        self._axis_pairs = _pairs([(a.i, a.j) for a in problem.axes])
        self._axis_sigmas = np.array([a.sigma for a in problem.axes])
        self.sigmas = np.array(problem.prior_sigmas)
        self.order = np.append(self.pairs[:, 0], self.pairs[-1:, 1])
        self.turn_on_edge = self._on_edge(self._turn_pairs)
        self.axis_on_edge = self._on_edge(self._axis_pairs)
        self.turn_cutoffs = turn_cutoff * np.sqrt(1.0 + self._turn_allowance() / self._turns[:, 1] ** 2)
        self.axis_cutoff = turn_cutoff

    @property
    def held(self) -> FloatArray | None:
        """The calibration's covariance (3, 3) where the problem holds it: no closure can tell anything of it then."""
        return np.diag(self.sigmas**2) if float(self.sigmas.max()) <= FIRM else None

    def _on_edge(self, pairs: IntArray) -> BoolArray:
        """Return which of some pairs (n, 2) are neighbours on the way, in its direction, each edge's first only."""
        place = np.full(len(self.problem.poses), -2)
        place[self.order] = np.arange(len(self.order))
        beside = (place[pairs[:, 1]] - place[pairs[:, 0]] == 1) & (place[pairs[:, 0]] >= 0)
        first = np.zeros(len(pairs), bool)
        first[np.unique(pairs[:, 0], return_index=True)[1]] = True
        return np.asarray(beside & first)

    def _turn_allowance(self) -> FloatArray:
        """Return (n,) the variance [rad^2] that odometry itself has over each measured turn.

        It widens the turn's cutoff: before the odometry is calibrated, a correct turn may disagree with it by many of
        the turn's own sigmas, and would be faded out as an outlier.
        """
        if not len(self._turns):
            return np.zeros(0)
        edges = self._by_problem
        place = np.zeros(len(self.problem.poses), np.int64)
        place[self.order] = np.arange(len(self.order))
        i, j = place[self._turn_pairs].T

        def between(values: FloatArray) -> FloatArray:
            sums = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
            return np.asarray(sums[j] - sums[i])

        random = between(edges.covariances(self.problem.calibration)[:, 2, 2])
        systematic = between(edges.jacobians(self.problem.calibration)[:, 2])
        return np.asarray(np.abs(random) + systematic**2 @ self.sigmas**2)

    def chain(self) -> tuple[Chain, IntArray]:
        """Return the travelled chain by the problem's own estimate, and each node's (N,) place in it."""
        order = self.order
        edges = self._by_problem
        covariance = np.diag(self.sigmas**2)
        chain = Chain.of(self.problem.poses[order], edges, self.problem.calibration, covariance)
        position = np.zeros(len(self.problem.poses), np.int64)
        position[order] = np.arange(len(order))
        return chain, position

    def start(self) -> State:
        """Return the problem's own estimate."""
        return State(self.problem.poses, self.problem.calibration)

    def linearise(self, state: State) -> Linearised:
        """Return every residual at the state."""
        i, j = self._turn_pairs[:, 0], self._turn_pairs[:, 1]
        odometry = self._odometry(state)
        return Linearised(
            odometry,
            closure_residuals(state.poses, self.problem.closures),
            turn_residuals(state.poses, i, j, self._turns[:, 0], self._turns[:, 1]),
            axis_residuals(state.poses, self._axis_pairs[:, 0], self._axis_pairs[:, 1], self._axis_sigmas),
            state.calibration.vector() - self.problem.prior.vector(),
            calibration_jacobian(odometry, state.poses, self.problem.anchor),
        )

    def _odometry(self, state: State) -> Residuals:
        edges = self._edges.integrate(state.calibration)
        own = odometry_residuals(state.poses, state.calibration, self.pairs, edges)
        if self.problem.others is None:
            return own
        known = odometry_residuals(state.poses, self.problem.calibration, self.pairs, self._by_problem)
        return own.with_others(known, self.problem.others)

    @cached_property
    def _by_problem(self) -> Preintegrated:
        """The odometry edges by the problem's own calibration."""
        return self._edges.integrate(self.problem.calibration)

    def turn_weights(self, at: Linearised) -> FloatArray:
        """Return (T,) what each measured turn counts: 1 where it fits, less the further it is off."""
        return geman_mcclure(at.turns.chi2(), self.turn_cutoffs)

    def error(self, at: Linearised, weights: FloatArray) -> float:
        """Return the squared error with closure weights (M,)."""
        return self._firm(at) + float(weights @ at.closures.chi2())

    def truncated_error(self, at: Linearised, cutoff: float) -> float:
        """Return the squared error in which a closure costs at most cutoff^2 times its weight."""
        limit = cutoff**2 * self.problem.closures.weight
        return self._firm(at) + float(np.minimum(at.closures.chi2(), limit).sum())

    def _firm(self, at: Linearised) -> float:
        prior = float(((at.prior / self.sigmas) ** 2).sum())
        faded = _faded(at.turns, self.turn_cutoffs) + _faded(at.axes, self.axis_cutoff)
        return float(at.odometry.chi2().sum()) + faded + prior


def _faded(blocks: Residuals, cutoff: float | FloatArray) -> float:
    """Return the error of residuals that fade out (Geman-McClure) beyond a cutoff, one for all or one each (n,)."""
    chi2, cutoff2 = blocks.chi2(), np.square(cutoff)
    return float((chi2 * cutoff2 / (chi2 + cutoff2)).sum())


def _pairs(pairs: list[tuple[int, int]]) -> IntArray:
    return np.array(pairs, np.int64).reshape(-1, 2)
