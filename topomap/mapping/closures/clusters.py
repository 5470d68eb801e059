"""Clusters: claims of neighbouring places that agree with one another, and so are one piece of evidence, not many."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.records import UNKNOWN_HEADING
from topomap.mapping.closures.agreement_kernels import short_loops
from topomap.mapping.closures.claims import Claims
from topomap.mapping.uncertainty.odometry_chain import Chain

WINDOW = 5  # places to either side: odometry between them is as good as known, and groups of false claims are as long
AGREE = 16.3  # chi-squared of 3 dof that 99.9 % of right loops stay within
STRIDE = 8  # places from one representative of a cluster to the next


@dataclass(frozen=True, slots=True, eq=False)
class Clusters:
    """label (M,): each claim's cluster, from 0; cell (M,): the part of the cluster, 8 places of i long, that it is in;
    size (K,): claims in a cluster; representatives (R,): a claim of each cell, in order, the one with which most others
    agree; own (M,): each claim's representative.
    """

    label: IntArray
    cell: IntArray
    size: IntArray
    representatives: IntArray
    own: IntArray

    def __len__(self) -> int:
        return len(self.size)


def clusters_of(claims: Claims, chain: Chain) -> Clusters:
    """Return the clusters of claims, which stand in order of i, then of j."""
    a, b, _ = loops_of(claims, chain, np.arange(len(claims)), AGREE)
    count, label = connected_components(coo_array((np.ones(len(a)), (a, b)), (len(claims), len(claims))), False)
    agreeing = np.bincount(np.concatenate([a, b]), minlength=len(claims))
    cell = label.astype(np.int64) * (len(chain.poses) // STRIDE + 1) + claims.i // STRIDE
    order = np.lexsort((-agreeing, cell))
    _, best, place = np.unique(cell[order], return_index=True, return_inverse=True)
    own = np.empty(len(claims), np.int64)
    own[order] = order[best][place]
    return Clusters(label.astype(np.int64), cell, np.bincount(label, minlength=count), np.sort(order[best]), own)


def loops_of(claims: Claims, chain: Chain, asked: IntArray, limit: float) -> tuple[IntArray, IntArray, FloatArray]:
    """Return pairs a, b (P,) of neighbouring claims and the squared Mahalanobis distance (P,) their loops miss by.

    asked (n,): which claims are taken as a; limit: loops that miss by more aren't returned.
    """
    first = np.searchsorted(claims.i, np.arange(len(chain.poses) + 1))
    a, b, missed = short_loops(
        claims.i, claims.j, claims.relative, claims.covariance, claims.blind, chain.poses, chain.random, first,
        WINDOW, limit, asked,
    )  # fmt: skip
    part = _parts(chain)  # across a gap any two claims agree, which says nothing
    tells = (part[claims.i[a]] == part[claims.i[b]]) & (part[claims.j[a]] == part[claims.j[b]])
    return np.asarray(a[tells]), np.asarray(b[tells]), np.asarray(missed[tells])


def _parts(chain: Chain) -> IntArray:
    """Return (N,) which part of the chain each place is in: a step whose turn isn't known begins another."""
    return np.concatenate([[0], np.cumsum(np.diff(chain.random[:, 2, 2]) > UNKNOWN_HEADING)])
