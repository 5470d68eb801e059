"""How much room there is: the distance from a point to the next thing of a world, doors left out."""

from __future__ import annotations

import math

import numpy as np
import pymunk
from numpy.typing import NDArray

from sim2d.shapes import Spec

BODY = 0.2  # [m] radius that routes, places and grids must leave


class Clearance:
    """The walls, boxes and cylinders of a Spec in a space of their own, without looks; made once, asked often."""

    def __init__(self, spec: Spec) -> None:
        self._space = pymunk.Space()
        self._names: dict[pymunk.Shape, str] = {}
        ground = self._space.static_body
        for wall in spec.walls:
            for a, b in zip(wall.points, wall.points[1:], strict=False):
                self._add(pymunk.Segment(ground, a, b, 0.0), wall.name)
        for box in spec.boxes:
            self._add(pymunk.Poly(ground, list(box.points)), box.name)
        for thing in spec.cylinders:
            self._add(pymunk.Circle(ground, thing.radius, (thing.x, thing.y)), thing.name)

    def at(self, x: float, y: float, limit: float = 2.0) -> tuple[float, str]:
        """Return the distance to the next thing [m, negative inside it, at most `limit`] and its name."""
        found = self._space.point_query_nearest((x, y), limit, pymunk.ShapeFilter())
        return (limit, "") if found is None or found.shape is None else (found.distance, self._names[found.shape])

    def free(self, x: float, y: float, radius: float = BODY) -> bool:
        """Return whether a disc fits here."""
        return self.at(x, y, radius + 0.01)[0] >= radius

    def tightest(self, points: NDArray[np.float64], limit: float = 2.0) -> tuple[float, str, float, float]:
        """Return distance [m], name and x, y of the place among points (N, 2) with the least room."""
        found = [(*self.at(float(x), float(y), limit), float(x), float(y)) for x, y in points]
        return min(found, key=lambda row: row[0], default=(limit, "", math.nan, math.nan))

    def _add(self, shape: pymunk.Shape, name: str) -> None:
        self._space.add(shape)
        self._names[shape] = name


def grid_positions(spec: Spec, radius: float = BODY) -> NDArray[np.float64]:
    """Return the positions of a world's grid (rows, columns, 2) [m]; NaN where a body of `radius` does not fit.

    Without a grid the answer is empty, (0, 0, 2).
    """
    grid = spec.grid
    if grid is None:
        return np.zeros((0, 0, 2))
    clearance = Clearance(spec)
    x = grid.origin[0] + grid.spacing * np.arange(grid.columns)
    y = grid.origin[1] + grid.spacing * np.arange(grid.rows)
    positions = np.stack(np.meshgrid(x, y), axis=-1)
    for point in positions.reshape(-1, 2):
        if not clearance.free(float(point[0]), float(point[1]), radius):
            point[:] = math.nan
    return positions
