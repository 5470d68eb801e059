"""Which columns of the view the robot itself hides: they stay as they are while all others turn.

A mirror's supports, an antenna or a lens' rim turn with the robot. Their edges are sharp and always there: a compass
takes them for a world that doesn't turn, and places look like one another by them.
"""

from __future__ import annotations

import math

import cv2
import numpy as np

from topomap.core.arrays import BoolArray, Float32Array, FloatArray
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.recorded import Spans

TURN = math.radians(10.0)
"""[rad] Two views are compared once the robot turned so far between them ..."""
PATIENCE = 20
"""... within so many views: farther apart they are of two places."""
TURNED = 0.7
"""Times as unlike as they are, at the middle column, the two are at most once the turn is taken out: else it wasn't
one, and what is alike hides nothing."""
ROWS = 8
"""Bands, one above the other, that columns are compared in: noise drops out."""
ENOUGH, MEMORY = 12, 64
"""Comparisons before anything is said, 120 degrees at least, and those that count, more or less."""
HIDDEN, BESIDE = 0.15, 0.4
"""Change of a column, of the middle column's, below which it is hidden, and below which those next to such a one are.
Over six worlds, after 10 to 16 comparisons: inside bars of 3 and 12 degrees .03 to .20, all other columns .29 and more
(after 32 .59), in photographs .56 after 16; people beside the robot .04 to .4."""
MOST = 0.5
"""Share of the view that can be hidden: were it more, the middle column would be."""


class SelfOcclusion:
    """Learns from a drive's views what the robot hides of them.

    spans: what is known to be hidden; changed: whether the last view changed that.
    """

    def __init__(self, before: Spans = ()) -> None:
        """before: what was hidden when the camera was last seen, which holds until its own views tell."""
        self.spans = before
        self.changed = False
        self._reference: Panorama | None = None
        self._turn, self._views = 0.0, 0
        self._changes: FloatArray | None = None
        self._compared, self._due = 0, ENOUGH

    def see(self, raw: Panorama, turn: float) -> None:
        """Learn from a view as the camera took it; turn: since the one before, by the odometry [rad]."""
        self.changed = False
        if self._reference is None or raw.rig != self._reference.rig:
            self._refer(raw)
            return
        self._turn += turn if math.isfinite(turn) else 0.0
        self._views += 1
        if abs(self._turn) >= TURN:
            self._compare(self._reference, raw)
            self._refer(raw)
        elif self._views >= PATIENCE:
            self._refer(raw)

    def _refer(self, raw: Panorama) -> None:
        self._reference, self._turn, self._views = raw, 0.0, 0

    def _compare(self, before: Panorama, now: Panorama) -> None:
        a, b = _bands(before), _bands(now)
        changes = np.abs(b - a).mean(axis=0)
        middle = float(np.median(changes))
        columns = round(self._turn * now.rig.width / TAU)
        if float(np.median(np.abs(b - np.roll(a, -columns, axis=1)).mean(axis=0))) >= TURNED * middle:
            return
        share = 1.0 / min(self._compared + 1, MEMORY)
        if self._changes is None or len(self._changes) != len(changes):
            self._changes, self._compared, self._due, share = np.zeros(len(changes)), 0, ENOUGH, 1.0
        self._changes += share * (changes / middle - self._changes)
        self._compared += 1
        if self._compared == self._due:  # each time that twice as much was seen
            self._due += min(self._due, MEMORY)
            self._judge(self._changes)

    def _judge(self, changes: FloatArray) -> None:
        hidden = _grown(changes < HIDDEN, changes < BESIDE)
        if hidden.mean() > MOST:
            return
        spans = _spans(hidden)
        self.changed, self.spans = spans != self.spans, spans


def _bands(panorama: Panorama) -> Float32Array:
    grey = cv2.cvtColor(panorama.image, cv2.COLOR_RGB2GRAY).astype(np.float32)
    rows = min(ROWS, panorama.rig.height)
    return np.asarray(cv2.resize(grey, (panorama.rig.width, rows), interpolation=cv2.INTER_AREA), np.float32)


def _grown(core: BoolArray, beside: BoolArray) -> BoolArray:
    """Return the columns of the core, those beside that join them round the circle, and one more at either side."""
    count = len(core)
    for way in (1, -1):
        for _ in range(count):
            wider = core | (np.roll(core, way) & beside)
            if (wider == core).all():
                break
            core = wider
    return np.asarray(core | np.roll(core, 1) | np.roll(core, -1))


def _spans(hidden: BoolArray) -> Spans:
    """Return the runs of hidden columns round the circle as bearings and extents [rad], to a millionth."""
    count = len(hidden)
    unit = TAU / count
    begins = np.flatnonzero(hidden & ~np.roll(hidden, 1))
    ends = np.flatnonzero(hidden & ~np.roll(hidden, -1))
    spans = []
    for begin in begins.tolist():
        end = next((e for e in ends.tolist() if e >= begin), ends[0] + count)
        spans.append((round((begin - 0.5) * unit % TAU, 6), round((end - begin + 1) * unit, 6)))
    return tuple(spans)
