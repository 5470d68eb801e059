"""How much likelier all that is claimed is if some closures are true than if none is: what chooses among solutions."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.special import chdtri

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.evidence import FALSE_DISTANCE, FALSE_ROTATION
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.drive import Drive, MapState
from topomap.mapping.closures.odds import log_chance, log_crowding, log_density
from topomap.mapping.closures.placing import UNKNOWN
from topomap.mapping.optimizer import OptimizerSettings

# every closure pulls: whether it fits is what is asked
ALL_IN = OptimizerSettings(cutoff=100.0, cutoffs=(), iterations=10, tolerance=1e-3)

VAGUE = 0.05  # share of true closures that miss by 1 m or 20 degrees from which on a miss by that tells nothing
ALONE = 1e-6  # a closure that alone knows something is known as well by the map: the difference is no less than this


class Evidence(NamedTuple):
    """Log odds of closures that are true together; tension: the squared error for each thing they claim."""

    log_odds: float
    tension: float


def log_evidence(drive: Drive, state: MapState, closures: Claims, log_prior: FloatArray) -> Evidence:
    """Return the log odds that n closures, one a cluster, are true and not all of them false, given what they claim.

    log_prior (n,): log odds of each before its claim is compared with the map; state: about what they make of the map.
    The claims' joint density, with the poses integrated out (Laplace), is that of the residuals at the optimum times
    the root of odometry's information over the information of both; false ones are even over the drive's area.
    """
    if not len(closures):
        return Evidence(0.0, 0.0)
    solver, edges = drive.solver, closures.closures()
    found = solver.solve(state.poses, edges, ALL_IN)
    chi2 = solver.error(found.poses, edges)
    gained = solver.log_volume(found.poses, edges) - solver.log_volume(drive.poses, closures[:0].closures())
    blind = closures.blind
    own = np.where(blind, _flat(closures.covariance), np.linalg.slogdet(closures.covariance)[1])
    dimensions = np.where(blind, 2, 3)
    joint = -0.5 * (chi2 + gained + float(own.sum() + (dimensions * math.log(2 * math.pi)).sum()))
    joint += _bridged(drive, closures)
    log_odds = joint - float(log_chance(drive.poses, blind).sum()) + float(log_prior.sum())
    return Evidence(log_odds, chi2 / float(dimensions.sum()))


def _bridged(drive: Drive, closures: Claims) -> float:
    """Return what gaps in the odometry took from the density of closures that bridge them.

    Across a gap a true claim is as likely as one of any two places, not less: how wide a gap is stated is no evidence.
    """
    information = drive.solver.odometry.information
    gaps = information[:, 2, 2] * UNKNOWN <= 1.0
    if not gaps.any():
        return 0.0
    part = np.concatenate([np.zeros(1, np.int64), np.cumsum(gaps)])
    parts = int(part[-1]) + 1
    net = coo_array((np.ones(len(closures)), (part[closures.i], part[closures.j])), (parts, parts))
    joined = parts - int(connected_components(net, directed=False)[0])
    even = float(log_chance(drive.poses, np.zeros(1, np.bool_))[0])
    said = 0.5 * np.linalg.slogdet(information[gaps])[1] - 1.5 * math.log(2 * math.pi)
    return joined * max(0.0, even - float(said.mean()))


def log_odds_beside_others(drive: Drive, state: MapState, closures: Claims, log_prior: FloatArray) -> FloatArray:
    """Return (n,) log odds of each of n closures, one a cluster, by odometry and the other ones.

    log_prior (n,) and state: as above.
    """
    poses = drive.solver.solve(state.poses, closures.closures(), ALL_IN).poses
    blind = closures.blind
    missed, spread = beside_others(drive, poses, closures)
    chi2 = (missed[:, None] @ np.linalg.solve(spread, missed[:, :, None]))[:, 0, 0]
    determinant = np.where(blind, np.linalg.det(spread[:, :2, :2]), np.linalg.det(spread))
    even, peak = log_chance(poses, blind), log_density(np.zeros(len(closures)), determinant, blind)
    density = log_density(chi2, determinant, blind) - peak + np.maximum(peak, even) - even
    crowding = log_crowding(replace(closures, covariance=spread), poses, np.zeros_like(spread))
    return np.asarray(log_prior + density - crowding)


def apart_from_others(drive: Drive, poses: FloatArray, closures: Claims) -> BoolArray:
    """Return which of n closures (n,) are false by the definition of it, as odometry and the other ones tell.

    The map without the closure has its places more than 1 m or 20 degrees from what it says; where closure and map are
    so vague that true ones often miss by that, it tells nothing. poses (N, 3): solved with them.
    """
    missed, spread = beside_others(drive, poses, closures)
    far = np.hypot(missed[:, 0], missed[:, 1]) > FALSE_DISTANCE
    turned = np.abs(missed[:, 2]) > FALSE_ROTATION
    placed = chdtri(2, VAGUE) * (spread[:, 0, 0] + spread[:, 1, 1]) / 2 < FALSE_DISTANCE**2
    headed = chdtri(1, VAGUE) * spread[:, 2, 2] < FALSE_ROTATION**2
    return np.asarray((far & placed) | (turned & headed))


def beside_others(drive: Drive, poses: FloatArray, closures: Claims) -> tuple[FloatArray, FloatArray]:
    """Return what each of n closures would miss by without itself (n, 3), and the covariance of that (n, 3, 3).

    poses (N, 3): solved with all of them. It follows from what it misses by with itself, m, its own covariance C and
    what the map with it knows, P: S C^-1 m with the covariance S = C (C - P)^-1 C. Of blind ones the heading is 0.
    """
    blind = closures.blind
    missed, known = drive.solver.known(poses, closures.closures())
    own, known = closures.covariance.copy(), known.copy()
    even = (own[blind, 0, 0] + own[blind, 1, 1]) / 2
    own[blind], known[blind, 2, :], known[blind, :, 2] = np.eye(3) * even[:, None, None], 0.0, 0.0
    spread = own @ np.linalg.inv(own * (1 + ALONE) - known) @ own
    pull = np.linalg.solve(own, missed[:, :, None])
    pull[blind, 2] = 0.0
    return (spread @ pull)[:, :, 0], spread


def _flat(covariance: FloatArray) -> FloatArray:
    """Return log determinants of the positions' covariances (n,), the same both ways as the solver takes them."""
    return np.asarray(2 * np.log((covariance[:, 0, 0] + covariance[:, 1, 1]) / 2))
