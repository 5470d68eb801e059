"""The rows of the homing bench's table: a method's figures over all its answers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from topomap.bench.homing.answers import Entry
from topomap.core.arrays import FloatArray
from topomap.evaluation.statistics import Interval, mean_interval, paired_bootstrap, share_interval


@dataclass(frozen=True, slots=True)
class Row:
    """A line of the table. Errors in degrees, shares in [0, 1], times in milliseconds, None where it wasn't measured.

    mean with Student's 95 % interval; sd; median; below 45, 45 to 90, above 90 degrees and catchment with Wilson's;
    answered: share of places with an answer; success and path_ratio of iterated homing in the world (path ratio of the
    walks that reached home); behind: mean minus the best method's, paired bootstrap; unfit: why there are no figures.
    """

    method: str
    places: int
    mean: Interval | None = None
    sd: float | None = None
    median: float | None = None
    below_45: Interval | None = None
    to_90: Interval | None = None
    above_90: Interval | None = None
    answered: float | None = None
    catchment: Interval | None = None
    success: Interval | None = None
    path_ratio: float | None = None
    behind: Interval | None = None
    ms: float | None = None
    unfit: str | None = None


def rows_of(entries: Sequence[Entry], reach: float, draws: int) -> list[Row]:
    """Return a row a method; reach [m]: a walk that near is home; draws: resamples of the bootstrap."""
    errors = {entry.name: entry.errors() for entry in entries if entry.unfit is None and not entry.acting}
    best = min(errors, key=lambda name: float(errors[name].mean()), default=None)
    rows = []
    for entry in entries:
        if best is None or entry.name not in errors:
            success, ratio = _success(entry, reach)
            rows.append(Row(entry.name, 0, success=success, path_ratio=ratio, unfit=entry.unfit))
            continue
        # the same resamples for every method
        behind = paired_bootstrap(errors[entry.name], errors[best], np.random.default_rng(0), draws)
        rows.append(_row(entry, errors[entry.name], behind, reach))
    return rows


def _row(entry: Entry, errors: FloatArray, behind: Interval, reach: float) -> Row:
    count, grid = len(errors), entry.grid_walks()
    success, ratio = _success(entry, reach)
    return Row(
        entry.name,
        count,
        mean_interval(errors),
        float(np.std(errors, ddof=1)) if count > 1 else None,
        float(np.median(errors)),
        share_interval(int(np.sum(errors < 45.0)), count),
        share_interval(int(np.sum((errors >= 45.0) & (errors < 90.0))), count),
        share_interval(int(np.sum(errors >= 90.0)), count),
        entry.answered(),
        share_interval(sum(walk.reached for walk in grid), len(grid)) if grid else None,
        success,
        ratio,
        behind,
        float(np.nanmedian(np.concatenate([f.ms for f in entry.fields]))),
    )


def _success(entry: Entry, reach: float) -> tuple[Interval | None, float | None]:
    walks = entry.walks()
    ratios = [walk.ratio(home, reach) for walk, home in walks if walk.reached]
    share = share_interval(len(ratios), len(walks)) if walks else None
    return share, float(np.mean(ratios)) if ratios else None


def rank(row: Row) -> float:
    """Return what rows are in the order of: the mean error [degrees]."""
    return row.mean.value if row.mean else math.inf
