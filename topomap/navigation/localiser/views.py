"""The map's snapshots as the belief sees them: how unlike each is to the view, turned and moved as it may be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import TAU, wrap_all
from topomap.mapping.places.recognition import Recognition
from topomap.vision.image.compare import parabola
from topomap.vision.image.surroundings import Surroundings

SAMPLE = 40
"""Places by which it is told how unlike places are: their median then errs by a fifth of its spread."""
WINDOW = 2
"""Columns to either side of the expected rotation that are looked at: 8 degrees of 90 columns, an odometry's error."""
OPPOSITE = 15
"""Columns between two rotations that are told apart: 60 degrees of 90 columns."""


@dataclass(frozen=True, slots=True, eq=False)
class Usual:
    """How unlike places of the map are to a view: the median difference, and a sample of them over it (m,)."""

    difference: float
    others: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """What n looks found: likeness (n,), the difference over the usual one; rotations (n,) [rad], the robot's heading
    minus the snapshot's as in `Alignment`; points (n, 2) [m]: where the snapshot stands, ahead and to the left.
    """

    likeness: FloatArray
    rotations: FloatArray
    points: FloatArray

    def poses(self, places: FloatArray) -> FloatArray:
        """Return the robot's poses (n, 3) that these looks at places (n, 3) tell."""
        heading = wrap_all(places[:, 2] + self.rotations)
        c, s = np.cos(heading), np.sin(heading)
        ahead, left = self.points.T
        return np.column_stack([places[:, 0] - c * ahead + s * left, places[:, 1] - s * ahead - c * left, heading])


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """The current view, and those predicted around it, against some of the first places of the map.

    places (k,) in the order of the map's snapshots; squares (k, C): mean squared differences, the view rolled by so
    many columns, the least of all points around; which (k, C): the point, of points (D, 2) [m].
    """

    places: IntArray
    squares: FloatArray
    which: IntArray
    points: FloatArray
    usual: Usual

    def at(self, places: IntArray, rotations: FloatArray) -> Found:
        """Return what is found of places (n,) near the expected rotations (n,) [rad]."""
        columns = self.squares.shape[1]
        rows = np.searchsorted(self.places, places)
        middle = np.rint(np.mod(rotations, TAU) * columns / TAU).astype(np.int64)
        window = (middle[:, None] + np.arange(-WINDOW, WINDOW + 1)) % columns
        values = self.squares[rows[:, None], window]
        best = values.argmin(axis=1)
        return self._bottom(rows, window[np.arange(len(places)), best])

    def minima(self) -> tuple[IntArray, Found]:
        """Return places (2 k,), and what is found at each one's best rotation and at the best other one."""
        k, columns = self.squares.shape
        rows = np.arange(k)
        first = self.squares.argmin(axis=1)
        apart = np.abs((np.arange(columns)[None] - first[:, None] + columns // 2) % columns - columns // 2)
        second = np.where(apart < OPPOSITE, np.inf, self.squares).argmin(axis=1)
        both = np.concatenate([rows, rows])
        return self.places[both], self._bottom(both, np.concatenate([first, second]))

    def _bottom(self, rows: IntArray, found: IntArray) -> Found:
        columns = self.squares.shape[1]
        below, here, above = (self.squares[rows, (found + step) % columns] for step in (-1, 0, 1))
        offset, low = parabola(below, here, above)
        likeness = np.sqrt(np.maximum(low, 0.0)) / self.usual.difference
        return Found(likeness, wrap_all((found + offset) * (TAU / columns)), self.points[self.which[rows, found]])


def usual(view: Surroundings, recognition: Recognition, first: int) -> Usual:
    """Return how unlike the view is to places of the map, told by a sample of the first ones."""
    sample = np.arange(0, first, max(1, first // SAMPLE))
    lowest = np.sqrt(np.maximum(recognition.index.least(view, sample)[0].min(axis=1), 0.0))
    difference = max(float(np.median(lowest)), 1e-6)
    return Usual(difference, lowest / difference)


def look(
    view: Surroundings, recognition: Recognition, wanted: IntArray, count: int, first: int, usually: Usual
) -> Seen:
    """Compare a view with the wanted places (k,) and with the `count` most like it, all among the first ones."""
    likely, _ = recognition.index.search(view.views[0], count, first) if count else (np.zeros(0, np.int64), None)
    places = np.unique(np.concatenate([likely, wanted[wanted < first]]))
    squares, which = recognition.index.least(view, places)
    return Seen(places, squares, which, view.points, usually)
