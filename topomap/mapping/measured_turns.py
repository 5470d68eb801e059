"""Turns between neighbouring snapshots as each instrument measured them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class MeasuredTurn:
    """The turn from node i to node j as each instrument has it [rad], NaN where it has none.

    read, forward: the odometer's raw turn and way [m]; variance: of the former as declared [rad^2]; rolled: how far the
    wheels went, turning included [m]; scanned: by ranges, with scan_sigma; aligned: by the aligner; matched: by the
    epipolar compass.
    """

    i: int
    j: int
    read: float
    forward: float
    variance: float
    rolled: float
    scanned: float = math.nan
    scan_sigma: float = math.nan
    aligned: float = math.nan
    matched: float = math.nan


class Columns(NamedTuple):
    """The fields of many measured turns, (n,) each."""

    read: FloatArray
    forward: FloatArray
    variance: FloatArray
    rolled: FloatArray
    scanned: FloatArray
    scan_sigma: FloatArray
    aligned: FloatArray
    matched: FloatArray

    @staticmethod
    def of(turns: Sequence[MeasuredTurn]) -> Columns:
        """Return the turns' fields."""
        rows = [[getattr(turn, name) for name in Columns._fields] for turn in turns]
        return Columns(*np.array(rows, float).reshape(-1, len(Columns._fields)).T)
