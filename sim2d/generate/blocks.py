"""Floor space as square blocks: rectangles are cut out, and the edges between floor and rock become walls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim2d.shapes import Point


@dataclass(frozen=True, slots=True)
class Edge:
    """A straight stretch of wall from a to b [m]; the floor lies to its left."""

    a: Point
    b: Point


class Blocks:
    """Blocks of `side` [m]; `origin` is the lower left corner [m] of an area of `columns` x `rows` blocks."""

    def __init__(self, origin: Point, side: float, columns: int, rows: int) -> None:
        self._origin, self._side = origin, side
        self.floor = np.zeros((rows, columns), dtype=np.bool_)

    def cut(self, x0: float, y0: float, x1: float, y1: float) -> None:
        """Make a rectangle [m] floor; it must lie on the blocks' corners."""
        (i0, j0), (i1, j1) = self._block(x0, y0), self._block(x1, y1)
        self.floor[j0:j1, i0:i1] = True

    def edges(self) -> list[Edge]:
        """Return the stretches round the floor, each as long as it is straight."""
        padded = np.pad(self.floor, 1)
        out = []
        for j, below, above in zip(range(len(padded)), padded, padded[1:], strict=False):
            out += [Edge(self._point(i0, j), self._point(i1, j)) for i0, i1 in _runs(above & ~below)]
            out += [Edge(self._point(i1, j), self._point(i0, j)) for i0, i1 in _runs(below & ~above)]
        columns = padded.T
        for i, left, right in zip(range(len(columns)), columns, columns[1:], strict=False):
            out += [Edge(self._point(i, j1), self._point(i, j0)) for j0, j1 in _runs(right & ~left)]
            out += [Edge(self._point(i, j0), self._point(i, j1)) for j0, j1 in _runs(left & ~right)]
        return out

    def _block(self, x: float, y: float) -> tuple[int, int]:
        return round((x - self._origin[0]) / self._side), round((y - self._origin[1]) / self._side)

    def _point(self, i: int, j: int) -> Point:
        return round(self._origin[0] + i * self._side, 6), round(self._origin[1] + j * self._side, 6)


def _runs(marked: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return first and last corner of each run of marked blocks in a padded line."""
    steps = np.flatnonzero(np.diff(np.concatenate([[False], marked, [False]]).astype(np.int8)))
    return [(int(a) - 1, int(b) - 1) for a, b in steps.reshape(-1, 2)]
