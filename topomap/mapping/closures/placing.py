"""A start for the solve where a closure spans a gap in the odometry: the part behind the gap is moved as a whole."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import between, compose, wrap
from topomap.mapping.closures.claims import Claims
from topomap.mapping.uncertainty.odometry_chain import Chain

FAR_TURNED = 0.5  # heading error [rad] from which Gauss-Newton steps lead astray: a sine is off by a twentieth there
UNKNOWN = 1.0  # variance of heading [rad^2] from which on a step of the odometry tells nothing


def placed(poses: FloatArray, chain: Chain, new: Claims) -> FloatArray:
    """Return poses (N, 3) in which no new claim across a gap is turned far from what it says; chain: tells the gaps."""
    result = poses
    variance = np.diff(chain.random[:, 2, 2])
    if not bool((variance >= UNKNOWN).any()):
        return poses
    for i, j, claimed in zip(new.i.tolist(), new.j.tolist(), new.relative, strict=True):
        if abs(wrap(float(between(result[i], result[j])[2] - claimed[2]))) <= FAR_TURNED:
            continue
        weakest = int(np.argmax(variance[i:j]))
        # no gap: drift is the optimizer's, and moving parts one by one made it worse
        if variance[i + weakest] < UNKNOWN:
            continue
        first = i + 1 + weakest
        wanted = compose(result[i], claimed)
        result = result.copy()
        result[first:] = compose(wanted, between(result[j], result[first:]))
    return result
