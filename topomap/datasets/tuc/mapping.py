"""A recorded drive with bare loop candidates, through the same evidence, ledger and back end as the robot's own."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import Pose2, between
from topomap.core.records import CalibrationState, Estimate, Verdict
from topomap.core.run_data import NodeData, RunData
from topomap.datasets.tuc.drive import Drive
from topomap.datasets.tuc.loops import Loops
from topomap.datasets.tuc.recording import TucRecording
from topomap.datasets.tuc.settings import TucSettings
from topomap.mapping.closures.chance import probability
from topomap.mapping.closures.ledger import Ledger, key_of
from topomap.mapping.closures.odometry_gate import OdometryGate
from topomap.mapping.odometry.calibration import calibration_state
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.optimizer import AxisEdge, Closures, OdometryEdges, OptimizerSettings, Problem, Solution, solve

# same-place loops see rotation, not distance (DESIGN.md): the distance scale is held while solving
HELD = 1e-4
OFFSETS = (-0.5, 0.5, -1.0, 1.0)  # other starting curvatures, in sigmas of its prior


def map_tuc(
    recording: TucRecording, settings: TucSettings | None = None, versions: Mapping[str, str] | None = None
) -> RunData:
    """Map a recording and return it as a run at the odometry's stamps; the mapping never sees the truth."""
    chosen = settings or TucSettings()
    mapping, solution = _map(recording, chosen)
    drive, ledger = mapping.drive, mapping.ledger
    at = np.searchsorted(drive.stamps_ns, recording.stamps_ns)
    _, final = drive.between_nodes(solution.poses, solution.calibration)
    accepted = [(c.match, c.query, "closure") for c in ledger.accepted if c.query is not None]
    return RunData(
        world=recording.name + (" (building axes assumed)" if chosen.building_axes else ""),
        seed=None,
        config=chosen.model_dump(mode="json"),
        versions=dict(versions or {}),
        stamps_ns=recording.stamps_ns,
        dead_reckoning=drive.dead_reckoning(Calibration())[at],
        online=mapping.online[at],
        final=final[at],
        truth=None if recording.truth is None else recording.truth.at(recording.stamps_ns),
        nodes=_nodes(drive, solution.poses),
        edges=(*((e.i, e.j, "odometry") for e in drive.edges), *accepted),
        decisions=tuple(ledger.decisions),
        calibration=mapping.calibration_state(solution),
        graph_hash=_hash(solution, accepted),
        false_distance_m=2.0,
    )


def _map(recording: TucRecording, settings: TucSettings) -> tuple[TucMapping, Solution]:
    """Map the drive; where few loops are believed, also from other curvatures, and take where most are."""
    best = _from(recording, settings, settings.start_curvature)
    for offset in OFFSETS:
        if best[0].believed >= settings.min_believed:
            break
        other = _from(recording, settings, settings.start_curvature + offset * settings.curvature_sigma)
        best = max(best, other, key=lambda end: end[0].believed)
    return best if best[0].chance() <= settings.chance else best[0].given_up()


def _from(recording: TucRecording, settings: TucSettings, curvature: float) -> tuple[TucMapping, Solution]:
    mapping = TucMapping(recording, settings, curvature)
    mapping.grow()
    return mapping, mapping.close()


