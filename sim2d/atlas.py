"""All textures of a world in one array, each at several resolutions, ready for the renderer."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from sim2d.canvas import TEXELS, Canvas, rectangle
from sim2d.decals import DECALS
from sim2d.errors import WorldError
from sim2d.paint import PAINTERS
from sim2d.shapes import Ground, Look
from sim2d.streams import stream

LEVELS = 6


class Atlas(NamedTuple):
    """Texels (N,) as `pack` makes them, u-major within a tile, v upwards; by tile and level: offset, texels along u, v.

    size (T, 2): length and height of a tile [m]. A tile repeats along u (ground tiles along both).
    """

    texels: NDArray[np.uint64]
    offset: NDArray[np.int64]
    nu: NDArray[np.int64]
    nv: NDArray[np.int64]
    size: NDArray[np.float64]


def pack(texels: NDArray[np.uint8]) -> NDArray[np.uint64]:
    """Return RGB texels (N, 3) as one number each, (N,): a channel every 21 bits.

    So four texels can be mixed, all channels at once, by four integer products whose weights sum to 4096.
    """
    wide = texels.astype(np.uint64)
    lanes: NDArray[np.uint64] = wide[:, 0] | wide[:, 1] << np.uint64(21) | wide[:, 2] << np.uint64(42)
    return lanes


def paint_look(look: Look, length: float, height: float, seed: int) -> Canvas:
    """Return the canvas of a whole surface; `seed` is the world's. Raises WorldError for an unknown painter."""
    if look.texture not in PAINTERS:
        raise WorldError(f"unknown texture {look.texture!r}; there are {', '.join(sorted(PAINTERS))}")
    canvas = PAINTERS[look.texture](length, height, look.colour, stream(seed, f"texture {look.seed}"))
    for decal in look.decals:
        if decal.kind not in DECALS:
            raise WorldError(f"unknown decal {decal.kind!r}; there are {', '.join(sorted(DECALS))}")
        rng = stream(seed, f"decal {decal.seed}")
        picture = DECALS[decal.kind](decal.length, decal.top - decal.base, decal.colour, rng)
        _paste(canvas, picture, decal.start, decal.base)
    return canvas


def paint_ground(ground: Ground, seed: int) -> Canvas:
    """Return the square canvas of a floor or ceiling tile, with its lamps."""
    canvas = paint_look(ground.look, ground.tile, ground.tile, seed)
    if ground.lamps > 0:
        half = 0.5 * ground.lamps
        for x in np.arange(half, ground.tile, ground.lamps):
            for y in np.arange(half, ground.tile, ground.lamps):
                rectangle(canvas, (x - 0.65, x + 0.65), (y - 0.2, y + 0.2), (0.5, 0.5, 0.5))
                rectangle(canvas, (x - 0.6, x + 0.6), (y - 0.15, y + 0.15), (1.0, 1.0, 0.95))
        # drawn clear of the tile's edges, then shifted round: a lamp may hang across them
        shift = round((ground.first_lamp - half) * TEXELS)
        canvas = np.roll(canvas, (-shift, shift), axis=(0, 1))
    return canvas


def _paste(canvas: Canvas, decal: Canvas, start: float, base: float) -> None:
    """Copy a decal onto a surface, cut at its edges."""
    v, u = canvas.shape[:2]
    i, foot = round(start * TEXELS), v - round(base * TEXELS)
    j = foot - decal.shape[0]
    j0, j1, i0, i1 = max(j, 0), min(foot, v), max(i, 0), min(i + decal.shape[1], u)
    if j0 < j1 and i0 < i1:
        canvas[j0:j1, i0:i1] = decal[j0 - j : j1 - j, i0 - i : i1 - i]


class AtlasBuilder:
    """Collects canvases; equal keys share a tile."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._known: dict[tuple[Look | Ground, float, float], int] = {}
        self._rows: list[tuple[list[int], list[int], list[int], tuple[float, float]]] = []
        self._parts: list[NDArray[np.uint64]] = []
        self._filled = 0

    def surface(self, look: Look, length: float, height: float) -> int:
        """Return the tile of a surface of length x height [m]. Raises WorldError for sizes that cannot be."""
        if not (0 < length < math.inf and 0 < height < math.inf):
            raise WorldError(f"a surface is {length} m long and {height} m high; lengths and heights are above 0")
        key = (look, round(length, 3), round(height, 3))
        if key not in self._known:
            self._known[key] = self._add(paint_look(look, length, height, self._seed), length, height)
        return self._known[key]

    def ground(self, ground: Ground) -> int:
        """Return the tile of a floor or ceiling."""
        key = (ground, ground.tile, ground.lamps)
        if key not in self._known:
            self._known[key] = self._add(paint_ground(ground, self._seed), ground.tile, ground.tile)
        return self._known[key]

    def build(self) -> Atlas:
        """Return the atlas of all tiles so far."""
        offset, nu, nv, size = zip(*self._rows, strict=True)
        return Atlas(
            np.concatenate(self._parts),
            np.array(offset, dtype=np.int64),
            np.array(nu, dtype=np.int64),
            np.array(nv, dtype=np.int64),
            np.array(size, dtype=np.float64),
        )

    def _add(self, canvas: Canvas, length: float, height: float) -> int:
        offset, nu, nv = [], [], []
        for level in range(LEVELS):
            v, u = (max(2, n >> level) for n in canvas.shape[:2])
            small = canvas if level == 0 else cv2.resize(canvas, (u, v), interpolation=cv2.INTER_AREA)
            texels = np.clip(np.asarray(small)[::-1] * 255.0 + 0.5, 0, 255).astype(np.uint8)
            offset.append(self._filled)
            nu.append(u)
            nv.append(v)
            self._parts.append(pack(np.ascontiguousarray(texels.transpose(1, 0, 2)).reshape(-1, 3)))
            self._filled += u * v
        self._rows.append((offset, nu, nv, (length, height)))
        return len(self._rows) - 1
