"""The homing bench: methods over environments, seeds and homes, as one table an environment."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from topomap.bench.homing.contestant import GIVEN, Contestant, compass
from topomap.bench.homing.field import FieldTask, HomeField, Survey, SurveyTask, Turns, TurnsTask, asked, grid_walks
from topomap.bench.homing.walk import Walk, WalkSettings
from topomap.bench.pool import Workers
from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.errors import DataError
from topomap.core.geometry import wrap_all
from topomap.evaluation.statistics import (
    Interval,
    angular_errors,
    mean_interval,
    paired_bootstrap,
    share_interval,
)
from topomap.vision.arena import Point, Recipe, bearings_home


class BenchSettings(BaseModel, frozen=True, extra="forbid"):
    """How the bench measures."""

    compass: str = Field(GIVEN, description="given, or the aligner or row (A1, A6) that finds the rotation")
    starts: int = Field(8, ge=0, le=1000, description="positions from which homing is iterated in the world, a seed")
    walking: WalkSettings = Field(default_factory=WalkSettings, description="how the robot is moved")
    within: float | None = Field(None, gt=0, description="count only places at most this far from home [m]")
    every: int = Field(1, ge=1, description="ask one place in so many, others for each seed; no catchment then")
    draws: int = Field(2000, ge=100, le=100_000, description="resamples of the bootstrap")


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """One seed of one environment with its home: recipe, survey, home [m] and the compass at every position.

    within [m]: only places this near to home count; every: one place in so many was asked.
    """

    recipe: Recipe
    survey: Survey
    home: Point
    turns: Turns
    within: float = math.inf
    every: int = 1

    @property
    def asked(self) -> BoolArray:
        """Which positions (N,) were asked for home: never home itself."""
        true = bearings_home(self.survey.positions, self.home)
        return np.isfinite(true) & asked(len(true), self.every, self.recipe.seed)

    @property
    def away(self) -> BoolArray:
        """Which positions (N,) count: what was asked within the distance that counts."""
        near: BoolArray = np.hypot(*(self.survey.positions - np.asarray(self.home)).T) <= self.within + 1e-9
        return near & self.asked


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """A method's answers on every ground of an environment, in the grounds' order; acting: a policy, walks only."""

    name: str
    grounds: tuple[Ground, ...]
    fields: tuple[HomeField, ...]
    acting: bool = False

    @property
    def unfit(self) -> str | None:
        """Why the method can't be used here, else None."""
        return self.fields[0].unfit

    def errors(self) -> FloatArray:
        """Return the angular errors of all places but home, over all grounds (M,) [degrees]."""
        return np.concatenate([self._errors(g, f) for g, f in zip(self.grounds, self.fields, strict=True)])

    def answered(self) -> float:
        """Return the share of places with an answer at all."""
        given = [np.isfinite(f.directions[g.away]) for g, f in zip(self.grounds, self.fields, strict=True)]
        return float(np.concatenate(given).mean())

    def grid_walks(self) -> list[Walk]:
        """Return the walks through the vector fields, from all places but home; none where not all were asked."""
        if any(g.every > 1 for g in self.grounds):
            return []
        pairs = zip(self.grounds, self.fields, strict=True)
        return [walk for g, f in pairs for walk in grid_walks(g.survey, g.home, f.directions, g.away)]

    def walks(self) -> list[tuple[Walk, Point]]:
        """Return the walks in the continuous world, each with its home."""
        return [(walk, g.home) for g, f in zip(self.grounds, self.fields, strict=True) for walk in f.walks]

    def _errors(self, ground: Ground, answers: HomeField) -> FloatArray:
        true = bearings_home(ground.survey.positions, ground.home)
        return angular_errors(answers.directions[ground.away], true[ground.away])


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


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """The results of one environment: rows by mean error, and what they were made of.

    compass_error: mean absolute error of the compass [degrees] with its interval, None when it was given; compass_ms:
    median milliseconds of it.
    """

    environment: str
    compass: str
    seeds: tuple[int, ...]
    rows: tuple[Row, ...]
    entries: tuple[Entry, ...]
    compass_error: Interval | None
    compass_ms: float | None


