"""Constraints between neighbouring snapshots: turn and distance, measured by scans or by sight."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Estimate
from topomap.mapping.graph import TopoMap
from topomap.mapping.measured_turns import MeasuredTurn
from topomap.mapping.odometry.calibration import DistanceScale
from topomap.mapping.odometry.increments import Calibration, Increments, integrate
from topomap.mapping.odometry.noise import OdometerNoise, declared, rolled
from topomap.mapping.optimizer import TurnEdge
from topomap.mapping.places.view_cache import ViewCache
from topomap.mapping.turn_evidence import SHARE_UNCHECKED, UNCHECKED, TurnEvidence
from topomap.vision.compass.epipolar_compass import EpipolarCompass
from topomap.vision.contracts import Aligner
from topomap.vision.homing.epipolar import ENOUGH
from topomap.vision.image.ground_line import ground_ranges, way_bias
from topomap.vision.matching.scan_match import MEASURED, SEEN, ScanMatch, match_scans

SCAN_TURN_SIGMA = math.radians(0.05)
"""[rad] Least error of a turn measured by ranges."""
FAR = math.radians(25.0)
"""[rad] A turn seen further from the odometer's lies where the search ends (30 degrees): no turn was found."""
DISTANCE_SIGMA = 0.02
"""[m] A distance measured less exactly isn't used: it is 2 to 8 % of the way between snapshots."""
MIN_WAY = 0.15
"""[m] Shortest way whose distance is used: of a shorter one the measurement's error is the greater part."""


