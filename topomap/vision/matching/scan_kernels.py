"""The hot loops of scan matching, in one module so that numba's cache notices every change."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from topomap.core.arrays import BoolArray, FloatArray


@njit(cache=True)
def _closer(x: float, y: float, limit: float) -> bool:
    """Return whether hypot(x, y) < limit; only what is equal to twelve digits takes the slow way."""
    squared, bound = x * x + y * y, limit * limit
    if squared < bound * (1.0 - 1e-12):
        return True
    if squared > bound * (1.0 + 1e-12):
        return False
    return math.hypot(x, y) < limit


@njit(cache=True)
def surfaces(ranges: FloatArray, half: int, flatness: float) -> tuple[FloatArray, FloatArray]:
    """Return points (W, 2) [m] and unit normals (W, 2) of a scan (W,), counter-clockwise from the nose.

    The normal is that of the line through `half` neighbours on either side; it is NaN where the neighbours are missing,
    lie on another surface or bend more than `flatness` (smallest over largest spread).
    """
    n = len(ranges)
    points, normals = np.full((n, 2), np.nan), np.full((n, 2), np.nan)
    for j in range(n):
        points[j, 0] = ranges[j] * math.cos(2.0 * math.pi * j / n)
        points[j, 1] = ranges[j] * math.sin(2.0 * math.pi * j / n)
    shares = points / (2 * half + 1)
    for j in range(n):
        limit = 0.3 + 0.2 * ranges[j]
        near = limit > 0.0
        for k in range(j - half, j + half + 1):
            if not _closer(points[k % n, 0] - points[j, 0], points[k % n, 1] - points[j, 1], limit):
                near = False
                break
        if not near:
            continue
        mean_x, mean_y = 0.0, 0.0
        for k in range(j - half, j + half + 1):
            mean_x += shares[k % n, 0]
            mean_y += shares[k % n, 1]
        xx, xy, yy = 0.0, 0.0, 0.0
        for k in range(j - half, j + half + 1):
            dx, dy = points[k % n, 0] - mean_x, points[k % n, 1] - mean_y
            xx, xy, yy = xx + dx * dx, xy + dx * dy, yy + dy * dy
        spread = math.sqrt((xx - yy) ** 2 + 4.0 * xy * xy)
        small, large = 0.5 * (xx + yy - spread), 0.5 * (xx + yy + spread)
        if large <= 0.0 or small > flatness * large:
            continue
        angle = 0.5 * math.atan2(2.0 * xy, xx - yy) + 0.5 * math.pi
        normals[j, 0], normals[j, 1] = math.cos(angle), math.sin(angle)
    return points, normals


@njit(cache=True)
def normal_equations(
    points: FloatArray,
    normals: FloatArray,
    moved: FloatArray,
    moved_normals: FloatArray,
    pose: FloatArray,
    cutoff: float,
    window: int,
) -> tuple[FloatArray, FloatArray, float, int]:
    """Return H (3, 3), g (3,), the weighted squared error and the number of point-to-line pairs within the cutoff [m].

    pose (3,): the current estimate of where the moved scan stands; each of its points is paired with the nearest
    one of the first scan among `window` rays to either side of the direction it is seen in, if the surfaces face alike.
    """
    n = len(points)
    information, gradient = np.zeros((3, 3)), np.zeros(3)
    error, used = 0.0, 0
    c, s = math.cos(pose[2]), math.sin(pose[2])
    row = np.empty(3)
    reach = (n + 1) // 2 + window  # a direction is at most half a circle from the nose
    round_x, round_y = np.empty(2 * reach + 1), np.empty(2 * reach + 1)
    for k in range(-reach, reach + 1):
        surface = not math.isnan(normals[k % n, 0])
        round_x[k + reach] = points[k % n, 0] if surface else math.nan
        round_y[k + reach] = points[k % n, 1] if surface else math.nan
    for j in range(n):
        if math.isnan(moved_normals[j, 0]):
            continue
        x, y = c * moved[j, 0] - s * moved[j, 1], s * moved[j, 0] + c * moved[j, 1]
        facing_x = c * moved_normals[j, 0] - s * moved_normals[j, 1]
        facing_y = s * moved_normals[j, 0] + c * moved_normals[j, 1]
        at_x, at_y = x + pose[0], y + pose[1]
        angle = math.atan2(at_y, at_x)
        if math.isnan(angle):
            continue
        middle = round(angle * n / (2.0 * math.pi)) + reach
        best, distance = -1, (2.0 * cutoff + 0.15) ** 2
        for k in range(middle - window, middle + window + 1):
            squared = (round_x[k] - at_x) ** 2 + (round_y[k] - at_y) ** 2
            if squared < distance:
                best, distance = k, squared
        if best >= 0:
            best = (best - reach) % n
        if best < 0 or abs(facing_x * normals[best, 0] + facing_y * normals[best, 1]) < 0.9:
            continue
        off = (at_x - points[best, 0]) * normals[best, 0] + (at_y - points[best, 1]) * normals[best, 1]
        if abs(off) >= cutoff:
            continue
        weight = (1.0 - (off / cutoff) ** 2) ** 2
        row[0], row[1] = normals[best, 0], normals[best, 1]
        row[2] = x * normals[best, 1] - y * normals[best, 0]
        for a in range(3):
            gradient[a] += weight * row[a] * off
            for b in range(3):
                information[a, b] += weight * row[a] * row[b]
        error += weight * off * off
        used += 1
    return information, gradient, error, used


@njit(cache=True)
def in_pairs(information: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return an information (3, 3) with its turn scaled by how far it moves the points, and the scales (3,)."""
    arm = math.sqrt(max(information[2, 2] / max(information[0, 0] + information[1, 1], 1e-12), 1e-12))
    scale = np.array([1.0, 1.0, 1.0 / arm])
    pairs = np.empty((3, 3))
    for a in range(3):
        for b in range(3):
            pairs[a, b] = information[a, b] * scale[a] * scale[b]
    return pairs, scale


