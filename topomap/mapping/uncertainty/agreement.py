"""Agreement among closures: how many neighbouring closures are consistent with each."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import between, compose, wrap_all


class SupportSettings(BaseModel):
    """Which neighbouring closures count as agreeing."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    window: float = Field(default=8.0, gt=0, description="way within which both ends lie [m]")
    tolerance: float = Field(default=0.75, gt=0, description="allowed disagreement in position [m]")
    share: float = Field(default=0.1, ge=0, le=1, description="more of it per metre between them")
    heading_deg: float = Field(default=15.0, gt=0, description="allowed disagreement in heading [degree]")


class Agreeing(NamedTuple):
    """M closures as arrays.

    i, j (M,): positions in the chain; relative (M, 3): `i_from_j`; blind (M,): the heading isn't known; weight (M,).
    """

    i: IntArray
    j: IntArray
    relative: FloatArray
    blind: BoolArray
    weight: FloatArray


def support(claims: Agreeing, poses: FloatArray, travelled: FloatArray, settings: SupportSettings) -> FloatArray:
    """Return (M,) the summed weights of the other closures that agree with each.

    poses (N, 3): odometry's, in chain order (only near pairs are compared, drift doesn't matter); travelled (N,):
    way [m]. Two
    closures i-j and i'-j' agree when the ways i, i', j' and i, j, j' end at the same place. Without a heading the robot
    may have looked the same way or the opposite one.
    """
    a, b = neighbours(claims, travelled, settings.window)
    agree = _agreeing(claims, poses, a, b, settings)
    total = np.zeros(len(claims.i))
    np.add.at(total, a[agree], claims.weight[b[agree]])
    np.add.at(total, b[agree], claims.weight[a[agree]])
    return total


def company(claims: Agreeing, travelled: FloatArray, window: float) -> FloatArray:
    """Return (M,) the summed weights of all closures near each, whether they agree or not: how dense they are."""
    a, b = neighbours(claims, travelled, window)
    total = np.zeros(len(claims.i))
    np.add.at(total, a, claims.weight[b])
    np.add.at(total, b, claims.weight[a])
    return total


def neighbours(claims: Agreeing, travelled: FloatArray, window: float) -> tuple[IntArray, IntArray]:
    """Return the pairs a, b (P,) of closures with ends within the window [m] and not the same j."""
    order = np.argsort(travelled[claims.j], kind="stable")
    way_j, way_i = travelled[claims.j][order], travelled[claims.i][order]
    last = np.searchsorted(way_j, way_j + window, side="right")
    first, second = [], []
    for k in range(len(order)):
        near = np.flatnonzero(np.abs(way_i[k + 1 : last[k]] - way_i[k]) <= window) + k + 1
        first.append(np.full(len(near), order[k]))
        second.append(order[near])
    if not first:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    a, b = np.concatenate(first), np.concatenate(second)
    differ = claims.j[a] != claims.j[b]
    return a[differ], b[differ]


def _agreeing(claims: Agreeing, poses: FloatArray, a: IntArray, b: IntArray, settings: SupportSettings) -> BoolArray:
    along_i = between(poses[claims.i[a]], poses[claims.i[b]])
    along_j = between(poses[claims.j[a]], poses[claims.j[b]])
    longest = np.maximum(np.hypot(along_i[:, 0], along_i[:, 1]), np.hypot(along_j[:, 0], along_j[:, 1]))
    allowed = settings.tolerance + settings.share * longest
    blind = claims.blind[a] | claims.blind[b]
    known = _closes(claims.relative[a], claims.relative[b], along_i, along_j, allowed, settings)
    guessed = np.zeros(len(a), bool)
    for heading in (0.0, math.pi):
        first, second = claims.relative[a].copy(), claims.relative[b].copy()
        first[:, 2] = second[:, 2] = heading
        guessed |= _closes(first, second, along_i, along_j, allowed, settings)
    return np.where(blind, guessed, known)


def _closes(
    first: FloatArray,
    second: FloatArray,
    along_i: FloatArray,
    along_j: FloatArray,
    allowed: FloatArray,
    settings: SupportSettings,
) -> BoolArray:
    one, other = compose(first, along_j), compose(along_i, second)
    gap = np.hypot(one[:, 0] - other[:, 0], one[:, 1] - other[:, 1])
    turned = np.abs(wrap_all(one[:, 2] - other[:, 2]))
    return np.asarray((gap <= allowed) & (turned <= math.radians(settings.heading_deg)))
