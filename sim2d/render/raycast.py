"""Batch ray casting: rays walk the grid cell by cell (Amanatides and Woo 1987) and meet surfaces in order."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim2d.render.kernel import kernel
from sim2d.render.scene import CIRCLE, SEGMENT, Scene

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
FRONT, BACK = 0, 1
MAX_HITS = 64


@kernel
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


@kernel
def _meet_circle(scene: Scene, s: int, ox: float, oy: float, dx: float, dy: float) -> tuple[float, float]:
    """Return where the ray enters and leaves a circle, as distances (negative: behind, or nowhere)."""
    px, py, r = ox - scene.line[s, 0], oy - scene.line[s, 1], scene.line[s, 2]
    half = px * dx + py * dy
    across = px * dy - py * dx
    root = r * r - across * across
    if root < 0.0:
        return -1.0, -1.0
    root = np.sqrt(root)
    return -half - root, -half + root


@kernel
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


@kernel
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


@kernel
def _start(
    scene: Scene, ox: float, oy: float, dx: float, dy: float, limit: float
) -> tuple[bool, int, int, int, int, float, float, float, float]:
    """Return whether the ray meets the grid, its first cell i, j, its steps, and the distances [m] at which it crosses
    to the next column and row and from one to the next."""
    near, far = _enter(scene, ox, oy, dx, dy)
    cell, nx, ny = scene.cell, scene.cells[0], scene.cells[1]
    if near > far or near > limit:
        return False, 0, 0, 0, 0, 0.0, 0.0, 0.0, 0.0
    i = min(max(int(np.floor((ox + near * dx - scene.origin[0]) / cell)), 0), nx - 1)
    j = min(max(int(np.floor((oy + near * dy - scene.origin[1]) / cell)), 0), ny - 1)
    si, sj = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
    ti = (scene.origin[0] + (i + (si > 0)) * cell - ox) / dx if dx != 0.0 else np.inf
    tj = (scene.origin[1] + (j + (sj > 0)) * cell - oy) / dy if dy != 0.0 else np.inf
    di = cell / abs(dx) if dx != 0.0 else np.inf
    dj = cell / abs(dy) if dy != 0.0 else np.inf
    return True, i, j, si, sj, ti, tj, di, dj


@kernel
def _walk_fixed(
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
    """Do the work of `walk` for the surfaces in the grid."""
    inside, i, j, si, sj, ti, tj, di, dj = _start(scene, ox, oy, dx, dy, limit)
    if not inside:
        return 0
    nx, ny = scene.cells[0], scene.cells[1]
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
                enter, leave = _meet_circle(scene, s, ox, oy, dx, dy)
                if enter >= 0.0 and t_in <= enter < t_out:
                    n = _insert(hits, surfaces, sides, n, start, enter, s, FRONT)
                if leave >= 0.0 and t_in <= leave < t_out:
                    n = _insert(hits, surfaces, sides, n, start, leave, s, BACK)
            else:
                t, side = _meet_line(scene, s, ox, oy, dx, dy)
                if t >= 0.0 and t_in <= t < t_out:
                    n = _insert(hits, surfaces, sides, n, start, t, s, side)
        for k in range(start, n):
            if hits[k] > limit or (sides[k] == FRONT and scene.top[surfaces[k]] >= full):
                return k + 1 if hits[k] <= limit else k
        if last or t_out > limit:
            return n
        i, j, t_in = ni, nj, t_out


@kernel
def _add_moving(
    scene: Scene, ox: float, oy: float, dx: float, dy: float, limit: float, full: float,
    hits: FloatArray, surfaces: IntArray, sides: IntArray, n: int,
) -> int:  # fmt: skip
    """Add the moving circles to the n hits of `walk` and return the new count."""
    if n > 0 and sides[n - 1] == FRONT and scene.top[surfaces[n - 1]] >= full:
        limit = min(limit, hits[n - 1])
    for s in range(scene.fixed, len(scene.kind)):
        enter, leave = _meet_circle(scene, s, ox, oy, dx, dy)
        if 0.0 <= enter <= limit:
            n = _insert(hits, surfaces, sides, n, 0, enter, s, FRONT)
        if 0.0 <= leave <= limit:
            n = _insert(hits, surfaces, sides, n, 0, leave, s, BACK)
    for k in range(n):
        if sides[k] == FRONT and scene.top[surfaces[k]] >= full:
            return k + 1
    return n


@kernel
def walk(
    scene: Scene, ox: float, oy: float, dx: float, dy: float, limit: float, full: float,
    hits: FloatArray, surfaces: IntArray, sides: IntArray,
) -> int:  # fmt: skip
    """Collect what a ray from o along the unit direction d meets within `limit` [m], near to far.

    Stops at the first front at least `full` [m] high. Writes distance [m], surface and side; returns the count.
    """
    n: int = _walk_fixed(scene, ox, oy, dx, dy, limit, full, hits, surfaces, sides)
    if scene.fixed < len(scene.kind):
        n = _add_moving(scene, ox, oy, dx, dy, limit, full, hits, surfaces, sides, n)
    return n


@kernel
def nearest(scene: Scene, ox: float, oy: float, dx: float, dy: float, limit: float, height: float) -> float:
    """Return the distance [m] to the first front at least `height` [m] high within `limit` [m]; infinite: none."""
    best = np.inf
    for s in range(scene.fixed, len(scene.kind)):
        enter, _ = _meet_circle(scene, s, ox, oy, dx, dy)
        if 0.0 <= enter < best and scene.top[s] >= height:
            best = enter
    inside, i, j, si, sj, ti, tj, di, dj = _start(scene, ox, oy, dx, dy, limit)
    nx, ny = scene.cells[0], scene.cells[1]
    while inside:
        c = j * nx + i
        for k in range(scene.first[c], scene.first[c + 1]):
            s = scene.items[k]
            if scene.kind[s] == CIRCLE:
                t, _ = _meet_circle(scene, s, ox, oy, dx, dy)
            else:
                t, side = _meet_line(scene, s, ox, oy, dx, dy)
                if side == BACK:
                    continue
            if 0.0 <= t < best and scene.top[s] >= height:
                best = t
        out = min(ti, tj)
        if ti < tj:
            i += si
            ti += di
        else:
            j += sj
            tj += dj
        # what is met beyond this cell may lie behind what another cell holds
        inside = out < best and out <= limit and 0 <= i < nx and 0 <= j < ny
    return best if best <= limit else np.inf


@kernel
def cast(scene: Scene, x: float, y: float, angles: FloatArray, limit: float, height: float = 0.0) -> FloatArray:
    """Return the distance (N,) [m] from (x, y) to the first surface at least `height` [m] high along each angle [rad],
    NaN beyond `limit`."""
    out = np.full(len(angles), np.nan)
    for a in range(len(angles)):
        t = nearest(scene, x, y, np.cos(angles[a]), np.sin(angles[a]), limit, height)
        if t < np.inf:
            out[a] = t
    return out
