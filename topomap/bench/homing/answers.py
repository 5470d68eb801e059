"""What the methods answered: on each ground, and by one method on all grounds of an environment."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.bench.homing.field import HomeField, Survey, Turns, asked, grid_walks
from topomap.bench.homing.walk import Walk
from topomap.core.arrays import BoolArray, FloatArray
from topomap.evaluation.statistics import angular_errors
from topomap.vision.arena import Point, Recipe, bearings_home


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