class SequentialConstraints:
    """Compares each snapshot with the one before: by ranges, or else by two compasses and the ground line."""

    def __init__(self, aligner: Aligner, topo: TopoMap) -> None:
        self._aligner = aligner
        self._second = EpipolarCompass()
        self._map = topo
        self._before = tuple(topo.turns)  # those of a loaded map: what they were weighed by isn't kept
        self._scale = DistanceScale()
        self._evidence = TurnEvidence()
        self._by_ranges: set[tuple[int, int]] = set()
        self._weighed = 0

    @property
    def turns(self) -> list[TurnEdge]:
        """The turns measured so far, oldest first, as they were weighed last; the map keeps them."""
        return self._map.turns

    @property
    def scanned(self) -> list[TurnEdge]:
        """Those of the turns that ranges measured, and those of a loaded map, of which nobody knows."""
        own = self.turns[len(self._before) :]
        return [*self._before, *(turn for turn in own if (turn.i, turn.j) in self._by_ranges)]

    @property
    def distance_scale(self) -> Estimate:
        """The distance scale by all that was measured so far."""
        return self._scale.estimate()

    def compare(self, a: int, b: int, view_cache: ViewCache) -> TurnEdge | None:
        """Measure turn and distance from snapshot a to snapshot b, the next one; return the turn, if one was found."""
        before, now = view_cache.panorama(a), view_cache.panorama(b)
        guess = self._map.pose(a).to(self._map.pose(b)).array()
        way = self._map.way(a, b)
        match = None
        if before.ranges is not None and now.ranges is not None:
            match = match_scans(before.ranges, now.ranges, guess, MEASURED)
        turn = self._read(a, b, way)
        if match is None:
            return self._look(turn, way, before, now, guess)
        sigma = math.hypot(SCAN_TURN_SIGMA, match.covariance[2, 2] ** 0.5)
        self._by_ranges.add((a, b))
        self._measure(way, match)
        return self._take(turn, scanned=float(match.relative[2]), scan_sigma=sigma)

    def weigh(self) -> None:
        """Weigh all turns, and the odometer, by all that was measured so far."""
        if len(self._evidence) == self._weighed:
            return
        self._weighed = len(self._evidence)
        found = self._evidence.weigh()
        self._map.weigh([*self._before, *found.edges])
        turn, forward = _factor(found.odometer), _factor(self._scale.odometer())
        noise = OdometerNoise(turn if forward is None else forward, turn)
        if not noise.near(self._map.noise):
            self._map.judge(noise)

    def _read(self, a: int, b: int, way: Increments) -> MeasuredTurn:
        read = way.deltas.sum(axis=0)
        return MeasuredTurn(
            a, b, float(read[2]), float(read[0]), float(declared(way)[:, 2, 2].sum()), rolled(way)
        )  # fmt: skip

    def _look(
        self, turn: MeasuredTurn, way: Increments, before: Panorama, now: Panorama, guess: FloatArray
    ) -> TurnEdge | None:
        """Take the turn from two compasses and the distance from where the floor ends in both views."""
        seen = self._aligner.align(now, before, float(guess[2]))
        aligned = seen.rotation if seen.sharp and _near(seen.rotation, guess) else math.nan
        found = self._second.method.movement(
            self._second.method.describe(now), self._second.method.describe(before), float(guess[2]),
            self._second.window,
        )  # fmt: skip
        matched = found.rotation if found.points >= ENOUGH and _near(found.rotation, guess) else math.nan
        taken = self._take(turn, aligned=_beside(aligned, turn.read), matched=_beside(matched, turn.read))
        best = matched if math.isfinite(matched) else seen.rotation
        match = match_scans(ground_ranges(before), ground_ranges(now), np.array([guess[0], guess[1], best]), SEEN)
        if match is not None:
            self._measure(way, match, way_bias(now))
        return taken

    def _take(
        self, turn: MeasuredTurn, scanned: float = math.nan, scan_sigma: float = math.nan,
        aligned: float = math.nan, matched: float = math.nan,
    ) -> TurnEdge | None:  # fmt: skip
        """Keep a turn; until all are weighed next it counts as one that nothing checked."""
        self._evidence.add(replace(turn, scanned=scanned, scan_sigma=scan_sigma, aligned=aligned, matched=matched))
        value = next((v for v in (scanned, matched, aligned) if math.isfinite(v)), None)
        if value is None:
            return None
        sigma = math.hypot(UNCHECKED, SHARE_UNCHECKED * value) if math.isnan(scanned) else scan_sigma
        self.turns.append(TurnEdge(turn.i, turn.j, value, sigma))
        return self.turns[-1]

    def _measure(self, way: Increments, match: ScanMatch, bias: float = 0.0) -> None:
        """Compare the measured distance with the odometer's, where the surfaces constrain it."""
        measured = float(np.hypot(match.relative[0], match.relative[1]))
        if measured < MIN_WAY:
            return
        direction = match.relative[:2] / measured
        sigma = _along(direction, match.covariance)
        if sigma < DISTANCE_SIGMA:
            now = self._map.calibration
            told = Increments(way.stamps_ns, way.deltas, declared(way))
            read, covariance, _ = integrate(told, Calibration(now.rotation_scale, now.curvature))
            odometer = _along(direction, covariance)
            self._scale.add(float(np.hypot(read[0], read[1])), measured, sigma, bias, odometer)


def _along(direction: FloatArray, covariance: FloatArray) -> float:
    return math.sqrt(float(direction @ covariance[:2, :2] @ direction))


def _near(rotation: float, guess: FloatArray) -> bool:
    return abs(wrap(rotation - float(guess[2]))) < FAR


def _beside(rotation: float, read: float) -> float:
    """Return the same rotation [rad] as near the odometer's turn as it gets: that may be more than half a circle."""
    return read + wrap(rotation - read)


def _factor(told: tuple[float, float] | None) -> float | None:
    """Return what the declared variance is taken times: as declared where that may be, else the nearest that may."""
    if told is None:
        return None
    least, most = told
    if LITTLE < most < 1.0:
        return 1.0
    return max(min(max(1.0, least), most), FAINTEST)


LITTLE = 0.5
"""Greatest share of a declared variance from which on it is left as it is: too large a one costs nothing, and of some
seventy turns the scatter's variance errs by a third."""
FAINTEST = 1e-3
"""Least share of a declared variance: an odometer's errors are never zero."""
