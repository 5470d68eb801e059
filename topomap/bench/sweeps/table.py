"""Runs side by side: one line a variant over its seeds, from the summaries of the runs."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from topomap.evaluation.statistics import Interval, share_interval

ERRORS = ("rotation_scale", "curvature", "distance_scale")
SIGMAS = 2.0  # a found value counts as right within so many of its own


@dataclass(frozen=True, slots=True)
class SweptRun:
    """One run of a sweep: world, what was varied, seed, and its summary (`topomap.evaluation.summary`)."""

    world: str
    variant: str
    seed: int
    summary: Mapping[str, Any]


Value = Callable[[SweptRun], float | None]


def at(*keys: str) -> Value:
    """Return what reads one number of a summary by its keys."""

    def value(run: SweptRun) -> float | None:
        part: Any = run.summary
        for key in keys:
            part = part[key]
        return None if part is None else float(part)

    return value


def deviation(name: str) -> Value:
    """Return what reads (found - true) / sigma of one of the odometry's errors; None where it is unobserved."""

    def value(run: SweptRun) -> float | None:
        part = run.summary[name]
        known = part["found"] is not None and part["true"] is not None and part["sigma"]
        return (part["found"] - part["true"]) / part["sigma"] if known else None

    return value


def relative_error(name: str) -> Value:
    """Return what reads |found / true - 1| of one of the odometry's scales; None where it is unobserved."""

    def value(run: SweptRun) -> float | None:
        part = run.summary[name]
        return abs(part["found"] / part["true"] - 1.0) if part["found"] is not None and part["true"] else None

    return value


COLUMNS: Mapping[str, Value] = {
    "distance_m": at("distance_m"),
    "steps_per_s": at("steps_per_s"),
    "dead_reckoning_ate_m": at("dead_reckoning_ate_m", "se2"),
    "online_ate_m": at("online_ate_m", "se2"),
    "map_ate_se2_m": at("map_ate_m", "se2"),
    "map_ate_sim2_m": at("map_ate_m", "sim2"),
    "closures_accepted": at("closures", "accepted"),
    "closures_false": at("closures", "false"),
    "closures_possible": at("closures", "possible"),
    "recall": at("closures", "recall"),
    **{f"{name}_sigmas": deviation(name) for name in ERRORS},
    "rotation_scale_off": relative_error("rotation_scale"),
    "distance_scale_off": relative_error("distance_scale"),
    "home_asked": at("home", "asked"),
    "home_claimed": at("home", "claimed"),
    "home_within": at("home", "within_0_3_m"),
    "home_error_m": at("home", "error_m"),
    "path_ratio": at("home", "path_ratio"),
    "collisions": at("home", "collisions"),
}
"""The figures of a run that are compared, by the name they have in sweep.csv."""


@dataclass(frozen=True, slots=True)
class Spread:
    """How often a figure was known, and its mean, standard deviation, least and largest value; NaN for none."""

    count: int
    mean: float
    sd: float
    least: float
    most: float


@dataclass(frozen=True, slots=True)
class Line:
    """A world and variant over its seeds: spreads by column, shares with Wilson's interval.

    within_2_sigmas: of the runs that observed an error of the odometry; home: claimed and within 0.3 m, of those asked.
    """

    world: str
    variant: str
    seeds: tuple[int, ...]
    spreads: Mapping[str, Spread]
    within_2_sigmas: Mapping[str, Interval]
    home: Interval


def spread(values: Sequence[float | None]) -> Spread:
    """Return the spread of the known among some values."""
    known = np.array([v for v in values if v is not None and math.isfinite(v)])
    if not len(known):
        return Spread(0, math.nan, math.nan, math.nan, math.nan)
    sd = float(known.std(ddof=1)) if len(known) > 1 else math.nan
    return Spread(len(known), float(known.mean()), sd, float(known.min()), float(known.max()))


def lines(runs: Sequence[SweptRun]) -> list[Line]:
    """Return one line a world and variant, in the order they first appear."""
    groups: dict[tuple[str, str], list[SweptRun]] = {}
    for run in runs:
        groups.setdefault((run.world, run.variant), []).append(run)
    return [_line(world, variant, own) for (world, variant), own in groups.items()]


def _line(world: str, variant: str, own: list[SweptRun]) -> Line:
    spreads = {name: spread([value(run) for run in own]) for name, value in COLUMNS.items()}
    asked = [run.summary["home"] for run in own if run.summary["home"]["asked"]]
    home = share_interval(sum(bool(h["claimed"] and h["within_0_3_m"]) for h in asked), len(asked))
    return Line(world, variant, tuple(run.seed for run in own), spreads, {e: _right(own, e) for e in ERRORS}, home)


def _right(own: Sequence[SweptRun], name: str) -> Interval:
    """Return the share of runs whose found value lies within two of its sigmas, of those that observed it."""
    found = [z for z in map(deviation(name), own) if z is not None]
    return share_interval(sum(abs(z) <= SIGMAS for z in found), len(found))


def to_csv(runs: Sequence[SweptRun]) -> str:
    """Return a row a run as CSV with a header; what isn't known is empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["world", "variant", "seed", *COLUMNS, "graph_hash"])
    for run in runs:
        values = [value(run) for value in COLUMNS.values()]
        told = ["" if v is None else f"{v:.6g}" for v in values]
        writer.writerow([run.world, run.variant, run.seed, *told, run.summary["graph_hash"]])
    return text.getvalue()


def to_json(runs: Sequence[SweptRun]) -> str:
    """Return the lines as JSON, numbers that aren't known as null."""
    return json.dumps([_plain(line) for line in lines(runs)], indent=1, allow_nan=False) + "\n"


def _plain(line: Line) -> dict[str, object]:
    return {
        "world": line.world,
        "variant": line.variant,
        "seeds": list(line.seeds),
        "spreads": {name: _numbers(one) for name, one in line.spreads.items()},
        "within_2_sigmas": {name: _numbers(one) for name, one in line.within_2_sigmas.items()},
        "home": _numbers(line.home),
    }


def _numbers(record: Spread | Interval) -> dict[str, float | None]:
    names = record.__dataclass_fields__
    return {name: v if math.isfinite(v := getattr(record, name)) else None for name in names}
