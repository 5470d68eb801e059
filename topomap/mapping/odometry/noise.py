"""The odometer's random errors: what it declares, judged by what ranges and views say of the same way.

Drivers declare zeros, constants or guesses. What is declared tells how errors are spread over the way; how large they
are is told by the data. Until it is, the odometer is taken for a poor one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.mapping.odometry.increments import EdgeIncrements, Increments

WIDE_FORWARD, WIDE_TURN = 0.04, math.radians(1.0)
"""[m and rad per square-root metre] A poor odometer: twice the simulator's errors."""
LEAST = 0.01
"""Share of a poor odometer's variance below which nothing declared is believed: a tenth of its error."""
HALF_TRACK = 0.15  # [m] what wheels roll per radian of turning on the spot, in a robot of 0.3 m
MUCH = 0.1
"""Relative change of a variance from which on it is worth judging all increments anew."""


@dataclass(frozen=True, slots=True)
class OdometerNoise:
    """Factors on the declared variances of way and turn; None: not known yet, what is declared may only be widened."""

    forward: float | None = None
    turn: float | None = None

    def near(self, other: OdometerNoise) -> bool:
        """Return whether two say nearly the same."""
        pairs = ((self.forward, other.forward), (self.turn, other.turn))
        return all(
            a == b or (a is not None and b is not None and abs(math.log(a / b)) < MUCH) for a, b in pairs
        )  # fmt: skip

    def judged(self, increments: Increments) -> Increments:
        """Return the increments with the covariances that the data leaves them."""
        return Increments(increments.stamps_ns, increments.deltas, self.covariances(increments))

    def covariances(self, increments: Increments | EdgeIncrements) -> FloatArray:
        """Return the covariances (K, 3, 3) that the data leaves the increments."""
        covariances, wide = declared(increments), _wide(increments)
        shares = [self.forward, self.forward, self.turn]
        scale = np.array([1.0 if share is None else math.sqrt(share) for share in shares])
        covariances = covariances * np.outer(scale, scale)
        for axis, share in enumerate(shares):
            if share is None:
                covariances[:, axis, axis] = np.maximum(covariances[:, axis, axis], wide[:, axis])
        return covariances


AS_DECLARED = OdometerNoise(1.0, 1.0)
"""For maps that were judged when they were made."""


def rolled(increments: Increments) -> float:
    """Return how far the wheels went [m], turning included."""
    return float(_rolled(increments).sum())


def declared(increments: Increments | EdgeIncrements) -> FloatArray:
    """Return the covariances (K, 3, 3) as declared, but for what no odometer reaches."""
    covariances = increments.covariances.copy()
    least = LEAST * _wide(increments)
    for axis in range(3):
        covariances[:, axis, axis] = np.maximum(covariances[:, axis, axis], least[:, axis])
    return covariances


def _rolled(increments: Increments | EdgeIncrements) -> FloatArray:
    forward, left, turn = np.abs(increments.deltas).T
    return np.asarray(forward + left + HALF_TRACK * turn)


def _wide(increments: Increments | EdgeIncrements) -> FloatArray:
    """Return a poor odometer's variances (K, 3) of forward, left, turn."""
    forward = WIDE_FORWARD**2 * _rolled(increments)
    return np.column_stack([forward, forward / 16, WIDE_TURN**2 * _rolled(increments)])
