"""The panorama's pixels: columns are rays, rows follow from true heights on the cylinder."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim2d.atlas import LEVELS, Atlas
from sim2d.canvas import TEXELS
from sim2d.raycast import BACK, MAX_HITS, FloatArray, IntArray, walk
from sim2d.scene import CIRCLE, SEGMENT, Scene

FADE = 30.0  # [m] distance at which brightness has halved
FAR = 200.0  # [m] nothing is drawn beyond


class Eye(NamedTuple):
    """Camera and room: x, y [m], heading [rad], eye height [m], focal [pixels], horizon row, recorded column of the
    nose, turn per column [rad], room height [m], floor and ceiling tile, floor gloss, gain."""

    x: float
    y: float
    heading: float
    height: float
    focal: float
    horizon: float
    forward_column: int
    turn: float
    room: float
    floor: int
    ceiling: int
    gloss: float
    gain: float


@njit(cache=True)
def _level(footprint: float) -> int:
    """Return the resolution level at which a texel is about as big as a pixel's footprint [m]."""
    level, size = 0, footprint * TEXELS
    while size > 1.5 and level < LEVELS - 1:
        size *= 0.5
        level += 1
    return level


@njit(cache=True)
def _sample(atlas: Atlas, tile: int, level: int, u: float, v: float) -> tuple[float, float, float]:
    """Return the bilinear colour at u, v [m]; u repeats, v is held at the edges."""
    nu, nv, base = atlas.nu[tile, level], atlas.nv[tile, level], atlas.offset[tile, level]
    fu = u / atlas.size[tile, 0] * nu - 0.5
    fv = min(max(v / atlas.size[tile, 1] * nv - 0.5, 0.0), nv - 1.0)
    iu, iv = int(np.floor(fu)), int(fv)
    wu, wv = fu - iu, fv - iv
    iu %= nu
    i2 = iu + 1 if iu + 1 < nu else 0
    v2 = iv + 1 if iv + 1 < nv else iv
    a, b = base + iu * nv, base + i2 * nv
    w00, w01, w10, w11 = (1 - wu) * (1 - wv), (1 - wu) * wv, wu * (1 - wv), wu * wv
    t = atlas.texels
    return (
        w00 * t[a + iv, 0] + w01 * t[a + v2, 0] + w10 * t[b + iv, 0] + w11 * t[b + v2, 0],
        w00 * t[a + iv, 1] + w01 * t[a + v2, 1] + w10 * t[b + iv, 1] + w11 * t[b + v2, 1],
        w00 * t[a + iv, 2] + w01 * t[a + v2, 2] + w10 * t[b + iv, 2] + w11 * t[b + v2, 2],
    )


@njit(cache=True)
def _ground(atlas: Atlas, tile: int, level: int, x: float, y: float) -> tuple[float, float, float]:
    """Return the colour of a floor or ceiling at world x, y [m]."""
    side = atlas.size[tile, 1]
    return _sample(atlas, tile, level, x, y - side * np.floor(y / side))


@njit(cache=True)
def _put(pixel: NDArray[np.uint8], colour: tuple[float, float, float], factor: float) -> None:
    """Store a colour times a factor."""
    pixel[0] = np.uint8(min(255.0, colour[0] * factor + 0.5))
    pixel[1] = np.uint8(min(255.0, colour[1] * factor + 0.5))
    pixel[2] = np.uint8(min(255.0, colour[2] * factor + 0.5))


@njit(cache=True)
def _texture(
    scene: Scene, s: int, px: float, py: float, dx: float, dy: float, t: float, focal: float
) -> tuple[float, int, float]:
    """Return surface coordinate [m], resolution level and brightness where a ray meets a surface at (px, py)."""
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
    facing = max(0.05, abs(nx * dx + ny * dy))
    return u, _level(t / focal / np.sqrt(facing)), light / (1 + t / FADE)


