"""A drive as the closure engine solves it: its odometry, what is unknown of it, and the map as it stands."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.mapping.closures.claims import Claims
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.optimizer import AxisEdge, OdometryEdges, OptimizerSettings, Problem, Solution, TurnEdge, solve
from topomap.mapping.uncertainty.odometry_chain import Chain

HELD = (1e-6, 1e-6, 1e-6)  # prior sigmas of an odometry that has no systematic error to find


@dataclass(frozen=True, slots=True, eq=False)
class MapState:
    """A map: poses (N, 3), the odometry's calibration and its covariance (3, 3)."""

    poses: FloatArray
    calibration: Calibration
    covariance: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
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
        return MapState(self.poses, self.prior, np.diag(np.square(self.sigmas)))

    def chain(self, state: MapState) -> Chain:
        """Return the errors of odometry along a map."""
        edges = self.edges.increments.integrate(state.calibration)
        return Chain.of(state.poses, edges, state.calibration, state.covariance)

    def solve(self, state: MapState, closures: Claims, settings: OptimizerSettings) -> tuple[MapState, Solution]:
        """Return the map with closures, from a map as it was, and the optimizer's own words on it."""
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
        return MapState(solution.poses, solution.calibration, solution.calibration_covariance), solution
