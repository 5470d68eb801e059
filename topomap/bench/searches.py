"""Searches of robots that were set down anywhere: how many found themselves, and how far `lost` can be believed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.evaluation.calibration import Reliability
from topomap.evaluation.statistics import Interval, share_interval

SOON = 10.0
"""[m] Travel within which a kidnapped robot shall know its node."""
BINS = (0.0, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0)


@dataclass(frozen=True, eq=False)
class Search:
    """One start: found: the robot said it knows, having noticed or driven 10 m; right: it was where it said; way [m]:
    driven until then.

    lost (K,), wrong (K,): what it said at each step, and whether its likeliest pose was wrong.
    """

    found: bool
    right: bool
    way: float
    lost: FloatArray
    wrong: BoolArray


@dataclass(frozen=True)
class Bin:
    """Steps with `lost` between two bounds: how many, of how many starts, its mean, and the share that was wrong."""

    low: float
    high: float
    steps: int
    starts: int
    said: float
    wrong: float


@dataclass(frozen=True)
class Tally:
    """All starts of a world and seed: share found rightly within 10 m and at all, sure and wrong, median way [m].

    error: the mean difference of `lost` and the share that was wrong, over bins of `lost` weighted by their steps.
    """

    starts: int
    soon: Interval
    found: Interval
    sure_and_wrong: int
    median_way: float
    error: float
    bins: tuple[Bin, ...]


def tally(searches: Sequence[Search]) -> Tally:
    """Return the figures of some searches."""
    count = len(searches)
    right = [one for one in searches if one.right]
    bins = _bins(searches)
    return Tally(
        count,
        share_interval(sum(one.way <= SOON for one in right), count),
        share_interval(len(right), count),
        sum(one.found and not one.right for one in searches),
        float(np.median([one.way if one.right else np.inf for one in searches])),
        sum(one.steps * abs(one.said - one.wrong) for one in bins) / max(sum(one.steps for one in bins), 1),
        bins,
    )


def _bins(searches: Sequence[Search]) -> tuple[Bin, ...]:
    lost = np.concatenate([one.lost for one in searches])
    wrong = np.concatenate([one.wrong for one in searches])
    start = np.repeat(np.arange(len(searches)), [len(one.lost) for one in searches])
    found = []
    for low, high in pairwise(BINS):
        inside = (lost >= low) & ((lost < high) | (high == BINS[-1]))
        if inside.any():
            starts, said = len(np.unique(start[inside])), float(lost[inside].mean())
            found.append(Bin(low, high, int(inside.sum()), starts, said, float(wrong[inside].mean())))
    return tuple(found)


def curve(figures: Tally) -> Reliability:
    """Return what `lost` said against how often it was so; count: the starts behind it, whose steps hang together."""
    said, wrong, starts = np.array([(one.said, one.wrong, one.starts) for one in figures.bins]).T
    return Reliability(said, wrong, starts, figures.error)


HEADINGS = ("starts", "in 10 m [%]", "at all [%]", "sure, wrong", "median [m]", "error", "lost: wrong")


def row(figures: Tally) -> tuple[str, ...]:
    """Return the cells of a table's row, under HEADINGS."""
    soon = f"{100 * figures.soon.value:.0f} ({100 * figures.soon.low:.0f}-{100 * figures.soon.high:.0f})"
    bins = ", ".join(f"{one.said:.2f}: {one.wrong:.2f}" for one in figures.bins)
    found, median = f"{100 * figures.found.value:.0f}", f"{figures.median_way:.1f}"
    return str(figures.starts), soon, found, str(figures.sure_and_wrong), median, f"{figures.error:.2f}", bins


KEYS = 3  # the first cells tell rows apart
KEPT = ("world", "seed", "settings", "starts", "within 10 m", "found", "sure and wrong", "median [m]", "lost errs by",
        "lost: wrong (steps)")  # fmt: skip


def kept_row(world: str, seed: int, settings: Sequence[str], figures: Tally) -> tuple[str, ...]:
    """Return the cells of a lesson's row, under KEPT."""
    bins = ", ".join(f"{one.said:.3f}: {one.wrong:.3f} ({one.steps})" for one in figures.bins)
    counts = (round(share.value * figures.starts) for share in (figures.soon, figures.found))
    return (world, str(seed), " ".join(settings), str(figures.starts), *map(str, counts), str(figures.sure_and_wrong),
            f"{figures.median_way:.2f}", f"{figures.error:.3f}", bins)  # fmt: skip
