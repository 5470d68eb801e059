"""All textures of a world in one array, each at several resolutions, ready for the renderer."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from sim2d.errors import WorldError
from sim2d.render.canvas import TEXELS, Canvas, rectangle
from sim2d.render.decals import DECALS
from sim2d.render.hours import lamp_level, sky_colour, sky_level
from sim2d.render.paint import PAINTERS
from sim2d.shapes import Colour, Decal, Ground, Look
from sim2d.streams import stream

LEVELS = 6
BRIGHTEST = 2.0  # what shines itself may be twice as bright as white


class Atlas(NamedTuple):
    """Texels (N,) as `pack` makes them, u-major within a tile, v upwards; by tile and level: offset, texels along u, v.

    size (T, 2): length and height of a tile [m]. A tile repeats along u (ground tiles along both).
    """

    texels: NDArray[np.uint64]
    offset: NDArray[np.int64]
    nu: NDArray[np.int64]
    nv: NDArray[np.int64]
    size: NDArray[np.float64]


def pack(texels: NDArray[np.uint16]) -> NDArray[np.uint64]:
    """Return RGB texels (N, 3) as one number each, (N,): a channel every 21 bits.

    So four texels can be mixed, all channels at once, by four integer products whose weights sum to 4096.
    """
    wide = texels.astype(np.uint64)
    lanes: NDArray[np.uint64] = wide[:, 0] | wide[:, 1] << np.uint64(21) | wide[:, 2] << np.uint64(42)
    return lanes


def paint_look(look: Look, length: float, height: float, seed: int, hour: float | None = None) -> Canvas:
    """Return the canvas of a whole surface; `seed` is the world's; window panes are as bright as the sky at `hour`.

    Raises WorldError for an unknown painter.
    """
    if look.texture not in PAINTERS:
        raise WorldError(f"unknown texture {look.texture!r}; there are {', '.join(sorted(PAINTERS))}")
    canvas = PAINTERS[look.texture](length, height, look.colour, stream(seed, f"texture {look.seed}"))
    for decal in look.decals:
        if decal.kind not in DECALS:
            raise WorldError(f"unknown decal {decal.kind!r}; there are {', '.join(sorted(DECALS))}")
        picture = _picture(decal, seed)
        if hour is not None and decal.kind == "window":
            picture = _lit_panes(picture, decal, seed, hour)
        _paste(canvas, picture, decal.start, decal.base)
    return canvas


def _picture(decal: Decal, seed: int) -> Canvas:
    rng = stream(seed, f"decal {decal.seed}")
    return DECALS[decal.kind](decal.length, decal.top - decal.base, decal.colour, rng)


def _lit_panes(picture: Canvas, decal: Decal, seed: int, hour: float) -> Canvas:
    """Return a window's picture with its panes, which are where its frame's colour makes no difference, lit."""
    black, white = (_picture(replace(decal, colour=c), seed) for c in ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))
    panes = (black == white).all(axis=2, keepdims=True)
    sky = np.asarray(sky_colour(hour), dtype=np.float32) * np.float32(max(0.03, BRIGHTEST * sky_level(hour)))
    return np.asarray(np.where(panes, np.clip(picture, 0, 1) * sky, picture), dtype=np.float32)


def paint_ground(ground: Ground, seed: int, hour: float | None = None) -> Canvas:
    """Return the square canvas of a floor or ceiling tile, with its lamps as bright as at `hour`."""
    canvas = paint_look(ground.look, ground.tile, ground.tile, seed)
    bright = 1.0 if hour is None else BRIGHTEST * lamp_level(hour)
    if ground.lamps > 0:
        half = 0.5 * ground.lamps
        for x in np.arange(half, ground.tile, ground.lamps):
            for y in np.arange(half, ground.tile, ground.lamps):
                rectangle(canvas, (x - 0.65, x + 0.65), (y - 0.2, y + 0.2), (0.5, 0.5, 0.5))
                rectangle(canvas, (x - 0.6, x + 0.6), (y - 0.15, y + 0.15), shade_up((1.0, 1.0, 0.95), bright))
        # drawn clear of the tile's edges, then shifted round: a lamp may hang across them
        shift = round((ground.first_lamp - half) * TEXELS)
        canvas = np.roll(canvas, (-shift, shift), axis=(0, 1))
    return canvas


def shade_up(colour: Colour, factor: float) -> Colour:
    """Return a colour times a factor, brighter than white where it comes to that."""
    r, g, b = (c * factor for c in colour)
    return r, g, b


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
        self._hour: float | None = None
        self._known: dict[tuple[Look | Ground, float, float], int] = {}
        self._rows: list[tuple[list[int], list[int], list[int], tuple[float, float]]] = []
        self._parts: list[NDArray[np.uint64]] = []
        self._filled = 0
        self._built: Atlas | None = None

    def surface(self, look: Look, length: float, height: float) -> int:
        """Return the tile of a surface of length x height [m]. Raises WorldError for sizes that cannot be."""
        if not (0 < length < math.inf and 0 < height < math.inf):
            raise WorldError(f"a surface is {length} m long and {height} m high; lengths and heights are above 0")
        return self._tile((look, round(length, 3), round(height, 3)), length, height)

    def ground(self, ground: Ground) -> int:
        """Return the tile of a floor or ceiling."""
        return self._tile((ground, ground.tile, ground.lamps), ground.tile, ground.tile)

    def build(self) -> Atlas:
        """Return the atlas of all tiles so far; the same one while none is added."""
        if self._built is None:
            offset, nu, nv, size = zip(*self._rows, strict=True)
            texels = np.concatenate(self._parts)
            self._parts = [texels]
            starts, us, vs = (np.array(part, dtype=np.int64) for part in (offset, nu, nv))
            self._built = Atlas(texels, starts, us, vs, np.array(size, dtype=np.float64))
        return self._built

    def repaint(self, hour: float | None) -> None:
        """Paint what shines itself, windows and lamps, as it is at an hour of the day, into the atlas in place."""
        atlas, self._hour = self.build(), hour
        for (what, length, height), tile in self._known.items():
            if shines(what):
                levels = _levels(self._paint(what, length, height), 1.0 if hour is None else BRIGHTEST)
                texels = np.concatenate([pack(level) for _, _, level in levels])
                atlas.texels[atlas.offset[tile, 0] : atlas.offset[tile, 0] + len(texels)] = texels

    def _tile(self, key: tuple[Look | Ground, float, float], length: float, height: float) -> int:
        if key not in self._known:
            self._known[key] = self._add(self._paint(key[0], length, height), length, height)
        return self._known[key]

    def _paint(self, what: Look | Ground, length: float, height: float) -> Canvas:
        if isinstance(what, Ground):
            return paint_ground(what, self._seed, self._hour)
        return paint_look(what, length, height, self._seed, self._hour)

    def _add(self, canvas: Canvas, length: float, height: float) -> int:
        offset, nu, nv = [], [], []
        for u, v, texels in _levels(canvas, 1.0):
            offset.append(self._filled)
            nu.append(u)
            nv.append(v)
            self._parts.append(pack(texels))
            self._filled += u * v
        self._rows.append((offset, nu, nv, (length, height)))
        self._built = None
        return len(self._rows) - 1


def shines(what: Look | Ground) -> bool:
    """Return whether something is painted otherwise at another hour."""
    return what.lamps > 0 if isinstance(what, Ground) else any(decal.kind == "window" for decal in what.decals)


def _levels(canvas: Canvas, brightest: float) -> Iterator[tuple[int, int, NDArray[np.uint16]]]:
    """Yield a canvas at each resolution: texels along u, along v, and the texels (u v, 3), u-major, v upwards."""
    for level in range(LEVELS):
        v, u = (max(2, n >> level) for n in canvas.shape[:2])
        small = canvas if level == 0 else cv2.resize(canvas, (u, v), interpolation=cv2.INTER_AREA)
        texels = np.clip(np.asarray(small)[::-1] * 255.0 + 0.5, 0, 255 * brightest).astype(np.uint16)
        yield u, v, np.ascontiguousarray(texels.transpose(1, 0, 2)).reshape(-1, 3)
