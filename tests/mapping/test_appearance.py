"""The visual test: the place of least cost wins, unless another place is nearly as alike."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest

from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, PlaceMatch
from topomap.mapping.closures.appearance import AppearanceSettings, AppearanceTest, Outcome


class Costs:
    """An aligner that knows each node's cost and notes which were asked for."""

    def __init__(self, costs: dict[int, float]) -> None:
        self.costs, self.asked = costs, list[int]()

    def align(self, current: Panorama, goal: Panorama, guess: float | None = None) -> Alignment:
        node = int(cast(float, goal))
        self.asked.append(node)
        return Alignment(rotation=0.0, residual=self.costs[node])


def judge(costs: dict[int, float], places: list[int], rivals: list[int]) -> tuple[Outcome, list[int]]:
    """Nodes stand 1 m apart in the order of their numbers; an image is its node's number."""
    aligner = Costs(costs)
    appearance = AppearanceTest(AppearanceSettings(cost=0.8, ratio=0.9, rival_distance=1.5), aligner)
    matches = [[PlaceMatch(node, 0.3, 0.0) for node in some] for some in (places, rivals)]
    view = cast(Panorama, np.float64(0))
    found = appearance.judge(
        view, *matches, lambda node: cast(Panorama, np.float64(node)), lambda a, b: float(abs(a - b))
    )
    return found, aligner.asked


def test_the_least_cost_wins_and_its_neighbours_are_no_rivals() -> None:
    found, _ = judge({1: 0.3, 2: 0.31, 9: 0.6}, [2, 1], [9])
    assert found.winner.match.node == 1
    assert found.ratio == pytest.approx(0.5)
    assert found.objection == ""


def test_a_rival_nearly_as_alike_ends_the_comparison() -> None:
    found, asked = judge({1: 0.3, 9: 0.32, 20: 0.9, 30: 0.9}, [1], [9, 20, 30])
    assert "another place is nearly as alike" in found.objection
    assert asked == [1, 9]


def test_a_rival_that_wins_is_the_winner() -> None:
    found, asked = judge({1: 0.6, 9: 0.2, 20: 0.7}, [1], [9, 20])
    assert found.winner.match.node == 9
    assert asked == [1, 9, 20]


def test_nothing_is_believed_that_costs_too_much() -> None:
    found, _ = judge({1: 0.85}, [1], [])
    assert "no place is alike enough" in found.objection
