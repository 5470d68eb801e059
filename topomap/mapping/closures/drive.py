"""A drive as the closure engine solves it: its odometry, what is unknown of it, and the map as it stands."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.records import UNKNOWN_HEADING
from topomap.mapping.closures.claims import Claims
from topomap.mapping.odometry.increments import Calibration, Preintegrated
from topomap.mapping.optimizer import AxisEdge, HeldSolver, OdometryEdges, OptimizerSettings, Problem, TurnEdge, solve
from topomap.mapping.uncertainty.odometry_chain import Chain

HELD = (1e-6, 1e-6, 1e-6)  # prior sigmas of an odometry that has no systematic error to find


@dataclass(frozen=True, slots=True, eq=False)
class MapState:
    """A map: poses (N, 3), the odometry's calibration and its covariance (3, 3)."""

    poses: FloatArray
    calibration: Calibration
    covariance: FloatArray


@dataclass(frozen=True, eq=False)
class Drive:
    """N places in travel order, 0 to N - 1, joined by odometry.

    poses (N, 3): by odometry alone with the calibration `prior`, which holds up to sigmas (3,) (see `Problem`); turns
    and axes: what else is known of headings.
    """

    poses: FloatArray
    edges: OdometryEdges
    prior: Calibration = field(default_factory=Calibration)
    sigmas: tuple[float, float, float] = HELD
    turns: tuple[TurnEdge, ...] = ()
    axes: tuple[AxisEdge, ...] = ()

    def start(self) -> MapState:
        """Return the map as odometry has it."""
        unknown = np.zeros((3, 3)) if self.held else np.diag(np.square(self.sigmas))
        return MapState(self.poses, self.prior, unknown)

    def chain(self, state: MapState) -> Chain:
        """Return the errors of odometry along a map."""
        if self.held:
            return Chain.held(state.poses, *self._firm)
        edges = (
            self._integrated if state.calibration == self.prior else self.edges.increments.integrate(state.calibration)
        )
        return Chain.of(state.poses, edges, state.calibration, state.covariance)

    def solve(self, state: MapState, closures: Claims, settings: OptimizerSettings) -> tuple[MapState, BoolArray]:
        """Return the map with closures, from a map as it was, and which of them (n,) are in. Raises TopomapError."""
        if self.held:
            ended = self.solver.solve(state.poses, closures.closures(), settings)
            return replace(state, poses=ended.poses), ended.inlier
        problem = Problem(
            state.poses,
            self.edges,
            closures.closures(),
            self.turns,
            state.calibration,
            self.prior,
            self.sigmas,
            axes=self.axes,
        )
        solution = solve(problem, settings)
        found = MapState(solution.poses, solution.calibration, solution.calibration_covariance)
        return found, solution.closure_weights > 0

    def less_sure(self, times: float) -> Drive:
        """Return the drive with odometry's sigmas so many times as large; of gaps nothing is known anyway."""
        increments, factor = self.edges.increments, times**2
        told = factor * increments.covariances[:, 2, 2] <= UNKNOWN_HEADING
        wider = np.where(told[:, None, None], factor, 1.0) * increments.covariances
        return replace(self, edges=replace(self.edges, increments=replace(increments, covariances=wider)))

    @cached_property
    def held(self) -> bool:
        """Whether the odometry has no systematic error to find."""
        return max(self.sigmas) <= max(HELD) and not self.turns and not self.axes

    @cached_property
    def _integrated(self) -> Preintegrated:
        return self.edges.increments.integrate(self.prior)

    @cached_property
    def _firm(self) -> tuple[FloatArray, FloatArray]:
        """The edges' noise (E, 3, 3) and lengths (E,) [m] with the calibration that they are taken to have."""
        steps = np.abs(self._integrated.forward) / self.prior.distance_scale
        return self._integrated.covariances(self.prior), steps

    @cached_property
    def solver(self) -> HeldSolver:
        """The solver for an odometry without systematic errors."""
        return HeldSolver(self.edges, self.prior)
