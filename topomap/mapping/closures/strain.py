"""Which closures strain a map: the mean of what neighbouring ones miss by is far more than their noise."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import between, wrap_all
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.clusters import STRIDE

STRAIN = 16.3  # chi-squared of 3 dof that 99.9 % of means stay within


def strained(poses: FloatArray, claims: Claims, label: IntArray, standing: IntArray) -> BoolArray:
    """Return which clusters (K,) strain a map of poses (N, 3).

    label (M,): the claims' clusters, 0 to K - 1; standing (n,): the claims the map was solved with. What the members of
    a cluster within some places miss by is carried to one of them, in the map's axes, and its mean held against the
    covariance of a mean.
    """
    result = np.zeros(int(label.max(initial=-1)) + 1, bool)
    if not len(standing):
        return result
    own = claims[standing]
    cell = label[standing] * (len(poses) // STRIDE + 1) + own.i // STRIDE
    cells, first, place, count = np.unique(cell, return_index=True, return_inverse=True, return_counts=True)
    missed, covariance = _in_map_axes(poses, own, own.j[first][place])
    mean, spread = np.zeros((len(cells), 3)), np.zeros((len(cells), 3, 3))
    np.add.at(mean, place, missed)
    np.add.at(spread, place, covariance)
    mean, spread = mean / count[:, None], spread / (count**2)[:, None, None]
    dof = np.where(own.blind[first], 2, 3)
    mean[dof == 2, 2] = 0.0
    chi2 = (mean * np.linalg.solve(spread, mean[:, :, None])[:, :, 0]).sum(axis=1)
    result[label[standing][first[chi2 > STRAIN]]] = True
    return result


def _in_map_axes(poses: FloatArray, own: Claims, at: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return what claims (n,) miss by (n, 3), in the map's axes and at the places `at` (n,), and their covariances."""
    missed = between(poses[own.i], poses[own.j]) - own.relative
    missed[:, 2] = wrap_all(missed[:, 2])
    c, s = np.cos(poses[own.i, 2]), np.sin(poses[own.i, 2])
    turn = np.zeros((len(c), 3, 3))
    turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1], turn[:, 2, 2] = c, -s, s, c, 1.0
    turned = (turn @ missed[:, :, None])[:, :, 0]
    lever = poses[at, :2] - poses[own.j, :2]
    heading = np.where(own.blind, 0.0, turned[:, 2])
    turned[:, 0] -= heading * lever[:, 1]
    turned[:, 1] += heading * lever[:, 0]
    return turned, turn @ own.covariance @ turn.transpose(0, 2, 1)