class TucMapping:
    """The map of one drive as it grows."""

    def __init__(self, recording: TucRecording, settings: TucSettings, curvature: float) -> None:
        self._s, self._given = settings, settings.start_curvature
        self.drive = Drive.of(recording)
        self.loops = Loops.of(recording, self.drive, settings, curvature)
        self.ledger = Ledger()
        self._gate = OdometryGate(settings.gate)
        self._calibration = self._start = Calibration(curvature=curvature)
        self._sigmas = (settings.rotation_sigma, settings.curvature_sigma, HELD)
        self._poses = np.zeros((1, 3))
        self._active = np.zeros(0, np.int64)
        self._newest: int | None = None
        self._axes = self._straight() if settings.building_axes else ()
        self.online = np.zeros((len(self.drive.stamps_ns), 3))
        self._candidates = [self.loops.candidate(k) for k in range(len(self.loops.query))]
        self._waiting = self._sift()

    def _straight(self) -> tuple[AxisEdge, ...]:
        """Return the nodes on straight stretches, which the building's axes are taken to run along."""
        sigma = math.radians(self._s.axis_sigma_deg)
        nodes = np.flatnonzero(self.drive.straight(self._s.straight, sigma)[:-1])
        return tuple(AxisEdge(k, k + 1, sigma) for k in nodes.tolist())

    def _sift(self) -> IntArray:
        """Refuse what says nothing and what no neighbour supports; return the others."""
        known, way = self.loops.known(), self.loops.way(self.drive)
        told, needed = self.loops.told(self.drive, self._s.min_way), self.loops.needed
        for k in np.flatnonzero(~known):
            self._decide(int(k), Verdict.REFUSED, "a stamp lies outside the recording")
        for k in np.flatnonzero(known & (way < self._s.min_way)):
            self._decide(int(k), Verdict.REFUSED, f"only {way[k]:.1f} m of way between: it says nothing")
        for k in np.flatnonzero(told & (self.loops.support < needed)):
            found = f"{self.loops.support[k]:.2f} of at least {needed:.2f}"
            self._decide(int(k), Verdict.REFUSED, f"too few neighbours along the way agree ({found})")
        return np.flatnonzero(told & (self.loops.support >= needed))

    def _decide(self, k: int, verdict: Verdict, reason: str, stamp_ns: int | None = None) -> None:
        candidate = self._candidates[k]
        if self.ledger.verdict(key_of(candidate)) is not verdict:
            self.ledger.decide(stamp_ns or candidate.query_ns, candidate, verdict, reason)

    def grow(self) -> None:
        """Follow the drive, with a solve every so often."""
        way, every = self.drive.way, self._s.every
        for piece in range(1, int(way[-1] / every) + 2):
            nodes = int(np.searchsorted(way, piece * every, side="right"))
            if nodes > len(self._poses):
                self._extend(nodes)
                self._listen(nodes)

    def _extend(self, nodes: int) -> None:
        first = len(self._poses) - 1
        self._poses = self.drive.extended(self._poses, nodes, self._calibration)
        _, poses = self.drive.between_nodes(self._poses, self._calibration, first)
        begin = int(self.drive.marks[first])
        self.online[begin : begin + len(poses)] = poses

    def _listen(self, nodes: int) -> None:
        """Let the newest loops through the gate and solve with all that stand."""
        newest = np.maximum(self.loops.query, self.loops.match)[self._waiting]
        new, self._waiting = self._waiting[newest < nodes], self._waiting[newest >= nodes]
        self._active = np.concatenate([self._active, self._gated(new)])
        if len(self._active):
            solution = self._solve(self._active, self._s.growing)
            self._poses, self._calibration = solution.poses, solution.calibration
            self._note(self._active, solution.closure_weights > 0)

    def _gated(self, new: IntArray) -> IntArray:
        """Return those of the new loops that odometry allows since the last loop that stands."""
        chain = self.drive.chain(self._poses, self._calibration, np.diag(np.array(self._sigmas) ** 2))
        match, query = self.loops.match[new], self.loops.query[new]
        since = match if self._newest is None else np.full(len(new), self._newest)
        covariance = chain.covariance(since, query)
        expected = between(self._poses[match], self._poses[query])
        passed = np.zeros(len(new), bool)
        for n, k in enumerate(new.tolist()):
            finding = self._gate.judge(self._candidates[k], Pose2.of(expected[n]), covariance[n])
            scores = {**self._candidates[k].scores, "odometry": finding.score}
            self._candidates[k] = replace(self._candidates[k], scores=scores)
            passed[n] = finding.passed
            if not finding.passed:
                self._decide(k, Verdict.REFUSED, finding.reason)
        return new[passed]

    def _solve(self, which: IntArray, settings: OptimizerSettings) -> Solution:
        closures: Closures = self.loops.closures(which)
        edges = self.drive.edges[: len(self._poses) - 1]
        return solve(
            Problem(
                self._poses,
                OdometryEdges.of(edges),
                closures,
                calibration=self._calibration,
                prior=self._start,
                prior_sigmas=self._sigmas,
                axes=tuple(axis for axis in self._axes if axis.i < len(edges)),
            ),
            settings,
        )

    def _note(self, which: IntArray, believed: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> None:
        """Write into the ledger what the back end made of some loops."""
        now = int(self.drive.node_stamps[len(self._poses) - 1])
        for k, fits in zip(which.tolist(), believed.tolist(), strict=True):
            standing = self.ledger.verdict(key_of(self._candidates[k]))
            if fits:
                self._decide(k, Verdict.ACCEPTED, "it fits the map with all other closures", now)
            elif standing is Verdict.ACCEPTED:
                self._decide(k, Verdict.WITHDRAWN, "it no longer fits the map with the other closures", now)
            elif standing is None:
                self._decide(k, Verdict.PENDING, "the back end doesn't believe it yet", now)
        if believed.any():
            self._newest = int(self.loops.query[which[believed]].max())

    def close(self) -> Solution:
        """Hear every loop near the map once more and solve for the last time."""
        told = self.loops.told(self.drive, self._s.min_way)
        gap = self._poses[self.loops.query, :2] - self._poses[self.loops.match, :2]
        near = np.flatnonzero(told & (np.hypot(gap[:, 0], gap[:, 1]) <= self._s.readmit))
        solution = self._solve(near, self._s.closing)
        self._poses, self._calibration = solution.poses, solution.calibration
        self._note(near, solution.closure_weights > 0)
        now = int(self.drive.node_stamps[-1])
        for k in np.setdiff1d(self._active, near).tolist():
            self._decide(k, Verdict.REFUSED, "it doesn't fit the finished map", now)
        for candidate in self.ledger.pending:
            self.ledger.decide(now, candidate, Verdict.REFUSED, "it doesn't fit the finished map")
        return solution

    def given_up(self) -> tuple[TucMapping, Solution]:
        """Withdraw every loop and return the drive as odometry has it from the start: too few fit to mean anything."""
        now = int(self.drive.node_stamps[-1])
        reason = f"{len(self.ledger.accepted)} loops fit together: false ones may do so by chance"
        for candidate in self.ledger.accepted:
            self.ledger.withdraw(now, key_of(candidate), reason)
        self._calibration = self._start = Calibration(curvature=self._given)
        self.online = self.drive.dead_reckoning(self._start)
        self._poses = self.online[self.drive.marks]
        return self, self._solve(np.zeros(0, np.int64), self._s.closing)

    @property
    def believed(self) -> float:
        """The share of the loops with support that stands; 1 if there are none."""
        supported = int((self.loops.support >= self.loops.needed).sum())
        return len(self.ledger.accepted) / supported if supported else 1.0

    def chance(self) -> float:
        """Return the probability that so many loops stood if they joined any two places of the map."""
        _, poses = self.drive.between_nodes(self._poses, self._calibration)
        told = int(self.loops.told(self.drive, self._s.min_way).sum())
        near = self._s.closing.cutoff * self._s.closure_sigma
        return probability(len(self.ledger.accepted), told, poses, self.drive.travelled, near, self._s.min_way)

    def calibration_state(self, solution: Solution) -> CalibrationState:
        """Return what is believed of the odometer; loops alone never show its distance scale."""
        priors = (*self._sigmas[:2], self._s.distance_sigma)
        state = calibration_state(solution.calibration, solution.calibration_covariance, priors)
        return replace(state, distance_scale=Estimate(1.0, self._s.distance_sigma, False))


def _nodes(drive: Drive, poses: FloatArray) -> tuple[NodeData, ...]:
    stamps = drive.node_stamps.tolist()
    return tuple(NodeData(k, stamps[k], poses[k], snapshot=False) for k in range(len(stamps)))


def _hash(solution: Solution, accepted: list[tuple[int, int, str]]) -> str:
    text = solution.poses.tobytes() + repr(sorted(accepted)).encode()
    return hashlib.sha256(text).hexdigest()
