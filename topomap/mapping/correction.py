"""Correcting the map: what the back end is asked, when, and what is done with its answer."""

from __future__ import annotations

import numpy as np
from pydantic import BaseModel, Field

from topomap.contract import Aligner
from topomap.geometry import FloatArray
from topomap.mapping.backend import (
    BackendSettings,
    ClosureEdge,
    Closures,
    OdometryEdge,
    Problem,
    Solution,
    solve,
)
from topomap.mapping.backend.problem import PRIOR_SIGMAS
from topomap.mapping.calibration import calibration_state
from topomap.mapping.graph import TopoMap
from topomap.mapping.ledger import Ledger
from topomap.mapping.neighbours import Neighbours, NeighbourSettings
from topomap.mapping.odometry import Calibration
from topomap.types import CalibrationState, Candidate, Decision, Verdict

# places seen again tell nothing of the distance scale and would shrink the world (DESIGN.md): unmeasured it is held
HELD = 1e-4


class CorrectionSettings(BaseModel, frozen=True, extra="forbid"):
    """When the map is corrected and what the odometry's errors may be."""

    backend: BackendSettings = Field(default_factory=BackendSettings)
    neighbours: NeighbourSettings = Field(default_factory=NeighbourSettings)
    every: int = Field(10, ge=1, description="nodes after which the map is solved though nothing surprising happened")
    surprise: float = Field(1.0, ge=0, description="a closure further off than this is solved at once [sigmas]")


class Correction:
    """Collects the evidence on the odometry's errors and solves for poses and calibration."""

    def __init__(self, settings: CorrectionSettings, aligner: Aligner, topo: TopoMap) -> None:
        self._s = settings
        self._map = topo
        self.neighbours = Neighbours(settings.neighbours, aligner, topo)
        self._closures: list[tuple[ClosureEdge, Candidate]] = []
        self._covariance = np.diag(np.square(PRIOR_SIGMAS))
        self._solved_nodes = 0
        self.solves = 0
        self._surprised = False

    @property
    def due(self) -> bool:
        """Whether a closure told something new, or enough nodes have come since the last solve."""
        return self._surprised or len(self._map.nodes) - self._solved_nodes >= self._s.every

    def believe(self, edge: ClosureEdge, candidate: Candidate) -> None:
        """Put an accepted closure before the back end, from the next solve on."""
        self._closures.append((edge, candidate))
        self._surprised = self._surprised or candidate.scores["sigmas"] > self._s.surprise

    def solve(self, stamp_ns: int, ledger: Ledger) -> tuple[bool, list[Decision]]:
        """Ask the back end; apply a better result; return whether there was one and which verdicts it changed."""
        self._solved_nodes, self.solves = len(self._map.nodes), self.solves + 1
        self._surprised = False
        solution = solve(self._problem(), self._s.backend)
        self._covariance = self._honest(solution.calibration_covariance)
        if not solution.improved:
            return False, []
        self._map.move(solution.poses, solution.calibration)
        return True, self._review(stamp_ns, ledger, solution)

    @property
    def covariance(self) -> FloatArray:
        """Covariance (3, 3) of `Calibration.vector` as the last solve left it."""
        return self._covariance

    @property
    def state(self) -> CalibrationState:
        """The calibration with its sigmas; observed where the data narrowed the prior to half."""
        return calibration_state(self._map.calibration, self._covariance, PRIOR_SIGMAS)

    def _problem(self) -> Problem:
        scale = self.neighbours.distance_scale
        sigma = scale.sigma / scale.value if scale.observed else HELD
        return Problem(
            self._map.poses.copy(),
            tuple(OdometryEdge(a, b, increments) for a, b, increments in self._map.odometry_edges()),
            Closures.of([edge for edge, _ in self._closures]),
            tuple(self.neighbours.turns),
            self._map.calibration,
            Calibration(distance_scale=scale.value),
            (PRIOR_SIGMAS[0], PRIOR_SIGMAS[1], sigma),
        )

    def _honest(self, covariance: FloatArray) -> FloatArray:
        """Return the covariance (3, 3) of a solution; what was only held is as unknown as before."""
        if self.neighbours.distance_scale.observed:
            return covariance
        honest = covariance.copy()
        honest[2, :], honest[:, 2] = 0.0, 0.0
        honest[2, 2] = PRIOR_SIGMAS[2] ** 2
        return honest

    def _review(self, stamp_ns: int, ledger: Ledger, solution: Solution) -> list[Decision]:
        """Withdraw what the solution disbelieves and take back what it believes again; each stays for later solves."""
        changed = []
        for (edge, candidate), weight in zip(self._closures, solution.closure_weights.tolist(), strict=True):
            standing = edge in self._map.closures
            if weight < 0.5 and standing:
                self._map.open(edge)
                reason = "the back end can't fit it beside the other evidence"
                changed.append(ledger.decide(stamp_ns, candidate, Verdict.WITHDRAWN, reason))
            elif weight >= 0.5 and not standing:
                self._map.close(edge)
                changed.append(ledger.decide(stamp_ns, candidate, Verdict.ACCEPTED, "fits after all"))
        return changed
