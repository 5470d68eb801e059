"""One column of the panorama, painted from its foot upwards."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim2d.atlas import LEVELS, Atlas
from sim2d.raycast import BACK, FloatArray, IntArray
from sim2d.scene import Scene
from sim2d.texel import blend, ground_colour, put, put_both

FADE = 30.0  # [m] distance at which brightness has halved


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


class Ground(NamedTuple):
    """A floor or ceiling by image row: distance [m], brightness (H, 2); tile entry, size (H, 2); tiles per metre."""

    reach: FloatArray
    tile: IntArray
    scale: float


@njit(cache=True, error_model="numpy")
def mirrored(
    hits: FloatArray, skins: FloatArray, sides: IntArray, k: int, n: int, scale: float, eye_height: float
) -> int:
    """Return the hit from k on that a polished floor shows `scale` (rows by focal length) below the horizon, or n."""
    m = k
    while m < n and (sides[m] == BACK or scale * hits[m] - eye_height >= skins[m, 6]):
        m += 1
    return m


@njit(cache=True, error_model="numpy")
def paint_floor(
    texels: NDArray[np.uint64], pixels: NDArray[np.uint8], width: int, c: int, y: int, foot: float,
    eye: Eye, floor: Ground, mirror: Ground, dx: float, dy: float,
    hits: FloatArray, skins: FloatArray, sides: IntArray, k: int, n: int,
) -> int:  # fmt: skip
    """Paint the floor from row y up to `foot`, where hit k stands on it; return the next row."""
    x0, y0, fdx, fdy = eye.x * floor.scale, eye.y * floor.scale, dx * floor.scale, dy * floor.scale
    while y >= 0 and y > foot:
        t, fade = floor.reach[y, 0], floor.reach[y, 1]
        p = 3 * (y * width + c)
        colour = ground_colour(texels, floor.tile[y, 0], floor.tile[y, 1], x0 + t * fdx, y0 + t * fdy)
        if eye.gloss > 0.0:
            scale = (y - eye.horizon) / eye.focal
            m = mirrored(hits, skins, sides, k, n, scale, eye.height)
            if m < n:
                v = (scale * hits[m] - eye.height) * skins[m, 4] - 0.5
                other = blend(texels, int(skins[m, 0]), int(skins[m, 1]), v, int(skins[m, 3]), int(skins[m, 2]))
                shine = skins[m, 5] * eye.gain
            else:
                d, shine, side = mirror.reach[y, 0], mirror.reach[y, 1], mirror.scale
                mx, my = (eye.x + d * dx) * side, (eye.y + d * dy) * side
                other = ground_colour(texels, mirror.tile[y, 0], mirror.tile[y, 1], mx, my)
            # stone mirrors more at a flatter angle
            share = eye.gloss * (0.3 + 0.7 * t / (t + 2.0))
            put_both(pixels, p, colour, (1 - share) * fade, other, share * shine)
        else:
            put(pixels, p, colour, fade)
        y -= 1
    return y


@njit(cache=True, error_model="numpy")
def paint_wall(
    texels: NDArray[np.uint64], pixels: NDArray[np.uint8], width: int, c: int, y: int, skin: FloatArray,
    near: float, eye: Eye,
) -> int:  # fmt: skip
    """Paint a surface from row y up to its top; return the next row."""
    head = eye.horizon - eye.focal * (skin[6] - eye.height) / near
    a, b, wu, nv, fade = int(skin[0]), int(skin[1]), int(skin[2]), int(skin[3]), skin[5] * eye.gain
    v0 = (eye.height + eye.horizon * near / eye.focal) * skin[4] - 0.5
    slope = near / eye.focal * skin[4]
    while y >= 0 and y >= head:
        put(pixels, 3 * (y * width + c), blend(texels, a, b, v0 - y * slope, nv, wu), fade)
        y -= 1
    return y


@njit(cache=True, error_model="numpy")
def paint_lid(
    scene: Scene, atlas: Atlas, pixels: NDArray[np.uint8], width: int, c: int, y: int, s: int,
    far: float, eye: Eye,
) -> int:  # fmt: skip
    """Paint a low solid's lid from row y up to where the ray leaves it, `far` [m] away; return the next row."""
    rim = eye.horizon + eye.focal * (eye.height - scene.top[s]) / far
    colour = atlas.texels[atlas.offset[scene.tile[s], LEVELS - 1]] * np.uint64(4096)
    while y >= 0 and y > rim:
        put(pixels, 3 * (y * width + c), colour, 1.1 * eye.gain / (1 + far / FADE))
        y -= 1
    return y


@njit(cache=True, error_model="numpy")
def paint_ceiling(
    texels: NDArray[np.uint64], pixels: NDArray[np.uint8], width: int, c: int, y: int, ground: Ground,
    x0: float, y0: float, dx: float, dy: float,
) -> None:  # fmt: skip
    """Paint the ceiling from row y up to the image's edge; place and direction in tiles."""
    while y >= 0:
        t = ground.reach[y, 0]
        colour = ground_colour(texels, ground.tile[y, 0], ground.tile[y, 1], x0 + t * dx, y0 + t * dy)
        put(pixels, 3 * (y * width + c), colour, ground.reach[y, 1])
        y -= 1
