"""The homing bench: methods over environments, seeds and homes, as one table an environment."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from topomap.bench.homing.answers import Entry, Ground
from topomap.bench.homing.contestant import GIVEN, Contestant, compass
from topomap.bench.homing.field import FieldTask, HomeField, Survey, SurveyTask, TurnsTask
from topomap.bench.homing.rows import Row, rank, rows_of
from topomap.bench.homing.walk import WalkSettings
from topomap.bench.pool import Workers
from topomap.core.errors import DataError
from topomap.core.geometry import wrap_all
from topomap.evaluation.statistics import Interval, mean_interval
from topomap.vision.arena import Point, Recipe


class BenchSettings(BaseModel, frozen=True, extra="forbid"):
    """How the bench measures."""

    compass: str = Field(GIVEN, description="given, or the aligner or row (A1, A6) that finds the rotation")
    starts: int = Field(8, ge=0, le=1000, description="positions from which homing is iterated in the world, a seed")
    walking: WalkSettings = Field(default_factory=WalkSettings, description="how the robot is moved")
    within: float | None = Field(None, gt=0, description="count only places at most this far from home [m]")
    every: int = Field(1, ge=1, description="ask one place in so many, others for each seed; no catchment then")
    draws: int = Field(2000, ge=100, le=100_000, description="resamples of the bootstrap")


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
    rows = rows_of(entries, settings.walking.reach, settings.draws)
    order = sorted(range(len(rows)), key=lambda m: (rank(rows[m]), m))
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


def _compass(grounds: Sequence[Ground]) -> tuple[Interval, float]:
    wrong = [np.abs(np.degrees(wrap_all(g.turns.rotations - g.turns.headings)))[g.away] for g in grounds]
    ms = np.concatenate([g.turns.ms for g in grounds])
    return mean_interval(np.concatenate(wrong)), float(np.nanmedian(ms))
