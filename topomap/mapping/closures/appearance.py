"""The visual test of a proposal: the likeliest places are compared in detail, and one must clearly win."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from pydantic import BaseModel, Field

from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, PlaceMatch
from topomap.vision.contracts import Aligner


class AppearanceSettings(BaseModel, frozen=True, extra="forbid"):
    """When a place is believed by what is seen."""

    cost: float = Field(0.8, gt=0, description="alignment cost above which no place is believed")
    ratio: float = Field(0.9, gt=0, le=1, description="a place must cost less than this share of its best rival")
    rival_distance: float = Field(1.5, gt=0, description="a node this far from the winner is another place [m]")


@dataclass(frozen=True, slots=True)
class Look:
    """A place that was compared in detail."""

    match: PlaceMatch
    alignment: Alignment


@dataclass(frozen=True, slots=True)
class Outcome:
    """The winner, its cost over the best rival's (0 where there is none), and why it fails ("" where it doesn't)."""

    winner: Look
    ratio: float
    objection: str


class AppearanceTest:
    """Ranks places by alignment cost (min-warping by default)."""

    def __init__(self, settings: AppearanceSettings, aligner: Aligner) -> None:
        self._s = settings
        self._aligner = aligner

    def judge(
        self,
        view: Panorama,
        places: Sequence[PlaceMatch],
        rivals: Sequence[PlaceMatch],
        panorama: Callable[[int], Panorama],
        distance: Callable[[int, int], float],
    ) -> Outcome:
        """Compare `view` with each place (at least one) and with rivals until one of these spoils the best's chances.

        distance: between two nodes on the map [m].
        """

        def look(place: PlaceMatch) -> Look:
            return Look(place, self._aligner.align(view, panorama(place.node), place.rotation))

        looks = sorted(map(look, places), key=_cost)
        for rival in rivals:
            looks = sorted([*looks, look(rival)], key=_cost)
            if self._ratio(looks, distance) > self._s.ratio:
                break
        ratio = self._ratio(looks, distance)
        return Outcome(looks[0], ratio, self._objection(_cost(looks[0]), ratio))

    def _ratio(self, looks: Sequence[Look], distance: Callable[[int, int], float]) -> float:
        """Return the cost of the first, the winner, over that of the best one elsewhere; 0 where there is none."""
        winner = looks[0]
        elsewhere = (k for k in looks if distance(k.match.node, winner.match.node) > self._s.rival_distance)
        best = next(elsewhere, None)
        return 0.0 if best is None else _cost(winner) / max(_cost(best), 1e-9)

    def _objection(self, cost: float, ratio: float) -> str:
        if cost > self._s.cost:
            return f"no place is alike enough (cost {cost:.2f} > {self._s.cost:g})"
        if ratio > self._s.ratio:
            return f"another place is nearly as alike (ratio {ratio:.2f} > {self._s.ratio:g})"
        return ""


def _cost(look: Look) -> float:
    return look.alignment.residual
