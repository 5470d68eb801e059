"""A tour through a floor plan's free space: away from walls, through the far corners, and back."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra

from sim2d.errors import WorldError
from sim2d.floorplan.map_file import FloorMap
from sim2d.shapes import Point

ROOM = 0.3  # [m] the tour keeps off the walls: the body and a little
WIDE = 0.8  # [m] more room than this is not sought
COARSE = 0.1  # [m] side of the cells the way is sought on
STOPS = 7  # places that the tour goes by
Cells = NDArray[np.int64]


class Lattice:
    """The free cells of a plan as a graph: steps to the eight neighbours, dearer near walls."""

    def __init__(self, plan: FloorMap) -> None:
        self._factor = max(1, round(COARSE / plan.resolution))
        self._plan = plan
        padded = np.pad(plan.free, 1)
        room = cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1] * plan.resolution
        half = self._factor // 2
        self.room = np.asarray(room[half :: self._factor, half :: self._factor], dtype=np.float64)
        self.open = self.room >= ROOM + 0.5 * plan.resolution
        self.graph = self._graph()

    def point(self, node: int) -> Point:
        """Return the map coordinates of a cell [m]."""
        row, column = divmod(node, self.open.shape[1])
        half = self._factor // 2
        at = self._plan.points(np.array([[column * self._factor + half, row * self._factor + half]], dtype=np.float64))
        return float(at[0, 0]), float(at[0, 1])

    def node(self, point: Point) -> int | None:
        """Return the open cell next to a point [m], None where there is none within half a metre."""
        row, column = self._plan.cell(point)
        rows, columns = np.nonzero(self.open)
        off = np.hypot(rows * self._factor - row, columns * self._factor - column) * self._plan.resolution
        best = int(np.argmin(off)) if len(off) else -1
        if best < 0 or off[best] > 0.5:
            return None
        found: int = int(rows[best]) * self.open.shape[1] + int(columns[best])
        return found

    def ways(self, node: int) -> tuple[NDArray[np.float64], Cells]:
        """Return the cost to every cell and its predecessor on the way from a cell."""
        cost, before = dijkstra(self.graph, indices=[node], return_predecessors=True)
        return cost[0], before[0].astype(np.int64)

    def _graph(self) -> csr_array[np.float64]:
        rows, columns = self.open.shape
        number = np.arange(rows * columns).reshape(rows, columns)
        price = 1 + 3 * np.clip((WIDE - self.room) / WIDE, 0, 1)
        starts, ends, costs = [], [], []
        for di, dj in ((0, 1), (1, 0), (1, 1), (1, -1)):
            here = (slice(0, rows - di), slice(max(0, -dj), columns - max(0, dj)))
            there = (slice(di, rows), slice(max(0, dj), columns - max(0, -dj)))
            both = self.open[here] & self.open[there]
            starts.append(number[here][both])
            ends.append(number[there][both])
            costs.append(0.5 * (price[here] + price[there])[both] * np.hypot(di, dj))
        a, b, c = np.concatenate(starts), np.concatenate(ends), np.concatenate(costs)
        size = rows * columns
        return coo_array(
            (np.concatenate([c, c]), (np.concatenate([a, b]), np.concatenate([b, a]))), (size, size)
        ).tocsr()


def find_route(plan: FloorMap, points: tuple[Point, ...], source: str) -> tuple[Point, ...]:
    """Return the corners of a closed tour [m], through `points` in their order or by far-off places found here.

    Raises WorldError where there is no room or no way.
    """
    lattice = Lattice(plan)
    stops = _given(lattice, points, source) if points else _far_apart(lattice, source)
    corners: list[Point] = []
    for here, there in zip(stops, [*stops[1:], stops[0]], strict=True):
        cost, before = lattice.ways(here)
        if not np.isfinite(cost[there]):
            raise WorldError(f"{source}: points = {list(lattice.point(there))}: no way leads there from the one before")
        corners += _straightened(lattice, _way(before, here, there))[:-1]
    return tuple(corners)


def _given(lattice: Lattice, points: tuple[Point, ...], source: str) -> list[int]:
    nodes = [lattice.node(point) for point in points]
    for k, node in enumerate(nodes):
        if node is None:
            raise WorldError(f"{source}: points[{k}] = {list(points[k])}: there must be {ROOM} m of room around it")
    known = [node for node in nodes if node is not None]
    if len(known) < 2:
        raise WorldError(f"{source}: points = {len(known)}: at least two are needed")
    return known


def _far_apart(lattice: Lattice, source: str) -> list[int]:
    """Return roomy cells, each as far as can be from those before, in the order of a round trip."""
    if not lattice.open.any():
        raise WorldError(f"{source}: image: nowhere is there {ROOM} m of room for a robot")
    first = int(np.argmax(np.where(lattice.open, lattice.room, -1)))
    nearest, _ = lattice.ways(first)
    reachable = np.isfinite(nearest)
    roomy = reachable & (lattice.room.ravel() >= min(0.5, float(np.median(lattice.room.ravel()[reachable]))))
    stops, costs = [first], [nearest]
    for _ in range(STOPS - 1):
        far = int(np.argmax(np.where(roomy, nearest, -1)))
        if nearest[far] * COARSE < 2.0:
            break
        stops.append(far)
        costs.append(lattice.ways(far)[0])
        nearest = np.minimum(nearest, costs[-1])
    if len(stops) < 2:
        raise WorldError(f"{source}: image: the free area is too small for a tour")
    return [stops[k] for k in _round_trip(np.array([cost[stops] for cost in costs]))]


def _round_trip(costs: NDArray[np.float64]) -> list[int]:
    """Return an order of a few places that keeps the way round short: nearest next, then crossings undone."""
    order, left = [0], set(range(1, len(costs)))
    while left:
        order.append(min(sorted(left), key=lambda k: costs[order[-1], k]))
        left.remove(order[-1])
    best = True
    while best:
        best = False
        for i in range(1, len(order) - 1):
            for j in range(i + 1, len(order)):
                other = [*order[:i], *order[i : j + 1][::-1], *order[j + 1 :]]
                if _round(costs, other) < _round(costs, order) - 1e-9:
                    order, best = other, True
    return order


def _round(costs: NDArray[np.float64], order: list[int]) -> float:
    return float(sum(costs[a, b] for a, b in zip(order, [*order[1:], order[0]], strict=True)))


def _way(before: Cells, here: int, there: int) -> list[int]:
    way = [there]
    while way[-1] != here:
        way.append(int(before[way[-1]]))
    return way[::-1]


def _straightened(lattice: Lattice, way: list[int]) -> list[Point]:
    """Return the corners of a way, without those that a straight line may leave out."""
    columns = lattice.open.shape[1]
    cells = np.array([[node % columns, node // columns] for node in way], dtype=np.int32)
    kept = cv2.approxPolyDP(cells[:, None], 1.0, closed=False)[:, 0]
    return [lattice.point(int(row) * columns + int(column)) for column, row in kept]
