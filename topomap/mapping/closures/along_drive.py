"""Claims as a recorded drive brings them: heard on the way, solved every so often, heard once more at the end."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from topomap.core.arrays import BoolArray, IntArray
from topomap.core.records import Candidate, Verdict
from topomap.mapping.closures.along_settings import AlongSettings
from topomap.mapping.closures.chance import probability
from topomap.mapping.closures.closure_tests import Knowledge
from topomap.mapping.closures.engine import ClosureEngine
from topomap.mapping.closures.gates import Gate, Supported
from topomap.mapping.closures.odds import mahalanobis
from topomap.mapping.closures.support import Support, support_of
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.optimizer import AxisEdge, OdometryEdges, OptimizerSettings, Problem, Solution, solve
from topomap.mapping.place_claims import PlaceClaims
from topomap.mapping.recorded_drive import RecordedDrive
from topomap.mapping.uncertainty.network import PathNetwork

# same-place loops see rotation, not distance: left free, the distance scale of a recording collapsed to 0.04
HELD = 1e-4
OFFSETS = (-0.5, 0.5, -1.0, 1.0)  # other starting curvatures, in sigmas of its prior


def map_along(drive: RecordedDrive, claims: PlaceClaims, settings: AlongSettings) -> tuple[AlongDrive, Solution]:
    """Map the drive; where few claims are inliers, also from other curvatures, and take where most are."""
    best = _from(drive, claims, settings, settings.start_curvature)
    for offset in OFFSETS:
        if best[0].inlier_share >= settings.min_believed:
            break
        other = _from(drive, claims, settings, settings.start_curvature + offset * settings.curvature_sigma)
        best = max(best, other, key=lambda end: end[0].inlier_share)
    return best if best[0].chance() <= settings.chance else best[0].given_up()


def _from(
    drive: RecordedDrive, claims: PlaceClaims, settings: AlongSettings, curvature: float
) -> tuple[AlongDrive, Solution]:
    mapping = AlongDrive(drive, claims, settings, curvature)
    mapping.grow()
    return mapping, mapping.close()


class AlongDrive:
    """The map of one drive as it grows; online (K + 1, 3): the poses at all stamps as they were known then."""

    def __init__(self, drive: RecordedDrive, claims: PlaceClaims, settings: AlongSettings, curvature: float) -> None:
        self._s, self._given = settings, settings.start_curvature
        self.drive, self.claims = drive, claims
        self._engine = ClosureEngine((Supported(), Gate(settings.gate.probability)))
        self.ledger = self._engine.ledger
        self.calibration = self._start = Calibration(curvature=curvature)
        self._sigmas = (settings.rotation_sigma, settings.curvature_sigma, HELD)
        self._poses = np.zeros((1, 3))
        self._active = np.zeros(0, np.int64)
        self._newest: int | None = None
        self._axes = self._straight() if settings.building_axes else ()
        self.online = np.zeros((len(drive.stamps_ns), 3))
        self.told = claims.known() & (claims.way(drive) >= settings.min_way)
        self.support: Support = support_of(claims, drive, np.flatnonzero(self.told), settings, self._start)
        self._candidates = [self._candidate(k) for k in range(len(claims))]
        self._waiting = self._sift()

    def _candidate(self, k: int) -> Candidate:
        plain = self.claims.candidate(k, self._s.closure_sigma)
        return replace(plain, evidence=replace(plain.evidence, support=float(self.support.share[k])))

    def _straight(self) -> tuple[AxisEdge, ...]:
        """Return the nodes on straight stretches, which the building's axes are taken to run along."""
        sigma = math.radians(self._s.axis_sigma_deg)
        nodes = np.flatnonzero(self.drive.straight(self._s.straight, sigma)[:-1])
        return tuple(AxisEdge(k, k + 1, sigma) for k in nodes.tolist())

    def _sift(self) -> IntArray:
        """Refuse what says nothing; return the others."""
        known, way = self.claims.known(), self.claims.way(self.drive)
        for k in np.flatnonzero(~known):
            self._decide(int(k), Verdict.REFUSED, "a stamp lies outside the recording")
        for k in np.flatnonzero(known & ~self.told):
            self._decide(int(k), Verdict.REFUSED, f"only {way[k]:.1f} m of way between: it says nothing")
        return np.flatnonzero(self.told)

    def _decide(self, k: int, verdict: Verdict, reason: str, stamp_ns: int | None = None) -> None:
        candidate = self._candidates[k]
        if self._engine.verdict(candidate) is not verdict:
            self._engine.decide(stamp_ns or candidate.query_ns, candidate, verdict, reason)

    def grow(self) -> None:
        """Follow the drive, with a solve every so often."""
        way, every = self.drive.way, self._s.every
        for piece in range(1, int(way[-1] / every) + 2):
            nodes = int(np.searchsorted(way, piece * every, side="right"))
            if nodes > len(self._poses):
                self._extend(nodes)
                self._hear(nodes)

    def _extend(self, nodes: int) -> None:
        first = len(self._poses) - 1
        self._poses = self.drive.extended(self._poses, nodes, self.calibration)
        _, poses = self.drive.between_nodes(self._poses, self.calibration, first)
        begin = int(self.drive.marks[first])
        self.online[begin : begin + len(poses)] = poses

    def _hear(self, nodes: int) -> None:
        """Weigh the newest claims and solve with all that stand."""
        newest = np.maximum(self.claims.query, self.claims.match)[self._waiting]
        new, self._waiting = self._waiting[newest < nodes], self._waiting[newest >= nodes]
        self._active = np.concatenate([self._active, self._weighed(new)])
        if len(self._active):
            solution = self._solve(self._active, self._s.growing)
            self._poses, self.calibration = solution.poses, solution.calibration
            self._note(self._active, solution.closure_weights > 0)

    def _weighed(self, new: IntArray) -> IntArray:
        """Return those of the new claims that neighbours support and odometry allows since the last inlier."""
        chain = self.drive.chain(self._poses, self.calibration, np.diag(np.array(self._sigmas) ** 2))
        own = self.claims.claims(new, self._s.closure_sigma)
        since = own.i if self._newest is None else np.full(len(new), self._newest)
        errors = PathNetwork.of_chain(chain).errors(since, own.j)
        nothing = np.zeros(len(new))
        knowledge = Knowledge(self._poses, errors, np.ones(len(new), np.int64), nothing, self.support.share[new])
        failed = self._engine.weigh(own, knowledge, 0.0).failed
        sigmas = np.sqrt(mahalanobis(own, self._poses, errors)[0])
        for n, k in enumerate(new.tolist()):
            if failed[n] == 0:
                self._decide(k, Verdict.REFUSED, self.support.reason(k))
                continue
            evidence = replace(self._candidates[k].evidence, sigmas=float(sigmas[n]))
            self._candidates[k] = replace(self._candidates[k], evidence=evidence)
            if failed[n] > 0:
                self._decide(k, Verdict.REFUSED, f"odometry contradicts it: {sigmas[n]:.1f} sigmas off")
        return np.asarray(new[failed < 0])

    def _solve(self, which: IntArray, settings: OptimizerSettings) -> Solution:
        count = len(self._poses) - 1
        edges = self.drive.edges
        some = OdometryEdges(edges.i[:count], edges.j[:count], edges.increments.first(count))
        problem = Problem(
            self._poses,
            some,
            self.claims.claims(which, self._s.closure_sigma).closures(),
            calibration=self.calibration,
            prior=self._start,
            prior_sigmas=self._sigmas,
            axes=tuple(axis for axis in self._axes if axis.i < count),
        )
        return solve(problem, settings)

    def _note(self, which: IntArray, inlier: BoolArray) -> None:
        """Write into the ledger what the optimizer made of some claims."""
        now = int(self.drive.node_stamps[len(self._poses) - 1])
        for k, fits in zip(which.tolist(), inlier.tolist(), strict=True):
            standing = self._engine.verdict(self._candidates[k])
            if fits:
                self._decide(k, Verdict.ACCEPTED, "it fits the map with all other closures", now)
            elif standing is Verdict.ACCEPTED:
                self._decide(k, Verdict.WITHDRAWN, "it no longer fits the map with the other closures", now)
            elif standing is None:
                self._decide(k, Verdict.PENDING, "it doesn't fit the map yet", now)
        if inlier.any():
            self._newest = int(self.claims.query[which[inlier]].max())

    def close(self) -> Solution:
        """Hear every claim near the map once more and solve for the last time."""
        gap = self._poses[self.claims.query, :2] - self._poses[self.claims.match, :2]
        near = np.flatnonzero(self.told & (np.hypot(gap[:, 0], gap[:, 1]) <= self._s.readmit))
        solution = self._solve(near, self._s.closing)
        self._poses, self.calibration = solution.poses, solution.calibration
        self._note(near, solution.closure_weights > 0)
        now = int(self.drive.node_stamps[-1])
        for k in np.setdiff1d(self._active, near).tolist():
            self._decide(k, Verdict.REFUSED, "it doesn't fit the finished map", now)
        for candidate in self.ledger.pending:
            self._engine.decide(now, candidate, Verdict.REFUSED, "it doesn't fit the finished map")
        return solution

    def given_up(self) -> tuple[AlongDrive, Solution]:
        """Withdraw every closure and return the drive as odometry has it: too few fit to mean anything."""
        now = int(self.drive.node_stamps[-1])
        reason = f"{len(self.ledger.accepted)} closures fit together: false ones may do so by chance"
        for candidate in self.ledger.accepted:
            self._engine.decide(now, candidate, Verdict.WITHDRAWN, reason)
        self.calibration = self._start = Calibration(curvature=self._given)
        self.online = self.drive.dead_reckoning(self._start)
        self._poses = self.online[self.drive.marks]
        return self, self._solve(np.zeros(0, np.int64), self._s.closing)

    @property
    def inlier_share(self) -> float:
        """The share of the supported claims that stands; 1 if there are none."""
        supported = int((self.support.share >= 1.0).sum())
        return len(self.ledger.accepted) / supported if supported else 1.0

    def chance(self) -> float:
        """Return the probability that so many closures stood if they joined any two places of the map."""
        _, poses = self.drive.between_nodes(self._poses, self.calibration)
        near = self._s.closing.cutoff * self._s.closure_sigma
        heard = int(self.told.sum())
        return probability(len(self.ledger.accepted), heard, poses, self.drive.travelled, near, self._s.min_way)

    @property
    def prior_sigmas(self) -> tuple[float, float, float]:
        """What was unknown of the calibration before any claim: claims of one place never show the distance scale."""
        return (*self._sigmas[:2], self._s.distance_sigma)
