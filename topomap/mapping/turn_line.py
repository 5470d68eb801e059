"""How turns seen follow the odometer's: gain, bend, and what they scatter by."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.mapping.measured_turns import Columns
from topomap.mapping.odometry.calibration import MAD_TO_SIGMA
from topomap.mapping.optimizer.problem import PRIOR_SIGMAS
from topomap.mapping.turn_kernels import middle_size, reweighted

FEWEST = 12
"""Turns before their own scatter is believed: of twelve, a MAD errs by a third ..."""
YOUNG = 3.0
"""... and is widened for it: variances by 1 + 3/sqrt(n)."""
EXPECTED = (0.15, 0.03)
"""How far gain and bend [rad/m] may lie from what is expected: three times the odometers'. Where a robot always turns
the same way at the same rate, the two can't be told apart otherwise."""
UNEXPECTED = 10.0
"""How far the inverse gain may lie from what is expected where it is only asked what it can't be: anywhere."""
FIT_STEPS = 15
"""Re-weightings of a fit (Cauchy's weights, squared): by then the scatter changes in its third digit."""
DISMISSED = 3.0
"""Sigmas of rotation scale and fit beyond which a method's turns and the odometer's don't belong together."""


class Line(NamedTuple):
    """turn = gain * read + bend * forward: gain and bend [rad/m] with sigmas, scatter [rad], number of turns.

    off (n,): what each turn lies beside the line [rad], NaN where there is none.
    """

    gain: float
    gain_sigma: float
    bend: float
    bend_sigma: float
    scatter: float
    number: int
    off: FloatArray

    @property
    def known(self) -> bool:
        """Whether there were enough turns to tell anything."""
        return self.number >= FEWEST

    @property
    def variance(self) -> float:
        """The scatter's variance [rad^2], widened as few turns tell it."""
        return self.scatter**2 * (1.0 + YOUNG / math.sqrt(max(self.number, 1)))

    @property
    def possible(self) -> bool:
        """Whether an odometer's rotation scale explains the gain."""
        return not self.known or abs(self.gain - 1.0) <= DISMISSED * math.hypot(PRIOR_SIGMAS[0], self.gain_sigma)


def line(turns: FloatArray, c: Columns, gain: float) -> Line:
    """Fit turns (n,) by the odometer's, robustly; NaN turns don't count; gain: what is expected.

    Both err, so that a fit of one by the other finds too small a gain: none at all along a corridor, where the
    odometer's turns are nothing but its errors. The gain lies between that of this fit and that of the opposite one
    (Frisch 1934); of these, it is the one nearest to what is expected.
    """
    known: BoolArray = np.isfinite(turns)
    count = int(known.sum())
    if count < FEWEST:
        return Line(gain, math.inf, 0.0, math.inf, 0.0, count, np.full(len(turns), np.nan))
    seen, read, forward = turns[known], c.read[known], c.forward[known]
    found = _fitted(seen - gain * read, np.column_stack([read, forward]), EXPECTED)
    steep, bend, scatter = gain + float(found.fit[0]), float(found.fit[1]), found.scatter
    if gain:
        steep = _nearest(gain, steep, _opposite(seen, read, forward, gain))
        straight = _fitted(seen - steep * read, forward[:, np.newaxis], EXPECTED[1:])
        bend, scatter = float(straight.fit[0]), straight.scatter
    gain_sigma, bend_sigma = (scatter / found.scatter * found.sigmas).tolist()
    return Line(steep, gain_sigma, bend, bend_sigma, scatter, count, turns - steep * c.read - bend * c.forward)


def _opposite(seen: FloatArray, read: FloatArray, forward: FloatArray, gain: float) -> float:
    """Return the most that the gain can be by the odometer's turns fitted by the ones seen: infinite where these tell
    nothing, as where the robot went straight on.
    """
    found = _fitted(read - seen / gain, np.column_stack([seen, forward]), (UNEXPECTED, EXPECTED[1]))
    least = 1.0 / gain + float(found.fit[0]) - DISMISSED * float(found.sigmas[0])
    return 1.0 / least if least > 0.0 else math.inf


def _nearest(value: float, one: float, other: float) -> float:
    """Return what is nearest to a value between two others."""
    return min(max(value, min(one, other)), max(one, other))


class Fitted(NamedTuple):
    """A robust fit (m,) with sigmas (m,), and the scatter about it."""

    fit: FloatArray
    sigmas: FloatArray
    scatter: float


def _fitted(values: FloatArray, design: FloatArray, expected: Sequence[float]) -> Fitted:
    """Fit values (n,) by a design (n, m) with Cauchy's weights; expected (m,): how far from 0 the fit may lie."""
    fit, scatter = np.zeros(design.shape[1]), 0.0
    prior, information = np.diag(1.0 / np.square(expected)), np.eye(design.shape[1])
    for _ in range(FIT_STEPS):
        left = values - design @ fit
        scatter = max(MAD_TO_SIGMA * middle_size(left), 1e-6)
        weighed, told = reweighted(left, values, design, scatter)
        information = weighed.T @ design + scatter**2 * prior
        fit = np.asarray(np.linalg.solve(information, design.T @ told))
    return Fitted(fit, scatter * np.sqrt(np.diag(np.linalg.inv(information))), scatter)
