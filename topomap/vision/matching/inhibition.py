"""H28, the inhibition of multiple matches: which of the warped pairs count (5.1.3.8)."""

from __future__ import annotations

from typing import Literal

import numpy as np

from topomap.core.arrays import FloatArray, IntArray

Inhibition = Literal["mean", "none", "target", "reverse", "both"]


def inhibited(home: IntArray, current: IntArray, unlike: FloatArray, inhibition: Inhibition) -> IntArray:
    """Return which of the pairs (M,) stay: "target" one start per home index, the most alike; "reverse" one home per
    current index; "both" those that pass both; "none" (and "mean") all.
    """
    everything = np.arange(len(home))
    if inhibition in ("none", "mean"):
        return everything
    chosen: set[int] | None = None
    for targets in [home] * (inhibition != "reverse") + [current] * (inhibition != "target"):
        least = set(_least(targets, unlike).tolist())
        chosen = least if chosen is None else chosen & least
    return np.array(sorted(chosen or set(everything.tolist())), np.int64)


def _least(targets: IntArray, unlike: FloatArray) -> IntArray:
    order = np.lexsort((unlike, targets))
    first = np.r_[True, np.diff(targets[order]) != 0]
    return np.asarray(order[first], np.int64)
