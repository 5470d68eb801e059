"""Turns between neighbouring snapshots as each instrument measured them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

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

    def row(self) -> tuple[float, ...]:
        """Return the fields of `Columns`, in their order."""
        return (self.read, self.forward, self.variance, self.rolled,
                self.scanned, self.scan_sigma, self.aligned, self.matched)  # fmt: skip


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
    def of_rows(rows: FloatArray) -> Columns:
        """Return the columns of turns' rows (n, 8)."""
        return Columns(*rows.T)
