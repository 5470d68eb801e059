"""A world's surfaces as flat arrays with a uniform grid over them, for the ray kernels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim2d.render.kernel import kernel

SEGMENT, EDGE, CIRCLE = 0, 1, 2
MARGIN = 1e-6  # [m] a surface on a cell's border is listed on both sides


class Scene(NamedTuple):
    """S surfaces: thin segments, outward edges of convex polygons (counter-clockwise), circles.

    kind (S,); line (S, 4): ax, ay, bx, by, or x, y, radius, 0 [m]; solid (S,): number of the body a surface belongs
    to; top (S,) [m]; tile (S,): texture; along (S,): surface coordinate at a [m]; light (S,): brightness factor.
    The grid: origin (2,) [m], cell [m], cells (2,); surfaces of cell c are `items[first[c]:first[c + 1]]`. Only the
    first `fixed` surfaces are in it; the circles behind them move: their rows may be written at any time.
    """

    kind: NDArray[np.int64]
    line: NDArray[np.float64]
    solid: NDArray[np.int64]
    top: NDArray[np.float64]
    tile: NDArray[np.int64]
    along: NDArray[np.float64]
    light: NDArray[np.float64]
    origin: NDArray[np.float64]
    cell: float
    cells: NDArray[np.int64]
    first: NDArray[np.int64]
    items: NDArray[np.int64]
    fixed: int


class Surfaces(NamedTuple):
    """Surfaces before the grid is laid; fields as in Scene."""

    kind: NDArray[np.int64]
    line: NDArray[np.float64]
    solid: NDArray[np.int64]
    top: NDArray[np.float64]
    tile: NDArray[np.int64]
    along: NDArray[np.float64]
    light: NDArray[np.float64]


def build(surfaces: Surfaces, moving: int = 0, per_cell: float = 1.0) -> Scene:
    """Lay a grid over all surfaces but the last `moving`, with about `per_cell` surfaces to a cell."""
    fixed = len(surfaces.kind) - moving
    kind, line = surfaces.kind[:fixed], surfaces.line[:fixed]
    low, high = _bounds(kind, line)
    extent = np.maximum(high - low, 0.1) + 4 * MARGIN
    count = max(1, fixed)
    cell = float(np.clip(np.sqrt(extent[0] * extent[1] * per_cell / count), 0.25, 4.0))
    cells = np.ceil(extent / cell).astype(np.int64)
    origin = low - 2 * MARGIN
    sizes = np.zeros(cells[0] * cells[1] + 1, dtype=np.int64)
    _fill(kind, line, origin, cell, cells, sizes, np.zeros(0, dtype=np.int64))
    first = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(sizes[:-1])])
    items = np.zeros(first[-1], dtype=np.int64)
    _fill(kind, line, origin, cell, cells, first[:-1].copy(), items)
    return Scene(*surfaces, origin, cell, cells, first, items, fixed)


def _bounds(kind: NDArray[np.int64], line: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the lower and upper corner (2,) [m] of all surfaces."""
    if len(kind) == 0:
        return np.zeros(2), np.ones(2)
    circle = (kind == CIRCLE)[:, None]
    radius = np.where(circle, line[:, 2:3], 0.0)
    a, b = line[:, :2], np.where(circle, line[:, :2], line[:, 2:])
    return (np.minimum(a, b) - radius).min(axis=0), (np.maximum(a, b) + radius).max(axis=0)


@kernel
def _fill(
    kind: NDArray[np.int64],
    line: NDArray[np.float64],
    origin: NDArray[np.float64],
    cell: float,
    cells: NDArray[np.int64],
    cursor: NDArray[np.int64],
    items: NDArray[np.int64],
) -> None:
    """Write each surface into every cell it touches at `cursor`, which moves on; without items only count."""
    for s in range(len(kind)):
        ax, ay, bx, by = line[s]
        r = 0.0
        if kind[s] == CIRCLE:
            r = bx
            bx, by = ax, ay
        i0 = max(0, int(np.floor((min(ax, bx) - r - MARGIN - origin[0]) / cell)))
        i1 = min(cells[0] - 1, int(np.floor((max(ax, bx) + r + MARGIN - origin[0]) / cell)))
        j0 = max(0, int(np.floor((min(ay, by) - r - MARGIN - origin[1]) / cell)))
        j1 = min(cells[1] - 1, int(np.floor((max(ay, by) + r + MARGIN - origin[1]) / cell)))
        # how far a cell's corners reach across the segment's line decides whether the line meets the cell
        nx, ny = ay - by, bx - ax
        length = np.hypot(nx, ny)
        for j in range(j0, j1 + 1):
            for i in range(i0, i1 + 1):
                if kind[s] != CIRCLE:
                    cx = origin[0] + (i + 0.5) * cell
                    cy = origin[1] + (j + 0.5) * cell
                    reach = 0.5 * cell * (abs(nx) + abs(ny)) + MARGIN * length
                    if abs(nx * (cx - ax) + ny * (cy - ay)) > reach:
                        continue
                c = j * cells[0] + i
                if len(items) > 0:
                    items[cursor[c]] = s
                cursor[c] += 1
