"""One column of the panorama, painted from its foot upwards."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim2d.render.atlas import LEVELS, Atlas
from sim2d.render.kernel import kernel
from sim2d.render.lights import Glow, glow_at
from sim2d.render.raycast import BACK, FloatArray, IntArray
from sim2d.render.scene import Scene
from sim2d.render.texel import ONE, THIN, along_v, blend, ground_colour, put

FADE = 30.0  # [m] distance at which brightness has halved


class Eye(NamedTuple):
    """Camera and room: x, y [m], heading [rad], eye height [m], focal [pixels], horizon row, recorded column of the
    nose, turn per column [rad], room height [m], floor and ceiling tile, floor gloss."""

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


class Ground(NamedTuple):
    """A floor or ceiling by image row: distance (H,) [m]; weight of its colour and of what it mirrors (H,); entry
    and size of its texture (H,); tiles per metre."""

    reach: FloatArray
    weight: IntArray
    shine: IntArray
    base: IntArray
    size: IntArray
    scale: float


@kernel
def paint_floor(
    texels: NDArray[np.uint64], tones: NDArray[np.uint8], pixels: NDArray[np.uint8], width: int, c: int, y: int,
    foot: float, eye: Eye, glow: Glow, floor: Ground, mirror: Ground, dx: float, dy: float,
    hits: FloatArray, skins: FloatArray, k: int, n: int,
) -> int:  # fmt: skip
    """Paint the floor from row y up to `foot`, where hit k stands on it; return the next row."""
    x0, y0, fdx, fdy = eye.x * floor.scale, eye.y * floor.scale, dx * floor.scale, dy * floor.scale
    mx, my, mdx, mdy = eye.x * mirror.scale, eye.y * mirror.scale, dx * mirror.scale, dy * mirror.scale
    stop = max(-1, int(np.floor(foot)))
    for row in range(y, stop, -1):
        t, weight = floor.reach[row], floor.weight[row]
        if glow.lit:
            weight = int(weight * glow_at(glow, eye.x + t * dx, eye.y + t * dy, 0))
        colour = ground_colour(texels, floor.base[row], floor.size[row], x0 + t * fdx, y0 + t * fdy, weight)
        if eye.gloss > 0.0:
            m = k
            while m < n and row >= skins[m, 7]:
                m += 1
            if m < n:
                v = ((row - eye.horizon) / eye.focal * hits[m] - eye.height) * skins[m, 4] - 0.5
                q, share = along_v(v, int(skins[m, 3])), int(floor.shine[row] * skins[m, 5])
                colour += blend(texels, int(skins[m, 0]), int(skins[m, 1]), q, int(skins[m, 2]), share)
            else:
                d, share = mirror.reach[row], mirror.shine[row]
                if glow.lit:
                    share = int(share * glow_at(glow, eye.x + d * dx, eye.y + d * dy, 1))
                colour += ground_colour(texels, mirror.base[row], mirror.size[row], mx + d * mdx, my + d * mdy, share)
        put(pixels, 3 * (row * width + c), colour, tones)
    return min(y, stop)


@kernel
def paint_wall(
    texels: NDArray[np.uint64], tones: NDArray[np.uint8], pixels: NDArray[np.uint8], width: int, c: int, y: int,
    skin: FloatArray, near: float, eye: Eye, mixed: NDArray[np.uint64],
) -> int:  # fmt: skip
    """Paint a surface from row y up to its top; return the next row. `mixed` is room for one column of texels."""
    head = eye.horizon - eye.focal * (skin[6] - eye.height) / near
    stop = max(-1, int(np.ceil(head)) - 1)
    if stop >= y:
        return y
    a, b, nv = int(skin[0]), int(skin[1]), int(skin[3])
    weight = int(skin[5] * ONE)
    right = (weight * int(skin[2])) >> 6
    left, more = np.uint64(weight - right), np.uint64(right)
    v0 = (eye.height + eye.horizon * near / eye.focal) * skin[4] - 0.5
    slope = near / eye.focal * skin[4]
    low, high = along_v(v0 - y * slope, nv) >> 6, (along_v(v0 - (stop + 1) * slope, nv) >> 6) + 1
    six = np.uint64(6)
    for j in range(high - low + 1):
        both = texels[np.uint64(a + low + j)] * left + texels[np.uint64(b + low + j)] * more
        mixed[np.uint64(j)] = both >> six & THIN
    for row in range(y, stop, -1):
        q = along_v(v0 - row * slope, nv)
        k, wv = np.uint64((q >> 6) - low), np.uint64(q & 63)
        colour = mixed[k] * (np.uint64(64) - wv) + mixed[k + np.uint64(1)] * wv
        put(pixels, 3 * (row * width + c), colour, tones)
    return stop


@kernel
def paint_lid(
    scene: Scene, atlas: Atlas, tones: NDArray[np.uint8], pixels: NDArray[np.uint8], width: int, c: int, y: int, s: int,
    far: float, eye: Eye, glow: Glow, dx: float, dy: float,
) -> int:  # fmt: skip
    """Paint a low solid's lid from row y up to where the ray leaves it, `far` [m] away; return the next row."""
    rim = eye.horizon + eye.focal * (eye.height - scene.top[s]) / far
    factor = 1.1 / (1 + far / FADE)
    if glow.lit:
        factor *= glow_at(glow, eye.x + far * dx, eye.y + far * dy, 0)
    # the coarsest texel is mixed of darker and brighter ones: twice white doesn't come up here
    colour = atlas.texels[atlas.offset[scene.tile[s], LEVELS - 1]] * np.uint64(int(factor * ONE))
    stop = max(-1, int(np.floor(rim)))
    for row in range(y, stop, -1):
        put(pixels, 3 * (row * width + c), colour, tones)
    return min(y, stop)


@kernel
def paint_ceiling(
    texels: NDArray[np.uint64], tones: NDArray[np.uint8], pixels: NDArray[np.uint8], width: int, c: int, y: int,
    eye: Eye, glow: Glow, ground: Ground, dx: float, dy: float,
) -> None:  # fmt: skip
    """Paint the ceiling from row y up to the image's edge."""
    x0, y0, fdx, fdy = eye.x * ground.scale, eye.y * ground.scale, dx * ground.scale, dy * ground.scale
    for row in range(y, -1, -1):
        t, weight = ground.reach[row], ground.weight[row]
        if glow.lit:
            weight = int(weight * glow_at(glow, eye.x + t * dx, eye.y + t * dy, 1))
        colour = ground_colour(texels, ground.base[row], ground.size[row], x0 + t * fdx, y0 + t * fdy, weight)
        put(pixels, 3 * (row * width + c), colour, tones)


@kernel
def mirror_rows(hits: FloatArray, sides: IntArray, skins: FloatArray, n: int, eye: Eye) -> None:
    """Write for each hit the row from which on, downwards, a polished floor shows no more of it."""
    for k in range(n):
        skins[k, 7] = -1.0 if sides[k] == BACK else eye.horizon + eye.focal * (skins[k, 6] + eye.height) / hits[k]
