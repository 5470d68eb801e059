"""What turns between neighbouring snapshots are worth, as the drive's own data tells.

A turn is measured by up to three instruments: the odometer, the aligner (min-warping by default) and the epipolar
compass. None of their errors is known beforehand: a camera in a hall, one in a bare corridor and one in grass differ
tenfold. But three instruments that err independently tell one another's errors (the "three-cornered hat": the
variance of f - o is that of f plus that of o, and so on for each pair). A method whose turns the odometer's can't be a
multiple of is dismissed, one that can't be checked is believed less.

A compass also errs by a share of the turn, the same at every corner of a building alike, and by a little the same way
along every straight. Such errors don't average out: all turns together tell no more of the rotation scale and of the
curvature than they leave.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.mapping.measured_turns import Columns, MeasuredTurn
from topomap.mapping.odometry.calibration import MAD_TO_SIGMA
from topomap.mapping.odometry.noise import WIDE_TURN
from topomap.mapping.optimizer.problem import TurnEdge
from topomap.mapping.turn_line import YOUNG, Line, line

FINEST = math.radians(0.1)
"""[rad] Least error of a turn seen: a fifth of a column of 720. The epipolar compass erred by 0.03 to 0.07 in three
worlds, the aligner by 0.07 to 0.24."""
UNCHECKED = math.radians(1.5)
"""[rad] Error of a turn seen while nothing tells it: 0.3 to 1.7 degrees over photographs, grass and rooms."""
SHARE, SHARE_UNCHECKED = 0.015, 0.1
"""Common error of all turns seen, as a share of the turn, where two methods agree and where there is one alone: the
aligner under-turned by 14 % at a corridor's bare corners and by 1 to 2 % elsewhere, the epipolar compass by 0 to 2 %.
"""
BEND, BEND_UNCHECKED = 0.0005, 0.002
"""[rad/m] Common error of all turns seen, per way: along an office's straight corridors the aligner read 0.1 degrees
a metre too little, the epipolar compass 0.03. Believed as independent, 600 such turns shift rotation scale by 3 %."""
WORST_ODOMETER = math.radians(1.5)
"""[rad per square-root m] What an odometer may err by: three times the simulator's. Two methods that see the same two
views far apart go wrong together (photographs 1 m apart: by 6 to 10 degrees, and by 2 from one another), and the
odometer would be blamed for it."""
COMMON = 0.1
"""Least share of what two methods differ by that is each one's: in grass they shared a tenth of it."""
AMBIGUOUS = 0.3
"""Share of its greatest variance below which an odometer's least one says nothing of it."""
DISAGREE = 3.0
"""Sigmas beyond which two methods contradict one another: then the turn is as unsure as they are apart, else by the
better one's part of that at least."""


class Weighed(NamedTuple):
    """Turns with sigmas, and the variance of the odometer's turn over the declared one: least and most it can be."""

    edges: tuple[TurnEdge, ...]
    odometer: tuple[float, float] | None


class TurnEvidence:
    """Collects measured turns and weighs all of them anew when asked."""

    def __init__(self) -> None:
        self._count = 0
        self._ends: list[tuple[int, int]] = []
        self._rows = np.zeros((64, len(Columns._fields)))
        self._edges: list[TurnEdge | None] = []  # as weighed last, None for a turn that nothing measured
        self._weighed = np.zeros((0, 2))  # the edges' turns and sigmas

    def add(self, turn: MeasuredTurn) -> None:
        """Take one more; the newest last."""
        if self._count == len(self._rows):
            self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)])
        self._rows[self._count] = turn.row()
        self._ends.append((turn.i, turn.j))
        self._count += 1

    def __len__(self) -> int:
        return self._count

    def weigh(self) -> Weighed:
        """Return what each turn is worth by all that was measured so far."""
        c = Columns.of_rows(self._rows[: self._count])
        seen = _seen(c)
        by_scan = np.isfinite(c.scanned)
        value, sigma = np.where(by_scan, c.scanned, seen.turns), np.where(by_scan, c.scan_sigma, seen.sigmas)
        return Weighed(
            self._as_edges(np.column_stack([value, sigma])),
            _told(c, line(c.scanned, c, 1.0), 0.0) or seen.odometer,
        )

    def _as_edges(self, weighed: FloatArray) -> tuple[TurnEdge, ...]:
        """Return turns with sigmas (n, 2) as edges; those that say what they said before are the same objects."""
        known = len(self._edges)
        same = (weighed[:known].view(np.int64) == self._weighed.view(np.int64)).all(axis=1)
        self._edges += [None] * (len(weighed) - known)
        for k in [*np.flatnonzero(~same).tolist(), *range(known, len(weighed))]:
            turn, sigma = weighed[k].tolist()
            i, j = self._ends[k]
            self._edges[k] = TurnEdge(i, j, turn, sigma) if math.isfinite(turn) else None
        self._weighed = weighed
        return tuple(edge for edge in self._edges if edge is not None)


