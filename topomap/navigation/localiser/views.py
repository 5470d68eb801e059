"""The map's snapshots as the belief sees them: how unlike each is to the current view, at every rotation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import TAU, wrap_all
from topomap.mapping.places.recognition import Recognition
from topomap.vision.image.compare import Signature, parabola

SAMPLE = 64
"""Places by which it is told how unlike places are: their median then errs by a twentieth of its spread."""
WINDOW = 2
"""Columns to either side of the expected rotation that are looked at: 8 degrees of 90 columns, an odometry's error."""
OPPOSITE = 15
"""Columns between two rotations that are told apart: 60 degrees of 90 columns."""


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """The current view against some of the first places of the map.

    places (k,) in the order of the map's snapshots; squares (k, C): mean squared differences, the view rolled by so
    many columns; usual: the median difference to the map's places; others (m,): a sample of them over the median.
    """

    places: IntArray
    squares: FloatArray
    usual: float
    others: FloatArray

    def at(self, places: IntArray, rotations: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return likeness (n,) to places (n,) near the expected rotations (n,), and the rotations found (n,) [rad].

        A rotation is the robot's heading minus the snapshot's, as in `Alignment`.
        """
        columns = self.squares.shape[1]
        rows = np.searchsorted(self.places, places)
        middle = np.rint(np.mod(rotations, TAU) * columns / TAU).astype(np.int64)
        window = (middle[:, None] + np.arange(-WINDOW, WINDOW + 1)) % columns
        values = self.squares[rows[:, None], window]
        best = values.argmin(axis=1)
        found = window[np.arange(len(places)), best]
        low, rotation = self._bottom(rows, found)
        return np.sqrt(np.maximum(low, 0.0)) / self.usual, rotation

    def minima(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return places (2 k,), likeness and rotations [rad] of each one's best rotation and of the best other one."""
        k, columns = self.squares.shape
        rows = np.arange(k)
        first = self.squares.argmin(axis=1)
        apart = np.abs((np.arange(columns)[None] - first[:, None] + columns // 2) % columns - columns // 2)
        second = np.where(apart < OPPOSITE, np.inf, self.squares).argmin(axis=1)
        both, found = np.concatenate([rows, rows]), np.concatenate([first, second])
        low, rotation = self._bottom(both, found)
        return self.places[both], np.sqrt(np.maximum(low, 0.0)) / self.usual, rotation

    def _bottom(self, rows: IntArray, found: IntArray) -> tuple[FloatArray, FloatArray]:
        columns = self.squares.shape[1]
        below, here, above = (self.squares[rows, (found + step) % columns] for step in (-1, 0, 1))
        offset, low = parabola(below, here, above)
        return low, wrap_all((found + offset) * (TAU / columns))


def look(view: Signature, recognition: Recognition, wanted: IntArray, count: int, first: int) -> Seen:
    """Compare a view with the wanted places (k,) and with the `count` most like it, all among the first ones."""
    sample = np.arange(0, first, max(1, first // SAMPLE))
    likely, _ = recognition.index.search(view, count, first) if count else (np.zeros(0, np.int64), None)
    places = np.unique(np.concatenate([sample, likely, wanted[wanted < first]]))
    squares = recognition.index.curves(view, places)
    lowest = np.sqrt(np.maximum(squares[np.searchsorted(places, sample)].min(axis=1), 0.0))
    usual = max(float(np.median(lowest)), 1e-6)
    return Seen(places, squares, usual, lowest / usual)
