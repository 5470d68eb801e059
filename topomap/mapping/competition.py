"""The finished map against what it must not be worse than: itself without doubtful evidence, and dead reckoning.

Each stretch of closures is predicted by maps that were made without it. A rival takes the map's place where it
predicts them better by more than chance: then the evidence it does without was wrong, or the closures were.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.mapping.optimizer import Closures, OptimizerSettings, Problem, TurnEdge, solve
from topomap.mapping.optimizer.residuals import closure_chi2

FOLDS = 2
"""Maps made without a part of the closures each; more tell little more, and cost a solve each."""
STRETCHES = 12
"""Stretches that closures are held out by, at most: neighbours on the way tell the same."""
FEWEST = 4
"""Stretches below which nothing can be told."""
SURE = 2.0
"""Standard errors by which a rival has to be better: the map is what all evidence says."""

CLEARLY = 0.5
"""Share of the odometer's error below which turns by sight correct it, with nothing else to tell whether they do."""

MARGIN = 0.3
"""Squared sigmas by which a rival has to be better as well: of an exact odometer both predict alike, and nothing is
gained by taking closures back."""

FULL, BLIND, DEAD = "all evidence", "without turns by sight", "dead reckoning"


@dataclass(frozen=True, slots=True)
class Contest:
    """Which map is kept, and the mean error of closures it didn't know, by map [squared sigmas, cut off]."""

    kept: str
    errors: dict[str, float]

    @property
    def reason(self) -> str:
        """Say it in a line."""
        if self.kept == DEAD and not self.errors:
            return f"{DEAD}: no place was seen again, and turns by sight err as much as the odometer's"
        if not self.errors:
            return f"{self.kept}: too few closures to compare it with anything"
        said = ", ".join(f"{name} {error:.2f}" for name, error in self.errors.items())
        return f"{self.kept} (error of closures held out: {said})"


class Rival(NamedTuple):
    """A map of the same drive made otherwise: name, and what makes its poses (N, 3) from the closures it may know."""

    name: str
    poses: Callable[[Closures], FloatArray]


def compete(
    problem: Problem, dead_reckoning: FloatArray | None, scanned: Sequence[TurnEdge], settings: OptimizerSettings
) -> Contest:
    """Compare a finished map's problem with its rivals.

    dead_reckoning (N, 3): the nodes by odometry as read, None for a map that stood before this drive, which no odometry
    gives up; scanned: those of the turns that ranges measured.
    """
    if dead_reckoning is not None and not len(problem.closures) and not len(scanned) and not _turns_tell(problem):
        return Contest(DEAD, {})
    stretch = _stretches(problem.closures)
    if stretch.max(initial=-1) + 1 < FEWEST:
        return Contest(FULL, {})
    rivals = [Rival(FULL, lambda known: _solved(replace(problem, closures=known), settings))]
    if len(scanned) < len(problem.turns):
        blind = replace(problem, turns=tuple(scanned))
        rivals.append(Rival(BLIND, lambda known: _solved(replace(blind, closures=known), settings)))
    if dead_reckoning is not None:
        rivals.append(Rival(DEAD, lambda known: dead_reckoning))
    errors = {rival.name: _errors(problem.closures, stretch, rival, settings.cutoff) for rival in rivals}
    best = FULL
    for name in list(errors)[1:]:
        better = errors[best] - errors[name]
        if float(better.mean()) > max(MARGIN, SURE * float(better.std(ddof=1)) / math.sqrt(len(better))):
            best = name
    return Contest(best, {name: float(error.mean()) for name, error in errors.items()})


def _turns_tell(problem: Problem) -> bool:
    """Return whether turns by sight err clearly less than the odometer's over the same way."""
    if not problem.turns:
        return False
    variance = problem.odometry.increments.integrate(problem.calibration).covariances(problem.calibration)[:, 2, 2]
    summed = np.concatenate([[0.0], np.cumsum(variance)])
    place = {int(node): k for k, node in enumerate([*problem.odometry.i.tolist(), int(problem.odometry.j[-1])])}
    odometer = [summed[place[turn.j]] - summed[place[turn.i]] for turn in problem.turns]
    return bool(np.median([turn.sigma for turn in problem.turns]) < CLEARLY * math.sqrt(float(np.median(odometer))))


def _stretches(closures: Closures) -> IntArray:
    """Return (M,) the number of the stretch of the drive that each closure ends in."""
    order = np.argsort(closures.j, kind="stable")
    stretch = np.empty(len(order), np.int64)
    count = max(min(STRETCHES, len(order)), 1)
    stretch[order] = np.arange(len(order)) * count // max(len(order), 1)
    return stretch


def _errors(closures: Closures, stretch: IntArray, rival: Rival, cutoff: float) -> FloatArray:
    """Return the mean error (S,) of the closures of each stretch, seen from a map that doesn't know them."""
    held_out = np.empty(len(closures))
    for fold in range(FOLDS):
        out = stretch % FOLDS == fold
        unknown = closures[out]
        chi2 = closure_chi2(rival.poses(closures[~out]), unknown, np.zeros((len(unknown), 3, 3)))
        held_out[out] = np.minimum(chi2, cutoff**2)
    return np.array([held_out[stretch == k].mean() for k in range(int(stretch.max()) + 1)])


def _solved(problem: Problem, settings: OptimizerSettings) -> FloatArray:
    return solve(problem, settings).poses
