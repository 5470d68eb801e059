"""Which closures strain a map: without them it would stand where they couldn't be true."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import between, wrap_all
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.clusters import STRIDE
from topomap.mapping.uncertainty.network import PathNetwork

STRAIN = 16.3  # chi-squared of 3 dof that 99.9 % of true closures stay within


class Missed(NamedTuple):
    """What the members of C cells of clusters miss by together, in the map's axes.

    label (C,): the cluster; i, j (C,): places of one member; mean (C, 3) [m, rad] with covariance
    (C, 3, 3); blind (C,): nothing is claimed of headings.
    """

    label: IntArray
    i: IntArray
    j: IntArray
    mean: FloatArray
    covariance: FloatArray
    blind: BoolArray


def strained(poses: FloatArray, claims: Claims, label: IntArray, standing: IntArray, network: PathNetwork) -> BoolArray:
    """Return which clusters (K,) strain a map of poses (N, 3) that was solved with all that stand.

    label (M,): the claims' clusters, 0 to K - 1; standing (n,): the claims the map was solved with; network: the map's
    paths, these closures included. A closure that bends the map misses by little itself: what it would miss by without
    itself follows from that, from its own covariance C and from the rest's S as (S + C) C^-1 of what it misses by.
    """
    result = np.zeros(int(label.max(initial=-1)) + 1, bool)
    if not len(standing):
        return result
    cells = _cells(poses, claims[standing], label[standing])
    rest = _at(network.errors(cells.i, cells.j, cells.label), poses[cells.j])
    pull = np.linalg.solve(cells.covariance, cells.mean[:, :, None])
    pull[cells.blind, 2] = 0.0
    chi2 = (pull.transpose(0, 2, 1) @ (rest + cells.covariance) @ pull)[:, 0, 0]
    result[cells.label[chi2 > STRAIN]] = True
    return result


def _cells(poses: FloatArray, own: Claims, label: IntArray) -> Missed:
    """Carry what the members of a cluster within some places miss by to one of them, and take the mean."""
    cell = label * (len(poses) // STRIDE + 1) + own.i // STRIDE
    cells, first, place, count = np.unique(cell, return_index=True, return_inverse=True, return_counts=True)
    missed, covariance = _in_map_axes(poses, own, own.j[first][place])
    mean, spread = np.zeros((len(cells), 3)), np.zeros((len(cells), 3, 3))
    np.add.at(mean, place, missed)
    np.add.at(spread, place, covariance)
    mean, spread = mean / count[:, None], spread / (count**2)[:, None, None]
    return Missed(label[first], own.i[first], own.j[first], mean, spread, own.blind[first])


def _at(errors: FloatArray, poses: FloatArray) -> FloatArray:
    """Return errors (n, 3, 3) about the origin as those at poses (n, 3), in the map's axes."""
    lever = np.tile(np.eye(3), (len(poses), 1, 1))
    lever[:, 0, 2], lever[:, 1, 2] = -poses[:, 1], poses[:, 0]
    return np.asarray(lever @ errors @ lever.transpose(0, 2, 1))


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
