"""The panorama's pixels: columns are rays, rows follow from true heights on the cylinder."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim2d.atlas import Atlas
from sim2d.column import FADE, Eye, Ground, paint_ceiling, paint_floor, paint_lid, paint_wall
from sim2d.raycast import BACK, MAX_HITS, FloatArray, IntArray, walk
from sim2d.scene import CIRCLE, SEGMENT, Scene
from sim2d.texel import level_at

FAR = 200.0  # [m] nothing is drawn beyond


@njit(cache=True, error_model="numpy")
def _skin(scene: Scene, atlas: Atlas, s: int, eye: Eye, dx: float, dy: float, t: float, skin: FloatArray) -> None:
    """Write what painting a surface hit at t [m] needs: entries of its two texel columns, weight, texels along v,
    texels per metre along v, brightness, top [m]."""
    px, py = eye.x + t * dx, eye.y + t * dy
    if scene.kind[s] == CIRCLE:
        nx, ny = (px - scene.line[s, 0]) / scene.line[s, 2], (py - scene.line[s, 1]) / scene.line[s, 2]
        u = np.arctan2(ny, nx) * scene.line[s, 2]
        light = 0.86 + 0.1 * nx + 0.06 * ny
    else:
        ax, ay = scene.line[s, 0], scene.line[s, 1]
        ex, ey = scene.line[s, 2] - ax, scene.line[s, 3] - ay
        length = np.hypot(ex, ey)
        u = scene.along[s] + ((px - ax) * ex + (py - ay) * ey) / length
        nx, ny, light = ey / length, -ex / length, scene.light[s]
    tile = scene.tile[s]
    level = level_at(t / eye.focal / np.sqrt(max(0.05, abs(nx * dx + ny * dy))))
    nu, nv, base = atlas.nu[tile, level], atlas.nv[tile, level], atlas.offset[tile, level]
    fu = u / atlas.size[tile, 0] * nu - 0.5
    i = int(np.floor(fu))
    skin[2] = int((fu - i) * 64)
    i %= nu
    k = i + 1 if i + 1 < nu else 0
    skin[0], skin[1] = base + i * nv, base + k * nv
    skin[3], skin[4] = nv, nv / atlas.size[tile, 1]
    skin[5], skin[6] = light / (1 + t / FADE), scene.top[s]


@njit(cache=True, error_model="numpy")
def _exit(solid: IntArray, hits: FloatArray, surfaces: IntArray, sides: IntArray, k: int, n: int) -> float:
    """Return where the ray leaves the solid that it entered at hit k."""
    for m in range(k + 1, n):
        if sides[m] == BACK and solid[surfaces[m]] == solid[surfaces[k]]:
            return float(hits[m])
    return float(hits[k])


@njit(cache=True, error_model="numpy")
def _rows(atlas: Atlas, eye: Eye, tile: int, rise: float, height: int) -> Ground:
    """Return the rows of a floor or ceiling `rise` [m] from the eye."""
    reach, tiles = np.empty((height, 2)), np.empty((height, 2), np.int64)
    for r in range(height):
        t = min(FAR, rise * eye.focal / max(abs(r - eye.horizon), 1e-3))
        # a ground pixel is longer than wide: the geometric mean of both decides
        level = level_at(t / eye.focal * np.sqrt(max(1.0, t / rise)))
        reach[r, 0], reach[r, 1] = t, eye.gain / (1 + t / FADE)
        tiles[r, 0], tiles[r, 1] = atlas.offset[tile, level], atlas.nu[tile, level]
    return Ground(reach, tiles, 1 / atlas.size[tile, 0])


@njit(cache=True, error_model="numpy")
def render(scene: Scene, atlas: Atlas, eye: Eye, image: NDArray[np.uint8]) -> None:
    """Fill image (H, W, 3) RGB with what the camera sees, without noise."""
    height, width = image.shape[:2]
    texels, pixels = atlas.texels, image.reshape(-1)
    hits, skins = np.empty(MAX_HITS), np.empty((MAX_HITS, 7))
    surfaces, sides = np.empty(MAX_HITS, np.int64), np.empty(MAX_HITS, np.int64)
    floor = _rows(atlas, eye, eye.floor, eye.height, height)
    ceiling = _rows(atlas, eye, eye.ceiling, eye.room - eye.height, height)
    mirror = _rows(atlas, eye, eye.ceiling, eye.room + eye.height, height)
    for c in range(width):
        angle = eye.heading + (c - eye.forward_column) * eye.turn
        dx, dy = np.cos(angle), np.sin(angle)
        n = walk(scene, eye.x, eye.y, dx, dy, FAR, eye.room, hits, surfaces, sides)
        for k in range(n):
            _skin(scene, atlas, surfaces[k], eye, dx, dy, hits[k], skins[k])
        y = height - 1  # what is seen fills the column from its foot upwards
        for k in range(n):
            if sides[k] == BACK:
                continue
            foot = eye.horizon + eye.focal * eye.height / hits[k]
            y = paint_floor(texels, pixels, width, c, y, foot, eye, floor, mirror, dx, dy, hits, skins, sides, k, n)
            y = paint_wall(texels, pixels, width, c, y, skins[k], hits[k], eye)
            if y >= 0 and skins[k, 6] < eye.height and scene.kind[surfaces[k]] != SEGMENT:
                far = _exit(scene.solid, hits, surfaces, sides, k, n)
                y = paint_lid(scene, atlas, pixels, width, c, y, surfaces[k], far, eye)
        y = paint_floor(texels, pixels, width, c, y, eye.horizon, eye, floor, mirror, dx, dy, hits, skins, sides, n, n)
        s = ceiling.scale
        paint_ceiling(texels, pixels, width, c, y, ceiling, eye.x * s, eye.y * s, dx * s, dy * s)


@njit(cache=True, error_model="numpy")
def add_noise(image: NDArray[np.uint8], noise: NDArray[np.int8], start: int) -> None:
    """Add entries of a long noise table, from `start` on, to all pixels in place."""
    flat = image.reshape(-1)
    size = len(noise)
    k = start
    for i in range(len(flat)):
        value = np.int64(flat[i]) + noise[k]
        flat[i] = np.uint8(min(255, max(0, value)))
        k += 1
        if k == size:
            k = 0
