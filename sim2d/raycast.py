"""Batch ray casting: rays walk the grid cell by cell (Amanatides and Woo 1987) and meet surfaces in order."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim2d.scene import CIRCLE, SEGMENT, Scene

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
FRONT, BACK = 0, 1
MAX_HITS = 64


@njit(cache=True)
def _meet_line(scene: Scene, s: int, ox: float, oy: float, dx: float, dy: float) -> tuple[float, int]:
    """Return where the ray meets a segment or edge, as distance (negative: nowhere) and side."""
    ax, ay, bx, by = scene.line[s, 0], scene.line[s, 1], scene.line[s, 2], scene.line[s, 3]
    ex, ey = bx - ax, by - ay
    cross = dx * ey - dy * ex
    if cross == 0.0:
        return -1.0, FRONT
    px, py = ax - ox, ay - oy
    # which side of the ray the two ends lie on: exact where segments share an end, so no ray slips between them
    if (dx * py - dy * px) * (dx * (by - oy) - dy * (bx - ox)) > 0.0:
        return -1.0, FRONT
    side = FRONT if scene.kind[s] == SEGMENT or cross < 0.0 else BACK
    return (px * ey - py * ex) / cross, side


@njit(cache=True)
def _insert(
    hits: FloatArray, surfaces: IntArray, sides: IntArray, n: int, start: int, t: float, s: int, side: int
) -> int:
    """Insert a hit among those from `start` on, sorted by distance, and return the new count."""
    if n >= len(hits):
        return n
    k = n
    while k > start and hits[k - 1] > t:
        hits[k], surfaces[k], sides[k] = hits[k - 1], surfaces[k - 1], sides[k - 1]
        k -= 1
    hits[k], surfaces[k], sides[k] = t, s, side
    return n + 1


@njit(cache=True)
def _enter(scene: Scene, ox: float, oy: float, dx: float, dy: float) -> tuple[float, float]:
    """Return the distances between which the ray is inside the grid (first > second: never)."""
    near, far = 0.0, np.inf
    for axis in range(2):
        o, d = (ox, dx) if axis == 0 else (oy, dy)
        low = scene.origin[axis]
        high = low + scene.cell * scene.cells[axis]
        if d == 0.0:
            if o < low or o > high:
                return 1.0, 0.0
            continue
        a, b = (low - o) / d, (high - o) / d
        near, far = max(near, min(a, b)), min(far, max(a, b))
    return near, far


@njit(cache=True)
def walk(
    scene: Scene,
    ox: float,
    oy: float,
    dx: float,
    dy: float,
    limit: float,
    full: float,
    hits: FloatArray,
    surfaces: IntArray,
    sides: IntArray,
) -> int:
    """Collect what a ray from o along the unit direction d meets within `limit` [m], near to far.

    Stops at the first front at least `full` [m] high. Writes distance [m], surface and side; returns the count.
    """
    near, far = _enter(scene, ox, oy, dx, dy)
    if near > far or near > limit:
        return 0
    cell, nx, ny = scene.cell, scene.cells[0], scene.cells[1]
    i = min(max(int(np.floor((ox + near * dx - scene.origin[0]) / cell)), 0), nx - 1)
    j = min(max(int(np.floor((oy + near * dy - scene.origin[1]) / cell)), 0), ny - 1)
    si, sj = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
    ti = (scene.origin[0] + (i + (si > 0)) * cell - ox) / dx if dx != 0.0 else np.inf
    tj = (scene.origin[1] + (j + (sj > 0)) * cell - oy) / dy if dy != 0.0 else np.inf
    di = cell / abs(dx) if dx != 0.0 else np.inf
    dj = cell / abs(dy) if dy != 0.0 else np.inf
    n, t_in = 0, -1e-9
    while True:
        t_out = min(ti, tj)
        ni, nj = i, j
        if ti < tj:
            ni += si
            ti += di
        else:
            nj += sj
            tj += dj
        last = ni < 0 or nj < 0 or ni >= nx or nj >= ny
        if last:
            t_out = np.inf
        start = n
        c = j * nx + i
        for k in range(scene.first[c], scene.first[c + 1]):
            s = scene.items[k]
            if scene.kind[s] == CIRCLE:
                px, py, r = ox - scene.line[s, 0], oy - scene.line[s, 1], scene.line[s, 2]
                half = px * dx + py * dy
                across = px * dy - py * dx
                root = r * r - across * across
                if root >= 0.0:
                    root = np.sqrt(root)
                    if t_in <= -half - root < t_out:
                        n = _insert(hits, surfaces, sides, n, start, -half - root, s, FRONT)
                    if t_in <= -half + root < t_out:
                        n = _insert(hits, surfaces, sides, n, start, -half + root, s, BACK)
            else:
                t, side = _meet_line(scene, s, ox, oy, dx, dy)
                if t >= 0.0 and t_in <= t < t_out:
                    n = _insert(hits, surfaces, sides, n, start, t, s, side)
        for k in range(start, n):
            if hits[k] > limit:
                return k
            if sides[k] == FRONT and scene.top[surfaces[k]] >= full:
                return k + 1
        if last or t_out > limit:
            return n
        i, j, t_in = ni, nj, t_out


@njit(cache=True)
def cast(scene: Scene, x: float, y: float, angles: FloatArray, limit: float) -> FloatArray:
    """Return the distance (N,) [m] from (x, y) to the first surface along each angle [rad], NaN beyond `limit`."""
    out = np.full(len(angles), np.nan)
    hits, surfaces, sides = np.empty(MAX_HITS), np.empty(MAX_HITS, np.int64), np.empty(MAX_HITS, np.int64)
    for a in range(len(angles)):
        n = walk(scene, x, y, np.cos(angles[a]), np.sin(angles[a]), limit, -np.inf, hits, surfaces, sides)
        if n > 0 and sides[n - 1] == FRONT:
            out[a] = hits[n - 1]
    return out
