"""Correcting the map: what the back end is asked, when, and what is done with its answer."""

from __future__ import annotations

import math

import numpy as np
from pydantic import BaseModel, Field

from topomap.contract import Aligner, MotionReading
from topomap.geometry import FloatArray
from topomap.mapping.album import Album
from topomap.mapping.backend import (
    BackendSettings,
    ClosureEdge,
    Closures,
    OdometryEdge,
    Problem,
    Solution,
    TurnEdge,
    solve,
)
from topomap.mapping.backend.problem import PRIOR_SIGMAS
from topomap.mapping.calibration import RangeScale, RangeScaleSettings, calibration_state
from topomap.mapping.graph import TopoMap
from topomap.mapping.ledger import Ledger
from topomap.mapping.odometry import Calibration
from topomap.types import CalibrationState, Candidate, Decision, Float32Array, Verdict


class CorrectionSettings(BaseModel, frozen=True, extra="forbid"):
    """When the map is corrected and what the odometry's errors may be."""

    backend: BackendSettings = Field(default_factory=BackendSettings)
    ranges: RangeScaleSettings = Field(default_factory=RangeScaleSettings)
    every: int = Field(10, ge=1, description="nodes after which the map is solved though no loop was closed")
    turns: bool = Field(True, description="use the visual compass turn between neighbouring snapshots")
    turn_sigma_deg: float = Field(3.0, gt=0, description="error of such a turn [degree]")


class Correction:
    """Collects the evidence on the odometry's errors and solves for poses and calibration."""

    def __init__(self, settings: CorrectionSettings, aligner: Aligner, topo: TopoMap) -> None:
        self._s = settings
        self._aligner = aligner
        self._map = topo
        self._scale = RangeScale(settings.ranges)
        self._turns: list[TurnEdge] = []
        self._closures: list[tuple[ClosureEdge, Candidate]] = []
        self._covariance = np.diag(np.square(PRIOR_SIGMAS))
        self._solved_nodes = 0

    def watch(self, motion: MotionReading, ranges: Float32Array | None) -> None:
        """Take a raw increment with its ranges (W,): evidence on the distance scale."""
        self._scale.update(motion, ranges)

    def see_turn(self, a: int, b: int, album: Album) -> None:
        """Measure the turn between two neighbouring snapshots by sight: evidence on the turn errors."""
        if self._s.turns:
            seen = self._aligner.align(album.panorama(b), album.panorama(a), self._turned(a, b))
            self._turns.append(TurnEdge(a, b, seen.rotation, math.radians(self._s.turn_sigma_deg)))

    @property
    def due(self) -> bool:
        """Whether enough nodes have come since the last solve."""
        return len(self._map.nodes) - self._solved_nodes >= self._s.every

    def believe(self, edge: ClosureEdge, candidate: Candidate) -> None:
        """Put an accepted closure before the back end, from the next solve on."""
        self._closures.append((edge, candidate))

    def solve(self, stamp_ns: int, ledger: Ledger) -> tuple[bool, list[Decision]]:
        """Ask the back end; apply a better result; return whether there was one and which verdicts it changed."""
        self._solved_nodes = len(self._map.nodes)
        solution = solve(self._problem(), self._s.backend)
        self._covariance = solution.calibration_covariance
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
        scale = self._scale.estimate()
        sigmas = (PRIOR_SIGMAS[0], PRIOR_SIGMAS[1], scale.sigma / scale.value if scale.observed else PRIOR_SIGMAS[2])
        return Problem(
            self._map.poses.copy(),
            tuple(OdometryEdge(a, b, increments) for a, b, increments in self._map.odometry_edges()),
            Closures.of([edge for edge, _ in self._closures]),
            tuple(self._turns),
            self._map.calibration,
            Calibration(distance_scale=scale.value if scale.observed else 1.0),
            sigmas,
        )

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

    def _turned(self, a: int, b: int) -> float:
        """Return the turn from node a to node b by the map: where the visual search begins [rad]."""
        return self._map.pose(a).to(self._map.pose(b)).heading