def bench(
    recipes: Sequence[Recipe],
    home: Point | None,
    contestants: Sequence[Contestant],
    settings: BenchSettings,
    workers: Workers,
    advance: Callable[[], None],
) -> list[Table]:
    """Return a table for every environment among the recipes (one recipe a seed). Raises DataError.

    `advance` is called `tasks(...)` times.
    """
    aligner = compass(settings.compass)
    surveys = workers.run([SurveyTask(recipe) for recipe in recipes], advance)
    homes = [_home(survey, home) for survey in surveys]
    turns = workers.run(
        [TurnsTask(r, h, aligner, settings.every) for r, h in zip(recipes, homes, strict=True)], advance
    )
    near = settings.within or math.inf
    grounds = [Ground(*row, near, settings.every) for row in zip(recipes, surveys, homes, turns, strict=True)]
    wanted = [
        FieldTask(g.recipe, g.home, contestant, aligner, settings.starts, settings.walking, g.turns, settings.every)
        for g in grounds
        for contestant in contestants
    ]
    fields = workers.run(wanted, advance)
    by_ground = [fields[k : k + len(contestants)] for k in range(0, len(fields), len(contestants))]
    names = dict.fromkeys(recipe.name for recipe in recipes)
    return [_table(name, grounds, by_ground, contestants, settings) for name in names]


def tasks(recipes: int, contestants: int) -> int:
    """Return how often a bench calls `advance`."""
    return recipes * (2 + contestants)


def _home(survey: Survey, home: Point | None) -> Point:
    wanted = home or survey.home
    distance = np.hypot(*(survey.positions - np.asarray(wanted)).T)
    nearest = int(distance.argmin())
    if distance[nearest] > 0.75 * survey.spacing:
        low, high = survey.positions.min(axis=0), survey.positions.max(axis=0)
        raise DataError(
            f"{survey.name} has no free grid position at {wanted[0]:g},{wanted[1]:g};"
            f" its grid reaches from {low[0]:.2f},{low[1]:.2f} to {high[0]:.2f},{high[1]:.2f} m"
        )
    return float(survey.positions[nearest, 0]), float(survey.positions[nearest, 1])


def _table(
    name: str,
    grounds: Sequence[Ground],
    fields: Sequence[Sequence[HomeField]],
    contestants: Sequence[Contestant],
    settings: BenchSettings,
) -> Table:
    own = [k for k, ground in enumerate(grounds) if ground.recipe.name == name]
    kept = tuple(grounds[k] for k in own)
    entries = [
        Entry(c.name, kept, tuple(fields[k][m] for k in own), c.policy is not None) for m, c in enumerate(contestants)
    ]
    rows = _rows(entries, settings)
    order = sorted(range(len(rows)), key=lambda m: (_rank(rows[m]), m))
    error, ms = _compass(kept) if settings.compass != GIVEN else (None, None)
    return Table(
        name,
        settings.compass,
        tuple(ground.recipe.seed for ground in kept),
        tuple(rows[m] for m in order),
        tuple(entries[m] for m in order),
        error,
        ms,
    )


def _rows(entries: Sequence[Entry], settings: BenchSettings) -> list[Row]:
    errors = {entry.name: entry.errors() for entry in entries if entry.unfit is None and not entry.acting}
    best = min(errors, key=lambda name: float(errors[name].mean()), default=None)
    rows = []
    for entry in entries:
        if best is None or entry.name not in errors:
            success, ratio = _success(entry, settings.walking.reach)
            rows.append(Row(entry.name, 0, success=success, path_ratio=ratio, unfit=entry.unfit))
            continue
        # the same resamples for every method
        behind = paired_bootstrap(errors[entry.name], errors[best], np.random.default_rng(0), settings.draws)
        rows.append(_row(entry, errors[entry.name], behind, settings.walking.reach))
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


def _rank(row: Row) -> float:
    return row.mean.value if row.mean else math.inf


def _compass(grounds: Sequence[Ground]) -> tuple[Interval, float]:
    wrong = [np.abs(np.degrees(wrap_all(g.turns.rotations - g.turns.headings)))[g.away] for g in grounds]
    ms = np.concatenate([g.turns.ms for g in grounds])
    return mean_interval(np.concatenate(wrong)), float(np.nanmedian(ms))
