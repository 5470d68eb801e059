"""Correcting the map: what the back end is asked, when, and what is done with its answer."""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.records import CalibrationState, Candidate, Decision
from topomap.core.run_data import Trust
from topomap.mapping.believed import Believed
from topomap.mapping.closures.ledger import Ledger
from topomap.mapping.competition import BLIND, DEAD, Contest, compete
from topomap.mapping.graph import TopoMap
from topomap.mapping.odometry.calibration import calibration_state
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.odometry.known import KnownOdometer, honest
from topomap.mapping.odometry.noise import OdometerNoise
from topomap.mapping.optimizer import (
    ClosureEdge,
    Closures,
    OdometryEdge,
    OptimizerSettings,
    Problem,
    Recent,
    Slices,
    Solution,
    solving,
    solving_recent,
)
from topomap.mapping.optimizer.problem import PRIOR_SIGMAS
from topomap.mapping.sequential import SequentialConstraints
from topomap.mapping.solve_due import LARGE, OptimisationSettings, SolveDue
from topomap.vision.contracts import Aligner

BACKEND = OptimizerSettings()
STRETCH = 200  # odometry edges that are solved in between in a large map: up to 200 m


class Optimisation:
    """Collects the evidence on the odometry's errors and solves for poses and calibration.

    A small map is solved whole, within a step. Of a large one the newest stretch is; the whole is, when it has grown by
    a share, or a closure says something new or doesn't fit beside the stretch. Both are solved a slice a step, and the
    result applied then: after a number of steps that depends on the map alone, so that a replay does the same.
    """

    def __init__(self, settings: OptimisationSettings, aligner: Aligner, topo: TopoMap) -> None:
        self._map = topo
        topo.judge(OdometerNoise())
        self.sequential = SequentialConstraints(aligner, topo)
        self._closures = Believed(topo)
        self._covariance = np.diag(np.square(PRIOR_SIGMAS))
        self._running: Slices[Solution] | None = None
        self._stretch: Slices[tuple[Recent, list[int]]] | None = None
        self._due = SolveDue(settings)
        self._heard = 0  # closures that the last solve of all was asked of
        self.solves = 0
        self.contest: Contest | None = None
        self._known = KnownOdometer()

    def __getstate__(self) -> dict[str, object]:
        """Return what a copy takes along: what is being solved can't be copied, and is due anew there."""
        state = self.__dict__ | {"_running": None, "_stretch": None, "_due": copy(self._due)}
        if self._running is not None:
            state["_due"].give_up(whole=True)
        if self._stretch is not None:
            state["_due"].give_up(whole=False)
        return state

    def resume(self) -> None:
        """Take over a loaded map: its closures stand, and its calibration is what is known of the odometry.

        What this drive finds of its odometer leaves the edges of those before as they are.
        """
        self._known = KnownOdometer(self._map.calibration, len(self._map.chain) - 1)
        self._map.settle()
        self._due.recall(len(self._map.nodes))
        self._closures.recall()
        self._heard = len(self._closures)

    def update(self, stamp_ns: int, ledger: Ledger) -> tuple[bool, list[Decision]]:
        """Solve what is due; return whether the map was moved and which verdicts changed."""
        if self._running is None and self._stretch is None and self._due.whole(len(self._map.nodes), self._large):
            self._start()
            if self._large:
                return False, []
        if self._running is not None:
            return self._advance(stamp_ns, ledger)
        if self._stretch is None and self._large and self._due.stretch(len(self._map.nodes)):
            self._stretch = self._solving_stretch()
        if self._stretch is not None:
            return self._advance_stretch(stamp_ns, ledger)
        return False, []

    def believe(self, edge: ClosureEdge, candidate: Candidate) -> None:
        """Put an accepted closure before the back end, from the next solve on."""
        self._closures.add(edge, candidate)
        self._due.hear(candidate.evidence.sigmas or 0.0)

    def finish(self, stamp_ns: int, ledger: Ledger) -> None:
        """Solve the whole map a last time, and keep it unless a rival is better (`topomap.mapping.competition`)."""
        self.solve(stamp_ns, ledger)
        problem = replace(self._problem(), closures=self._closures.standing())
        scanned = self.sequential.scanned
        dead_reckoning = self._map.dead_reckoning() if self._known.before is None else None
        self.contest = compete(problem, dead_reckoning, scanned, BACKEND)
        if self.contest.kept == BLIND:
            self._map.weigh(scanned)
            self.solve(stamp_ns, ledger)
        if self.contest.kept == DEAD:
            self._fall_back(stamp_ns, ledger)

    def _fall_back(self, stamp_ns: int, ledger: Ledger) -> None:
        """Take odometry as read for the map, and every closure back."""
        self._closures.withdraw_all(stamp_ns, ledger, "dead reckoning predicts closures better")
        self._map.move(self._map.dead_reckoning(), Calibration())
        self._covariance = np.diag(np.square(PRIOR_SIGMAS))

    def abandon(self) -> None:
        """Give up what is being solved: the map isn't any more what it was asked of."""
        self._running = self._stretch = None
        self._heard = 0  # what a solve of all was asked that never ended, or in other places of the list

    def disbelieve(self, stamp_ns: int, ledger: Ledger, behind: set[int], reason: str) -> list[Decision]:
        """Take back for good what joins nodes `behind` a gap with others: it was seen by one who was elsewhere."""
        any_gone, changed = self._closures.forget(stamp_ns, ledger, behind, reason)
        if any_gone:
            self.abandon()  # it was asked of closures that are no more
        return changed

    def solve(self, stamp_ns: int, ledger: Ledger) -> tuple[bool, list[Decision]]:
        """Solve the whole map now; return whether it was moved and which verdicts changed."""
        self.abandon()
        self._start()
        found = None
        while self._running is not None:
            found = self._advance(stamp_ns, ledger)
        assert found is not None
        return found

    @property
    def _large(self) -> bool:
        return len(self._map.nodes) + len(self._closures) > LARGE

    def _start(self) -> None:
        self._due.begin(len(self._map.nodes), whole=True)
        self._running = self._solving_whole()

    def _solving_whole(self) -> Slices[Solution]:
        """Solve the whole map in slices."""
        self.sequential.weigh()
        yield
        self._heard = len(self._closures)
        problem, doubted = self._problem(), self._closures.doubted() if self._large else None
        yield
        return (yield from solving(problem, BACKEND, doubted))

    def _advance(self, stamp_ns: int, ledger: Ledger) -> tuple[bool, list[Decision]]:
        """Do one slice of a large map's solve, or all of a small one's; apply a better result at the end."""
        assert self._running is not None
        try:
            next(self._running)
            while not self._large:
                next(self._running)
        except StopIteration as end:
            self._running = None
            return self._apply(stamp_ns, ledger, end.value)
        return False, []

    def _apply(self, stamp_ns: int, ledger: Ledger, solution: Solution) -> tuple[bool, list[Decision]]:
        self.solves += 1
        self._covariance = honest(solution.calibration_covariance, self.sequential.distance_scale)
        if not solution.improved:
            return False, []
        self._map.move(solution.poses, solution.calibration, self._known.edges)
        return True, self._closures.review(stamp_ns, ledger, range(self._heard), solution.closure_weights)

    def _solving_stretch(self) -> Slices[tuple[Recent, list[int]]]:
        """Solve the newest stretch in slices; return what was found and which of the closures it was asked of."""
        self._due.begin(len(self._map.nodes), whole=False)
        yield  # the step in which a node came has enough to do
        self.sequential.weigh()
        yield
        edges = [OdometryEdge(*e) for e in self._map.edges_from(max(0, len(self._map.chain) - 1 - STRETCH))]
        ends = {edge.j for edge in edges}
        believed = self._closures.edges
        new = [k for k, edge in enumerate(believed) if edge.j in ends]
        closures = Closures.of([believed[k] for k in new])
        turns = self.sequential.turns[-STRETCH:]
        found = yield from solving_recent(self._map.poses, edges, closures, turns, self._map.calibration, BACKEND)
        return found, [new[k] for k in found.heard.tolist()]

    def _advance_stretch(self, stamp_ns: int, ledger: Ledger) -> tuple[bool, list[Decision]]:
        """Do one slice of the newest stretch's solve; apply a better result at the end."""
        assert self._stretch is not None
        try:
            next(self._stretch)
        except StopIteration as end:
            self._stretch = None
            self.solves += 1
            found, heard = end.value
            weights = found.solution.closure_weights
            out = [k for k, weight in zip(heard, weights, strict=True) if weight < 0.5]
            self._due.found(unfit=any(k >= self._heard for k in out))
            if not found.solution.improved:
                return False, []
            self._map.shift(found.nodes, found.solution.poses)
            return True, self._closures.review(stamp_ns, ledger, heard, weights)
        return False, []

    @property
    def covariance(self) -> FloatArray:
        """Covariance (3, 3) of `Calibration.vector` as the last solve left it."""
        return self._covariance

    @property
    def state(self) -> CalibrationState:
        """The calibration with its sigmas; observed where the data narrowed the prior to half."""
        return calibration_state(self._map.calibration, self._covariance, PRIOR_SIGMAS)

    @property
    def trust(self) -> Trust:
        """What the map makes of its evidence so far."""
        noise = self._map.noise
        return Trust("" if self.contest is None else self.contest.reason, noise.forward, noise.turn)

    def _problem(self) -> Problem:
        edges = self._map.odometry()
        return Problem(
            self._map.poses.copy(),
            edges,
            Closures.of(self._closures.edges),
            tuple(self.sequential.turns),
            self._map.calibration,
            *self._known.prior(self.sequential.distance_scale),
            others=self._known.others(len(edges)),
        )
