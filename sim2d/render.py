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
SHIFT = np.uint64(21)  # between the channels of a packed colour
LANE = np.uint64((1 << 21) - 1)
WHITE = np.int64(255)
HALF = 1 << 23  # a half, for rounding


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


@njit(cache=True, error_model="numpy")
def _level(footprint: float) -> int:
    """Return the resolution level at which a texel is about as big as a pixel's footprint [m]."""
    level, size = 0, footprint * TEXELS
    while size > 1.5 and level < LEVELS - 1:
        size *= 0.5
        level += 1
    return level


@njit(cache=True, error_model="numpy")
def _blend(texels: NDArray[np.uint64], a: int, b: int, v: float, nv: int, wu: int) -> np.uint64:
    """Return the packed bilinear colour, times 4096, at row v of a tile, between its columns that begin at a and b;
    wu in 0..64 is b's share."""
    q = min(max(int(v * 64.0), 0), (nv - 1) * 64 - 1) if nv > 1 else 0
    j, wv = q >> 6, q & 63
    k = j + 1 if nv > 1 else j
    mixed: np.uint64 = (
        texels[a + j] * np.uint64((64 - wu) * (64 - wv))
        + texels[a + k] * np.uint64((64 - wu) * wv)
        + texels[b + j] * np.uint64(wu * (64 - wv))
        + texels[b + k] * np.uint64(wu * wv)
    )
    return mixed


@njit(cache=True, error_model="numpy")
def _ground(texels: NDArray[np.uint64], base: int, n: int, x: float, y: float) -> np.uint64:
    """Return the packed colour of a floor or ceiling at x, y [tiles]; n texels to a tile."""
    fine = n * 64
    u = int((x - np.floor(x)) * fine) + fine - 32
    i = u >> 6
    i = i - n if i >= n else i
    k = i + 1 if i + 1 < n else 0
    mixed: np.uint64 = _blend(texels, base + n * i, base + n * k, (y - np.floor(y)) * n - 0.5, n, u & 63)
    return mixed


@njit(cache=True, error_model="numpy")
def _put(pixels: NDArray[np.uint8], p: int, colour: np.uint64, factor: float) -> None:
    """Store a packed colour times a factor at entry p."""
    f = int(factor * 4096.0)
    for c in range(3):
        pixels[p + c] = np.uint8(min(WHITE, (np.int64(colour & LANE) * f + HALF) >> 24))
        colour >>= SHIFT


@njit(cache=True, error_model="numpy")
def _put_both(
    pixels: NDArray[np.uint8], p: int, colour: np.uint64, factor: float, other: np.uint64, share: float
) -> None:
    """Store the sum of two packed colours, each times its factor, at entry p."""
    f, g = int(factor * 4096.0), int(share * 4096.0)
    for c in range(3):
        level = np.int64(colour & LANE) * f + np.int64(other & LANE) * g + HALF
        pixels[p + c] = np.uint8(min(WHITE, level >> 24))
        colour >>= SHIFT
        other >>= SHIFT


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
    level = _level(t / eye.focal / np.sqrt(max(0.05, abs(nx * dx + ny * dy))))
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
def _rows(atlas: Atlas, eye: Eye, tile: int, rise: float, height: int) -> tuple[FloatArray, IntArray]:
    """Return by row a ground's distance [m] and brightness (H, 2), and its tile's entry and size (H, 2)."""
    distance, tiles = np.empty((height, 2)), np.empty((height, 2), np.int64)
    for r in range(height):
        t = min(FAR, rise * eye.focal / max(abs(r - eye.horizon), 1e-3))
        distance[r, 0], distance[r, 1] = t, eye.gain / (1 + t / FADE)
        # a ground pixel is longer than wide: the geometric mean of both decides
        level = _level(t / eye.focal * np.sqrt(max(1.0, t / rise)))
        tiles[r, 0], tiles[r, 1] = atlas.offset[tile, level], atlas.nu[tile, level]
    return distance, tiles