class Seen(NamedTuple):
    """Turns by sight (n,) with sigmas (n,) [rad]; odometer: as in `Weighed`."""

    turns: FloatArray
    sigmas: FloatArray
    odometer: tuple[float, float] | None


def _seen(c: Columns) -> Seen:
    """Return the turns seen, each by the better of both methods."""
    both_ways = [c.aligned, c.matched]
    lines = [line(turns, c, 1.0) for turns in both_ways]
    methods = [np.where(one.possible, turns, np.nan) for one, turns in zip(lines, both_ways, strict=True)]
    apart = methods[0] - methods[1]
    between = line(apart, c, 0.0)
    checked = between.known and lines[0].known and lines[1].known
    ranges = _hat(lines, between, c) if checked else [_alone(one) for one in lines]
    declared = float(np.median(c.variance)) if len(c.variance) else 0.0
    # what the odometer declares is taken for true as far as it can be, so that both are believed little where the
    # data doesn't say which of them errs
    variances = [min(max(one.scatter**2 - declared, low), high) for one, (low, high) in zip(lines, ranges, strict=True)]
    best = int(variances[1] < variances[0])
    first = np.isfinite(methods[best])
    turns = np.where(first, methods[best], methods[1 - best])
    own = np.sqrt(np.where(first, variances[best], variances[1 - best]))
    part = math.sqrt(variances[best] / sum(variances))
    doubt = np.where(np.abs(apart) > DISAGREE * max(between.scatter, FINEST), 1.0, part) * np.nan_to_num(np.abs(apart))
    own = np.maximum(own, doubt) if checked else own
    share, bend = SHARE_UNCHECKED, BEND_UNCHECKED
    if checked:
        share = math.hypot(SHARE, part * _beyond(between.gain, between.gain_sigma))
        bend = math.hypot(BEND, part * _beyond(between.bend, between.bend_sigma))
    shared = np.hypot(share * np.abs(turns) * _alike(turns), bend * np.abs(c.forward) * _alike(c.forward))
    odometer = _told(c, lines[best], ranges[best][1]) if lines[best].possible else None
    return Seen(turns, np.hypot(own, shared), odometer)


def _beyond(value: float, sigma: float) -> float:
    """Return how much of a value stands out of its own error (two sigmas)."""
    return math.sqrt(max(value**2 - (2.0 * sigma) ** 2, 0.0))


def _alike(sizes: FloatArray) -> float:
    """Return the root of how many turns share an error that grows with their size (turn or way).

    So much wider, all of them together tell what one does.
    """
    squares = np.nan_to_num(sizes) ** 2
    return math.sqrt(max(float(squares.sum() ** 2 / max(float((squares**2).sum()), 1e-18)), 1.0))


def _hat(lines: Sequence[Line], between: Line, c: Columns) -> list[tuple[float, float]]:
    """Return both methods' variances [rad^2], least and most, from those of all differences.

    Half of what they differ by is each one's, but for what they differ from the odometer unlike by; that counts as far
    as it stands out of the scatter of so many turns. As much again they may err together, and whatever an odometer
    can't.
    """
    a, b = (one.scatter**2 for one in lines)
    difference, chance = a - b, 0.5 * (a + b) * 2.0 / math.sqrt(between.number)
    difference *= difference**2 / (difference**2 + chance**2)
    finest = max(COMMON * between.variance, 0.75 * chance, FINEST**2)
    worst = WORST_ODOMETER**2 * float(np.median(c.rolled))
    ranges = []
    for one, sign in zip(lines, (1.0, -1.0), strict=True):
        least = max(0.5 * (between.variance + sign * difference), one.variance - worst, finest)
        ranges.append((least, least + between.variance))
    return ranges


def _alone(one: Line) -> tuple[float, float]:
    """Return the variance [rad^2] of a method that only the odometer checks: all they differ by is put down to it."""
    variance = max(one.variance, FINEST**2) if one.known else UNCHECKED**2
    return variance, variance


def _told(c: Columns, one: Line, variance: float) -> tuple[float, float] | None:
    """Return the odometer's variance of a turn over the declared one, least and most, by one method's turns.

    variance: what the method's own may be at most [rad^2]. Where that may explain all, a poor odometer's is the least.
    """
    told = np.isfinite(one.off) & (c.variance > 0.0)
    if not one.known or not told.any():
        return None
    declared = c.variance[told]
    scatter = (MAD_TO_SIGMA * float(np.median(np.abs(one.off[told]) / np.sqrt(declared)))) ** 2
    worst, poor = (float(np.median(wide**2 * c.rolled[told] / declared)) for wide in (WORST_ODOMETER, WIDE_TURN))
    most = min(scatter * (1.0 + YOUNG / math.sqrt(one.number)), worst)
    least = max(scatter - variance * float(np.median(1.0 / declared)), 0.0)
    return min(poor if least < AMBIGUOUS * most else least, most), most