@njit(cache=True)
def untold_directions(values: FloatArray, directions: FloatArray, least: float) -> tuple[BoolArray, int]:
    """Return which directions (3, 3), with eigenvalues (3,), are of the position and told by no more than `least`."""
    untold = np.empty(3, np.bool_)
    for k in range(3):
        untold[k] = values[k] <= least and directions[2, k] ** 2 < 0.5
    return untold, int(untold.sum())


@njit(cache=True)
def _without(directions: FloatArray, untold: BoolArray, count: int) -> FloatArray:
    """Return the projection (3, 3) that removes the untold (3,) of directions (3, 3) from the position, one or both."""
    if count > 1:
        return np.diag(np.array([0.0, 0.0, 1.0]))
    lost = directions[:2, np.argmax(untold)].copy()
    squared = np.dot(lost, lost)
    kept = np.eye(3)
    for a in range(2):
        for b in range(2):
            kept[a, b] -= lost[a] * lost[b] / squared
    return kept


@njit(cache=True)
def inverse_of(
    values: FloatArray, directions: FloatArray, scale: FloatArray, least: float, otherwise: float
) -> FloatArray:
    """Return the inverse (3, 3) of scaled pairs with eigenvalues (3,) in directions (3, 3): those up to `least` count
    as `otherwise`.
    """
    inverse = np.zeros((3, 3))
    for k in range(3):
        weight = 1.0 / max(values[k], 1e-12) if values[k] > least else otherwise
        for a in range(3):
            for b in range(3):
                inverse[a, b] += weight * directions[a, k] * directions[b, k] * scale[a] * scale[b]
    return inverse


@njit(cache=True)
def inverted(information: FloatArray, told: float, otherwise: float) -> FloatArray:
    """Invert an information (3, 3) in the directions that enough pairs constrain; the others get `otherwise`.

    Because normals are noisy, every direction looks constrained a little, even along a bare corridor, and the position
    along it looks coupled with the turn. So unconstrained directions of the position are removed first: otherwise their
    uncertainty would spread into the turn, which the walls measure well. The turn is scaled by how far it moves the
    points, so that all three directions are measured in pairs. told: share of the pairs that tells a direction.
    """
    pairs, scale = in_pairs(information)
    values, directions = np.linalg.eigh(pairs)
    least = told * values[2]
    untold, count = untold_directions(values, directions, least)
    if count:
        kept = _without(directions, untold, count)
        values, directions = np.linalg.eigh(kept @ pairs @ kept)
    inverse: FloatArray = inverse_of(values, directions, scale, least, otherwise)
    return inverse


@njit(cache=True)
def laid_over(
    points: FloatArray, normals: FloatArray, moved: FloatArray, moved_normals: FloatArray, guess: FloatArray,
    cutoffs: FloatArray, window: int, told: float, fewest: float,
) -> tuple[FloatArray, FloatArray, float, int]:  # fmt: skip
    """Return the pose (3,) of a moved scan after one step for each cutoff, and the last step's information (3, 3),
    squared error and number of pairs; -1 pairs where fewer than `fewest` were found.
    """
    pose = guess.copy()
    information, error, used = np.zeros((3, 3)), 0.0, 0
    for cutoff in cutoffs:
        information, gradient, error, used = normal_equations(
            points, normals, moved, moved_normals, pose, cutoff, window
        )
        if used < fewest:
            return pose, information, error, -1
        pose -= inverted(information, told, 0.0) @ gradient
        pose[2] = _wrapped(pose[2])
    return pose, information, error, used


@njit(cache=True)
def _wrapped(angle: float) -> float:
    """Return what `topomap.core.geometry.wrap` does."""
    rest = np.fmod(angle, 2.0 * math.pi)
    if rest > math.pi:
        rest -= 2.0 * math.pi
    if rest < -math.pi:
        rest += 2.0 * math.pi
    return math.pi if rest == -math.pi else rest
