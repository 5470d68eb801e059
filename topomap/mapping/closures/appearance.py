"""The likeliest places compared with the view in detail: which is the most alike, and by how much."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, PlaceMatch
from topomap.mapping.closures.sight_tests import MOST_TOGETHER
from topomap.vision.contracts import Aligner, Preparing

RIVAL_DISTANCE = 1.5
"""[m] A node this far from the winner is another place: twice the way in which a true revisit may lie aside ..."""
APART = 2.5
"""... or so many catchments, where that is more: nearer, views are alike because they show the same."""

AHEAD = 4
"""Places compared a step before they are asked for: half of the most that a proposal has."""
FEW = 2
"""Rivals that are compared only to learn what places elsewhere cost: each takes as long as a place within reach."""


@dataclass(frozen=True, slots=True)
class Look:
    """A place that was compared in detail."""

    match: PlaceMatch
    alignment: Alignment


@dataclass(frozen=True, slots=True)
class Outcome:
    """The winner; its cost over the best rival's, 0 where there is none; the median cost of other places, NaN where
    there is none; what was compared of the winner's own place, itself included, the most alike first.
    """

    winner: Look
    ratio: float
    elsewhere: float
    alike: tuple[Look, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class _Ahead:
    """What was compared of a view before it was asked for: the place's view and the look, by node."""

    view: Panorama | None = None
    looks: dict[int, tuple[Panorama, Look]] = field(default_factory=dict)

    def of(self, view: Panorama, place: PlaceMatch, goal: Panorama) -> Look | None:
        """Return the look at a place, None where these weren't the views that were compared."""
        then, look = self.looks.get(place.node, (None, None)) if view is self.view else (None, None)
        return look if then is goal and look is not None and look.match == place else None


class Appearance:
    """Ranks places by alignment cost (min-warping by default)."""

    def __init__(self, aligner: Aligner) -> None:
        self._aligner = aligner
        self._ahead = _Ahead()

    def compare(
        self,
        view: Panorama,
        places: Sequence[PlaceMatch],
        rivals: Sequence[PlaceMatch],
        panorama: Callable[[int], Panorama],
        distance: Callable[[int, int], float],
        catchment: float = 0.0,
    ) -> Outcome:
        """Compare `view` with each place (at least one) and with rivals until one of these spoils the best's chances.

        distance: between two nodes on the map [m]; catchment: way over which views are alike [m], 0 for unknown.
        """
        far = apart(catchment)

        def look(place: PlaceMatch) -> Look:
            goal = panorama(place.node)
            return self._ahead.of(view, place, goal) or self._look(view, place, goal)

        looks = sorted(map(look, places), key=_cost)
        for rival in rivals:
            looks = sorted([*looks, look(rival)], key=_cost)
            if _outcome(looks, distance, far).ratio > MOST_TOGETHER:
                break
        return _outcome(looks, distance, far)

    def look_ahead(self, view: Panorama, places: Sequence[PlaceMatch], panorama: Callable[[int], Panorama]) -> None:
        """Compare with the first places in the step before `compare` will ask for them, which then takes less time."""
        if view is self._ahead.view:
            return
        goals = [(place, panorama(place.node)) for place in places[:AHEAD]]
        self._ahead = _Ahead(view, {p.node: (goal, self._look(view, p, goal)) for p, goal in goals})

    def _look(self, view: Panorama, place: PlaceMatch, goal: Panorama) -> Look:
        return Look(place, self._aligner.align(view, goal, place.rotation))

    def prepare(self, view: Panorama) -> None:
        """Do beforehand what comparisons ask of a place's view, where the aligner can."""
        if isinstance(self._aligner, Preparing):
            self._aligner.prepare(view)

    def elsewhere(
        self,
        view: Panorama,
        winner: Look,
        rivals: Sequence[PlaceMatch],
        panorama: Callable[[int], Panorama],
        distance: Callable[[int, int], float],
        catchment: float = 0.0,
    ) -> float:
        """Return the median cost of `view` at the first two rivals that are other places, NaN for none."""
        far = apart(catchment)
        others = [rival for rival in rivals if distance(rival.node, winner.match.node) > far][:FEW]
        costs = [self._aligner.align(view, panorama(rival.node), rival.rotation).residual for rival in others]
        return float(np.median(costs)) if costs else np.nan


def apart(catchment: float) -> float:
    """Return how far from one another two places are that the views tell apart [m]."""
    return max(RIVAL_DISTANCE, APART * catchment)


def _outcome(looks: Sequence[Look], distance: Callable[[int, int], float], far: float) -> Outcome:
    """Return what comparisons, the most alike first, tell; places farther from one another than `far` [m] are two."""
    winner = looks[0]
    elsewhere = [_cost(k) for k in looks if distance(k.match.node, winner.match.node) > far]
    alike = tuple(k for k in looks if distance(k.match.node, winner.match.node) <= far)
    if not elsewhere:
        return Outcome(winner, 0.0, np.nan, alike)
    return Outcome(winner, _cost(winner) / max(elsewhere[0], 1e-9), float(np.median(elsewhere)), alike)


def _cost(look: Look) -> float:
    return look.alignment.residual