@njit(cache=True)
def _mirror(
    scene: Scene, atlas: Atlas, eye: Eye, hits: FloatArray, places: FloatArray, levels: IntArray,
    surfaces: IntArray, sides: IntArray, n: int, below: float, reach: float, dx: float, dy: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Return what the floor `reach` [m] away mirrors, `below` rows under the horizon."""
    for k in range(n):
        s = surfaces[k]
        if sides[k] == BACK or hits[k] < reach:
            continue
        z = below * hits[k] / eye.focal - eye.height
        if z < scene.top[s]:
            r, g, b = _sample(atlas, scene.tile[s], levels[k], places[k, 0], z)
            return r * places[k, 1], g * places[k, 1], b * places[k, 1]
    t = min(FAR, (eye.room + eye.height) * eye.focal / below)
    fade = 1 / (1 + t / FADE)
    r, g, b = _ground(atlas, eye.ceiling, _level(t / eye.focal * 1.5), eye.x + t * dx, eye.y + t * dy)
    return r * fade, g * fade, b * fade


@njit(cache=True)
def _exit(solid: IntArray, hits: FloatArray, surfaces: IntArray, sides: IntArray, k: int, n: int) -> float:
    """Return where the ray leaves the solid that it entered at hit k."""
    for m in range(k + 1, n):
        if sides[m] == BACK and solid[surfaces[m]] == solid[surfaces[k]]:
            return hits[m]
    return hits[k]


@njit(cache=True)
def render(scene: Scene, atlas: Atlas, eye: Eye, image: NDArray[np.uint8]) -> None:
    """Fill image (H, W, 3) RGB with what the camera sees, without noise."""
    height, width = image.shape[:2]
    hits, places = np.empty(MAX_HITS), np.empty((MAX_HITS, 2))
    surfaces, sides, levels = np.empty(MAX_HITS, np.int64), np.empty(MAX_HITS, np.int64), np.empty(MAX_HITS, np.int64)
    floor_t, ceiling_t = np.empty(height), np.empty(height)
    floor_level, ceiling_level = np.empty(height, np.int64), np.empty(height, np.int64)
    for r in range(height):
        rows = max(abs(r - eye.horizon), 1e-3)
        floor_t[r] = min(FAR, eye.height * eye.focal / rows)
        ceiling_t[r] = min(FAR, (eye.room - eye.height) * eye.focal / rows)
        # a ground pixel is longer than wide: the geometric mean of both decides
        floor_level[r] = _level(floor_t[r] / eye.focal * np.sqrt(max(1.0, floor_t[r] / eye.height)))
        rise = eye.room - eye.height
        ceiling_level[r] = _level(ceiling_t[r] / eye.focal * np.sqrt(max(1.0, ceiling_t[r] / rise)))
    for c in range(width):
        angle = eye.heading + (c - eye.forward_column) * eye.turn
        dx, dy = np.cos(angle), np.sin(angle)
        n = walk(scene, eye.x, eye.y, dx, dy, FAR, eye.room, hits, surfaces, sides)
        for k in range(n):
            px, py = eye.x + hits[k] * dx, eye.y + hits[k] * dy
            places[k, 0], levels[k], places[k, 1] = _texture(scene, surfaces[k], px, py, dx, dy, hits[k], eye.focal)
        y = height - 1  # what is seen fills the column from its foot upwards
        for k in range(n + 1):
            near = hits[k] if k < n else FAR
            if k < n and sides[k] == BACK:
                continue
            foot = eye.horizon + eye.focal * eye.height / near
            while y >= 0 and y > foot:
                t = floor_t[y]
                red, green, blue = _ground(atlas, eye.floor, floor_level[y], eye.x + t * dx, eye.y + t * dy)
                fade = eye.gain / (1 + t / FADE)
                if eye.gloss > 0.0:
                    share = eye.gloss * (0.3 + 0.7 * t / (t + 2.0))
                    mr, mg, mb = _mirror(
                        scene, atlas, eye, hits, places, levels, surfaces, sides, n, y - eye.horizon, t, dx, dy
                    )
                    keep, add = (1 - share) * fade, share * eye.gain
                    _put(image[y, c], (red * keep + mr * add, green * keep + mg * add, blue * keep + mb * add), 1.0)
                else:
                    _put(image[y, c], (red, green, blue), fade)
                y -= 1
            if k == n:
                break
            s = surfaces[k]
            top = scene.top[s]
            head = eye.horizon - eye.focal * (top - eye.height) / near
            while y >= 0 and y >= head:
                z = eye.height + (eye.horizon - y) * near / eye.focal
                _put(image[y, c], _sample(atlas, scene.tile[s], levels[k], places[k, 0], z), places[k, 1] * eye.gain)
                y -= 1
            if y < 0:
                break
            if top < eye.height and scene.kind[s] != SEGMENT:
                rim = eye.horizon + eye.focal * (eye.height - top) / _exit(scene.solid, hits, surfaces, sides, k, n)
                while y >= 0 and y > rim:
                    colour = _sample(atlas, scene.tile[s], LEVELS - 1, 0.0, 0.7 * top)
                    _put(image[y, c], colour, 1.15 * eye.gain / (1 + near / FADE))
                    y -= 1
        while y >= 0:
            t = ceiling_t[y]
            colour = _ground(atlas, eye.ceiling, ceiling_level[y], eye.x + t * dx, eye.y + t * dy)
            _put(image[y, c], colour, eye.gain / (1 + t / FADE))
            y -= 1


@njit(cache=True)
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
