"""What was seen of the places that claims name: one record, which the tests by sight read."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What the views of n claims told.

    difference (n,): of the images at the best rotation, and limit (n,) above which nothing would have been proposed;
    cost (n,): of the alignment, ratio (n,) to that of the best rival, 0 where none was compared, and usual (n,), that
    of places seen again lately, infinite where too few were; compared (n,): whether odometry allowed the place;
    clear (n,): whether its image alone tells it from all others more clearly than chance does; waits (n,): whether
    others have to agree with it anyway, as odometry leaves several places open.
    """

    difference: FloatArray
    limit: FloatArray
    cost: FloatArray
    ratio: FloatArray
    usual: FloatArray
    compared: BoolArray
    clear: BoolArray
    waits: BoolArray

    @staticmethod
    def of_one(
        difference: float, limit: float, cost: float, ratio: float, usual: float = np.inf, compared: bool = True,
        clear: bool = False, waits: bool = False,
    ) -> Seen:  # fmt: skip
        """Return what was seen of a single claim's place."""
        numbers = np.array([[difference], [limit], [cost], [ratio], [usual]])
        return Seen(*numbers, *np.array([[compared], [clear], [waits]]))

    def among(self, part: IntArray) -> Seen:
        """Return what was seen of some (n,) of the claims' places."""
        return Seen(*(getattr(self, field.name)[part] for field in fields(self)))
