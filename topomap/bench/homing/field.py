"""Vector fields: the home vector of one method from every position of a grid, and walks that follow it."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from topomap.bench.homing.contestant import Bound, Contestant, Looks, view_at
from topomap.bench.homing.walk import Eyes, Walk, WalkSettings, catchment, policy_walk, walk
from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.errors import DataError
from topomap.core.geometry import TAU, Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Plan
from topomap.vision.arena import Arena, Point, Recipe, spread
from topomap.vision.contracts import Aligner


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """What an arena is like: positions (N, 2) [m], spacing [m], its own home [m], plan; ranges: it measures them."""

    name: str
    positions: FloatArray
    spacing: float
    home: Point
    plan: Plan
    ranges: bool
    continuous: bool


@dataclass(frozen=True, slots=True, eq=False)
class Turns:
    """The compass at every position: true headings (N,) of the views, rotations found (N,) [rad], milliseconds (N,).

    Where nobody asked it the heading is the rotation, and milliseconds are NaN.
    """

    headings: FloatArray
    rotations: FloatArray
    ms: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class HomeField:
    """What one method answers: directions (N,) of home in the world [rad] (NaN: no answer), milliseconds (N,) a pair
    (NaN: not asked), walks in the continuous world; unfit: why the method can't be used here, else None.
    """

    directions: FloatArray
    ms: FloatArray
    walks: tuple[Walk, ...] = ()
    unfit: str | None = None


@dataclass(frozen=True, slots=True)
class SurveyTask:
    """Look at an arena."""

    recipe: Recipe

    @property
    def key(self) -> str:
        """All that decides the result."""
        return f"survey {_place(self.recipe)}"

    def perform(self) -> Survey:
        """Return what the arena is like."""
        arena = self.recipe.arena()
        ranges = view_at(arena.source, arena.home).ranges is not None
        return Survey(arena.name, arena.positions, arena.spacing, arena.home, arena.plan, ranges, arena.continuous)


@dataclass(frozen=True, slots=True)
class TurnsTask:
    """Ask an aligner at every position of a grid, with views turned at random; None: the views are aligned."""

    recipe: Recipe
    home: Point
    aligner: Aligner | None
    every: int = 1

    @property
    def key(self) -> str:
        """All that decides the result."""
        return f"turns {_place(self.recipe)} {self.home} {self.aligner!r} {self.every}"

    def perform(self) -> Turns:
        """Return headings and rotations."""
        arena = self.recipe.arena()
        count = len(arena.positions)
        if self.aligner is None:
            return Turns(np.zeros(count), np.zeros(count), np.zeros(count))
        goal = view_at(arena.goal_source, arena.at(arena.index(self.home)))
        headings = random_headings(self.recipe.seed, count, goal.rig.width)
        rotations, ms = headings.copy(), np.full(count, np.nan)
        for i, seen in _views(self.recipe, headings, self.every):
            start = time.perf_counter()
            rotations[i] = self.aligner.align(seen, goal).rotation
            ms[i] = 1e3 * (time.perf_counter() - start)
        return Turns(headings, rotations, ms)


@dataclass(frozen=True, slots=True)
class FieldTask:
    """Ask one method at every position of a grid, then walk home from `starts` of them.

    turns: the compass there, as `TurnsTask` found it; aligner: the same compass, for the walks; every: see `asked`.
    """

    recipe: Recipe
    home: Point
    contestant: Contestant
    aligner: Aligner | None
    starts: int = 0
    walking: WalkSettings = field(default_factory=WalkSettings)
    turns: Turns | None = field(default=None, compare=False)
    every: int = 1

    @property
    def key(self) -> str:
        """All that decides the result."""
        walking = f"{self.starts} {self.walking!r} {self.every}"
        return f"field {_place(self.recipe)} {self.home} {self.contestant.key} {self.aligner!r} {walking}"

    def perform(self) -> HomeField:
        """Return the method's answers; a method that lacks what it needs is unfit, not an error."""
        arena = self.recipe.arena()
        goal = view_at(arena.goal_source, arena.at(arena.index(self.home)))
        count = len(arena.positions)
        try:
            bound = self.contestant.bind(goal, self._around(arena))
        except DataError as error:
            return HomeField(np.full(count, np.nan), np.full(count, np.nan), unfit=str(error))
        turns = self.turns or Turns(np.zeros(count), np.zeros(count), np.zeros(count))
        if self.contestant.policy is not None:
            nothing = np.full(count, np.nan)
            return HomeField(nothing, nothing, self._walks(arena, goal, bound))
        directions, ms = _ask(bound, self.recipe, turns, self.every)
        return HomeField(directions, ms, self._walks(arena, goal, bound))

    def _walks(self, arena: Arena, goal: Panorama, bound: Bound) -> tuple[Walk, ...]:
        if not arena.continuous or self.starts == 0:
            return ()
        home = arena.at(arena.index(self.home))
        starts = spread(arena.positions, home, self.starts)
        turned = self.aligner is not None
        headings = random_headings(self.recipe.seed, len(starts), goal.rig.width) if turned else np.zeros(len(starts))

        eyes = Eyes(arena.source, goal, self.aligner if bound.aligned else None)
        poses = [Pose2(*arena.at(start), float(psi)) for start, psi in zip(starts, headings, strict=True)]
        if self.contestant.policy is not None:
            return tuple(policy_walk(self.contestant.policy, eyes, pose, home, self.walking) for pose in poses)

        def steer(pose: Pose2) -> tuple[float, Panorama]:
            seen, rotation = eyes.look(pose)
            return bound.direction(seen, pose.heading, rotation), seen

        return tuple(walk(steer, pose, home, turned, self.walking) for pose in poses)

    def _around(self, arena: Arena) -> Looks:
        x, y = arena.at(arena.index(self.home))

        def look(dx: float, dy: float) -> Panorama:
            if arena.continuous:
                return view_at(arena.goal_source, (x + dx, y + dy))
            whole = max(round(math.hypot(dx, dy) / arena.spacing), 1) * arena.spacing  # the next position there is
            return view_at(arena.goal_source, (x + whole * (dx != 0), y + whole * (dy != 0)))

        return look


