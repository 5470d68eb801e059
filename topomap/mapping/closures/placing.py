"""A start for the solve where a closure turns the map far: the part behind the weakest step is moved as a whole."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import between, compose, wrap
from topomap.mapping.closures.claims import Claims
from topomap.mapping.uncertainty.odometry_chain import Chain

FAR_TURNED = 0.5  # heading error [rad] from which Gauss-Newton steps lead astray: a sine is off by a twentieth there


def placed(poses: FloatArray, chain: Chain, new: Claims) -> FloatArray:
    """Return poses (N, 3) in which no new claim is turned far from what it says.

    chain: tells which step between a claim's places odometry knows least; a gap in it is such a step.
    """
    result = poses
    variance = np.diff(chain.random[:, 2, 2])
    for i, j, claimed in zip(new.i.tolist(), new.j.tolist(), new.relative, strict=True):
        if abs(wrap(float(between(result[i], result[j])[2] - claimed[2]))) <= FAR_TURNED:
            continue
        first = i + 1 + int(np.argmax(variance[i:j]))
        wanted = compose(result[i], claimed)
        result = result.copy()
        result[first:] = compose(wanted, between(result[j], result[first:]))
    return result