@njit(cache=True, error_model="numpy")
def render(scene: Scene, atlas: Atlas, eye: Eye, image: NDArray[np.uint8]) -> None:
    """Fill image (H, W, 3) RGB with what the camera sees, without noise."""
    height, width = image.shape[:2]
    texels, pixels = atlas.texels, image.reshape(-1)
    hits, skins = np.empty(MAX_HITS), np.empty((MAX_HITS, 7))
    surfaces, sides = np.empty(MAX_HITS, np.int64), np.empty(MAX_HITS, np.int64)
    floor, floor_tile = _rows(atlas, eye, eye.floor, eye.height, height)
    ceiling, ceiling_tile = _rows(atlas, eye, eye.ceiling, eye.room - eye.height, height)
    mirror, mirror_tile = _rows(atlas, eye, eye.ceiling, eye.room + eye.height, height)
    floor_side, ceiling_side = 1 / atlas.size[eye.floor, 0], 1 / atlas.size[eye.ceiling, 0]
    for c in range(width):
        angle = eye.heading + (c - eye.forward_column) * eye.turn
        dx, dy = np.cos(angle), np.sin(angle)
        n = walk(scene, eye.x, eye.y, dx, dy, FAR, eye.room, hits, surfaces, sides)
        for k in range(n):
            _skin(scene, atlas, surfaces[k], eye, dx, dy, hits[k], skins[k])
        fx, fy, fdx, fdy = eye.x * floor_side, eye.y * floor_side, dx * floor_side, dy * floor_side
        cx, cy, cdx, cdy = eye.x * ceiling_side, eye.y * ceiling_side, dx * ceiling_side, dy * ceiling_side
        y = height - 1  # what is seen fills the column from its foot upwards
        for k in range(n + 1):
            if k < n and sides[k] == BACK:
                continue
            near = hits[k] if k < n else FAR
            foot = eye.horizon + eye.focal * eye.height / near
            while y >= 0 and y > foot:
                t, fade = floor[y]
                colour = _ground(texels, floor_tile[y, 0], floor_tile[y, 1], fx + t * fdx, fy + t * fdy)
                if eye.gloss > 0.0:
                    share = eye.gloss * (0.3 + 0.7 * t / (t + 2.0))
                    scale, m = (y - eye.horizon) / eye.focal, k
                    while m < n and (sides[m] == BACK or scale * hits[m] - eye.height >= skins[m, 6]):
                        m += 1
                    if m < n:
                        v = (scale * hits[m] - eye.height) * skins[m, 4] - 0.5
                        other = _blend(
                            texels, int(skins[m, 0]), int(skins[m, 1]), v, int(skins[m, 3]), int(skins[m, 2])
                        )
                        shine = skins[m, 5] * eye.gain
                    else:
                        d, shine = mirror[y]
                        other = _ground(texels, mirror_tile[y, 0], mirror_tile[y, 1], cx + d * cdx, cy + d * cdy)
                    _put_both(pixels, 3 * (y * width + c), colour, (1 - share) * fade, other, share * shine)
                else:
                    _put(pixels, 3 * (y * width + c), colour, fade)
                y -= 1
            if k == n or y < 0:
                break
            head = eye.horizon - eye.focal * (skins[k, 6] - eye.height) / near
            a, b, wu, nv = int(skins[k, 0]), int(skins[k, 1]), int(skins[k, 2]), int(skins[k, 3])
            v0 = (eye.height + eye.horizon * near / eye.focal) * skins[k, 4] - 0.5
            slope, fade = near / eye.focal * skins[k, 4], skins[k, 5] * eye.gain
            while y >= 0 and y >= head:
                _put(pixels, 3 * (y * width + c), _blend(texels, a, b, v0 - y * slope, nv, wu), fade)
                y -= 1
            s = surfaces[k]
            if skins[k, 6] < eye.height and scene.kind[s] != SEGMENT:
                far = _exit(scene.solid, hits, surfaces, sides, k, n)
                rim = eye.horizon + eye.focal * (eye.height - skins[k, 6]) / far
                lid = texels[atlas.offset[scene.tile[s], LEVELS - 1]] * np.uint64(4096)
                while y >= 0 and y > rim:
                    _put(pixels, 3 * (y * width + c), lid, 1.1 * eye.gain / (1 + near / FADE))
                    y -= 1
        while y >= 0:
            t, fade = ceiling[y]
            colour = _ground(texels, ceiling_tile[y, 0], ceiling_tile[y, 1], cx + t * cdx, cy + t * cdy)
            _put(pixels, 3 * (y * width + c), colour, fade)
            y -= 1


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