def random_headings(seed: int, count: int, width: int) -> FloatArray:
    """Return headings (N,) [rad] of whole columns, so that image grids turn without interpolation."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, 0x7EAD]))
    return np.array([wrap(float(k) * TAU / width) for k in rng.integers(width, size=count)])


def grid_walks(survey: Survey, home: Point, directions: FloatArray, starts: BoolArray) -> list[Walk]:
    """Return the walks through a vector field from the positions that `starts` (N,) marks."""
    walks = catchment(survey.positions, directions, home, survey.spacing)
    return [walk for walk, counts in zip(walks, starts, strict=True) if counts]


def asked(count: int, every: int, seed: int) -> BoolArray:
    """Return which of a grid's positions (N,) are asked: one in `every`, strewn over the grid, others for each seed."""
    order = np.random.default_rng(np.random.SeedSequence([count, 0xA5CED])).permutation(count)
    chosen: BoolArray = np.zeros(count, bool)
    chosen[order[seed % every :: every]] = True
    return chosen


def _ask(bound: Bound, recipe: Recipe, turns: Turns, every: int) -> tuple[FloatArray, FloatArray]:
    count = len(turns.headings)
    directions, ms = np.full(count, np.nan), np.full(count, np.nan)
    for i, seen in _views(recipe, turns.headings, every):
        start = time.perf_counter()
        directions[i] = bound.direction(seen, float(turns.headings[i]), float(turns.rotations[i]))
        ms[i] = 1e3 * (time.perf_counter() - start)
    return directions, ms


def _views(recipe: Recipe, headings: FloatArray, every: int) -> list[tuple[int, Panorama]]:
    """Return the asked positions and their views, without anything that an earlier method derived from them."""
    kept = _rendered(recipe, tuple(headings.tolist()), every)
    return [(i, Panorama(p.image, p.ranges, p.rig)) for i, p in kept]


@lru_cache(maxsize=1)
def _rendered(recipe: Recipe, headings: tuple[float, ...], every: int) -> list[tuple[int, Panorama]]:
    arena = recipe.arena()
    chosen = np.flatnonzero(asked(len(headings), every, recipe.seed)).tolist()
    return [(i, view_at(arena.source, arena.at(i), headings[i])) for i in chosen]


def _place(recipe: Recipe) -> str:
    return f"{recipe.name} {recipe.seed} {recipe.options} {recipe.identity}"
