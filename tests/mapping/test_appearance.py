"""Places compared in detail: the one of least cost wins, and others tell what that is worth."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np
import pytest

from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, PlaceMatch
from topomap.mapping.closures.appearance import Appearance, Look, Outcome


class Costs:
    """An aligner that knows each node's cost and notes which were asked for."""

    def __init__(self, costs: dict[int, float]) -> None:
        self.costs, self.asked = costs, list[int]()

    def align(self, current: Panorama, goal: Panorama, guess: float | None = None) -> Alignment:
        node = int(cast(float, goal))
        self.asked.append(node)
        return Alignment(rotation=0.0, residual=self.costs[node])


def compare(costs: dict[int, float], places: list[int], rivals: list[int]) -> tuple[Outcome, list[int]]:
    """Nodes stand 1 m apart in the order of their numbers; an image is its node's number."""
    aligner = Costs(costs)
    matches = [[PlaceMatch(node, 0.3, 0.0) for node in some] for some in (places, rivals)]
    view = cast(Panorama, np.float64(0))
    found = Appearance(aligner).compare(
        view, *matches, lambda node: cast(Panorama, np.float64(node)), lambda a, b: float(abs(a - b))
    )
    return found, aligner.asked


def test_the_least_cost_wins_and_its_neighbours_are_no_rivals() -> None:
    found, _ = compare({1: 0.3, 2: 0.31, 9: 0.6, 12: 0.8}, [2, 1], [9, 12])
    assert found.winner.match.node == 1
    assert found.ratio == pytest.approx(0.5)
    assert found.elsewhere == pytest.approx(0.7)


def test_a_rival_nearly_as_alike_ends_the_comparison() -> None:
    found, asked = compare({1: 0.3, 9: 0.31, 20: 0.9, 30: 0.9}, [1], [9, 20, 30])
    assert found.ratio == pytest.approx(0.3 / 0.31)
    assert asked == [1, 9]


def test_a_rival_that_wins_is_the_winner() -> None:
    found, asked = compare({1: 0.6, 9: 0.2, 20: 0.7}, [1], [9, 20])
    assert found.winner.match.node == 9
    assert asked == [1, 9, 20]


def test_where_there_is_no_other_place_nothing_is_known_of_others() -> None:
    found, _ = compare({1: 0.3, 2: 0.4}, [1, 2], [])
    assert found.ratio == 0.0
    assert np.isnan(found.elsewhere)


def test_what_is_usual_elsewhere_is_learnt_from_two_other_places() -> None:
    aligner = Costs({2: 0.3, 9: 0.6, 12: 0.8, 20: 0.1})
    winner = Look(PlaceMatch(1, 0.3, 0.0), Alignment(0.0, 0.3))
    rivals = [PlaceMatch(node, 0.3, 0.0) for node in (2, 9, 12, 20)]
    view = cast(Panorama, np.float64(0))
    args = (lambda node: cast(Panorama, np.float64(node)), lambda a, b: float(abs(a - b)))
    assert Appearance(aligner).elsewhere(view, winner, rivals, *args) == pytest.approx(0.7)
    assert aligner.asked == [9, 12]
    assert np.isnan(Appearance(aligner).elsewhere(view, winner, rivals[:1], *args))


def test_what_was_compared_before_is_not_compared_again() -> None:
    aligner = Costs({node: 0.1 * node for node in range(1, 9)})
    appearance, views = Appearance(aligner), {node: cast(Panorama, np.float64(node)) for node in range(1, 9)}
    places = [PlaceMatch(node, 0.3, 0.0) for node in range(8, 0, -1)]
    view, other = cast(Panorama, np.float64(0)), cast(Panorama, np.float64(0))
    apart = (lambda a, b: float(abs(a - b)),)
    plain = Appearance(Costs(aligner.costs)).compare(view, places, [], views.__getitem__, *apart)
    for _ in range(2):
        appearance.look_ahead(view, places, views.__getitem__)
        assert aligner.asked == [8, 7, 6, 5]
    assert appearance.compare(view, places, [], views.__getitem__, *apart) == plain
    assert aligner.asked == [8, 7, 6, 5, 4, 3, 2, 1], "each once"
    views[8] = cast(Panorama, np.float64(8))  # taken for another view since
    turned = [replace(place, rotation=0.5) if place.node == 7 else place for place in places]
    appearance.compare(view, turned, [], views.__getitem__, *apart)
    assert aligner.asked[8:] == [8, 7, 4, 3, 2, 1]
    appearance.compare(other, places, [], views.__getitem__, *apart)
    assert aligner.asked[14:] == [8, 7, 6, 5, 4, 3, 2, 1], "of another view nothing is known"
