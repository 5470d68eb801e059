"""The belief's own arithmetic: being lost is not being at the likeliest place, and the figures are as before."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from kept import Figures, as_before
from maps import RIG, square

from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import Motion
from topomap.mapping.mapper import Mapper
from topomap.navigation.localiser.belief import Belief
from topomap.navigation.localiser.fix import MEASURED_FLOOR, fix
from topomap.navigation.localiser.likeness import log_ratio
from topomap.navigation.localiser.localiser import SURE, Localiser
from topomap.navigation.localiser.mixture import Mixture
from topomap.navigation.localiser.set_down import set_down
from topomap.navigation.localiser.views import Seen, Usual
from topomap.navigation.localiser.weighing import by_first_view, by_stretch, with_places
from topomap.vision.matching.scan_match import ScanMatch


def some(count: int = 6, seed: int = 0) -> Mixture:
    """Hypotheses about a square of 4 m, each with a few looks."""
    rng = np.random.default_rng(seed)
    mixture = Mixture.at(np.array([1.0, 0.5, 0.3]), np.diag([0.04, 0.02, 0.01]), 0.3)
    poses = np.column_stack([rng.uniform(-2.0, 2.0, (count, 2)), rng.uniform(-3.0, 3.0, count)])
    mixture = mixture.joined_by(poses, np.diag([0.1, 0.2, 0.05]), np.log(rng.uniform(0.01, 0.2, count))).normalised()
    for _ in range(4):
        mixture = mixture.looked(np.arange(0, count, 2), rng.uniform(0.02, 0.5, (count + 1) // 2))
    return mixture


def seen(seed: int = 1) -> Seen:
    rng = np.random.default_rng(seed)
    columns = np.arange(90) * math.tau / 90
    squares = 1.0 - 0.6 * np.cos(columns[None] - rng.uniform(0.0, 6.0, (5, 1))) * rng.uniform(0.3, 1.4, (5, 1))
    return Seen(
        np.array([0, 2, 3, 5, 8]), squares, rng.integers(0, 3, squares.shape),
        np.array([[0.0, 0.0], [0.16, 0.0], [0.0, -0.16]]), Usual(0.9, rng.uniform(0.3, 1.2, 30)),
    )  # fmt: skip


def figures(mixture: Mixture) -> Figures:
    return {
        "poses": mixture.poses,
        "spread": mixture.covariances,
        "weights": np.append(mixture.weights, mixture.elsewhere),
        "seen": np.minimum(mixture.seen, 99.0),
    }


def stages() -> dict[str, Mixture]:
    start, rng = some(), np.random.default_rng(2)
    which = np.array([1, 3])
    poses = np.column_stack([np.arange(9.0) / 2, np.zeros(9), 0.1 * np.arange(9)])
    return {
        "moved": start.moved(Motion(0.3, 0.05, 0.2, np.zeros((3, 3)), 0.25), np.diag([0.01, 0.02, 0.005])),
        "carried": start.carried(np.arange(7), poses, poses[::-1] + 0.3),
        "measured": start.measured(which, start.poses[which] + 0.2, np.tile(np.diag([0.1, 0.3, 0.1]), (2, 1, 1))),
        "weighed": start.weighed(rng.normal(size=7), 0.02),
        "shaken": start.shaken(0.7),
        "pruned": start.joined_by(
            start.poses + np.array([0.2, 0.3, 0.1]), 0.01 * np.eye(3), start.weights - 1.0
        ).pruned(),
        "by stretch": by_stretch(start, seen()),
        "by first view": by_first_view(start, seen()),
        "with places": with_places(start, seen(), poses),
        "set down": set_down(start, seen(), poses),
    }


@pytest.mark.parametrize("name", stages())
def test_each_step_is_as_before(name: str) -> None:
    as_before("mixture", {f"{name}: {said}": one for said, one in figures(stages()[name]).items()}, part=True)


def driven_between_two(behind: float, stretches: int) -> float:
    """The share of the likelier of two places, the other one so many units less like each stretch."""
    start = Mixture.at(np.zeros(3), 0.01 * np.eye(3), 1e-3)
    mixture = start.joined_by(np.array([[9.0, 0.0, 0.0]]), 0.01 * np.eye(3), start.weights).normalised()
    for _ in range(stretches):
        for _ in range(6):
            mixture = mixture.looked(np.array([0, 1]), 0.04 + np.array([0.0, behind * (0.015 + 0.1 * 0.04)]))
        mixture = by_stretch(mixture, seen())
    return math.exp(mixture.weights[0]) / math.exp(float(np.logaddexp.reduce(mixture.weights)))


def test_what_differs_a_little_and_lastingly_doesnt_make_one_of_two_alike_sure() -> None:
    assert driven_between_two(0.5, 20) < 0.9
    assert driven_between_two(0.5, 1) > 0.55


def test_what_differs_clearly_makes_one_of_two_sure_within_three_stretches() -> None:
    assert driven_between_two(3.0, 3) > 0.99


def test_one_stretch_that_is_off_as_far_as_one_in_forty_makes_nobody_sure() -> None:
    assert 1.0 - driven_between_two(1.5, 1) > 4 * SURE


def test_a_place_where_two_alike_differ_counts_for_good() -> None:
    start = Mixture.at(np.zeros(3), 0.01 * np.eye(3), 1e-3)
    mixture = start.joined_by(np.array([[9.0, 0.0, 0.0]]), 0.01 * np.eye(3), start.weights).normalised()
    for behind in (0.3, 0.3, 1.7, 0.3, 0.3, 0.3):
        for _ in range(6):
            mixture = mixture.looked(np.array([0, 1]), 0.04 + np.array([0.0, behind * (0.015 + 0.1 * 0.04)]))
        mixture = by_stretch(mixture, seen())
    assert mixture.weights[0] - mixture.weights[1] > 2.8


def test_what_is_less_alike_than_any_place_of_the_map_speaks_against_it() -> None:
    others = np.random.default_rng(5).normal(1.0, 0.1, 40)
    ratios = log_ratio(np.array([0.2, 1.0, 1.5, 2.1]), others)
    assert ratios[0] > 2.0
    assert (ratios[1:] < -1.0).all()


def test_a_view_that_is_hidden_in_part_speaks_for_the_place_and_not_against_it() -> None:
    start = Mixture.at(np.array([1.0, 0.5, 0.3]), np.diag([0.04, 0.02, 0.01]), 0.01)
    for _ in range(3):
        start = start.looked(np.arange(1), np.array([0.8]))  # .9 of what is usual: as unlike as most of the map
    lost, kept = by_stretch(start, seen()), by_stretch(start, seen(), hidden=True)
    assert math.exp(lost.elsewhere) > 0.05
    assert 0.001 < math.exp(kept.elsewhere) < 0.01  # it may have been carried off unnoticed
    alike = start.looked(np.arange(1), np.array([0.01]))
    assert by_stretch(alike, seen(), hidden=True).elsewhere == by_stretch(alike, seen()).elsewhere


def test_a_belief_is_proven_from_a_known_place_on_until_the_robot_may_be_anywhere() -> None:
    known = Mixture.at(np.array([1.0, 0.5, 0.3]), np.diag([0.04, 0.02, 0.01]), 1e-3)
    belief = Belief(known, square())
    assert belief.proven
    belief.shake(0.5)
    assert not belief.proven
    assert not Belief(Mixture.unknown(), square()).proven
    assert not Belief(known.shaken(0.8), square()).proven


def test_what_views_tell_is_as_before() -> None:
    view, rng = seen(), np.random.default_rng(3)
    where, least = view.minima()
    near = view.at(np.repeat([2, 8, 0], 4), np.tile([0.3, -2.0, 5.0, 1.5], 3))
    likeness = np.linspace(0.0, 1.4, 15)
    as_before(
        "views",
        {
            "minima": where, "likeness": least.likeness, "rotations": least.rotations,
            "poses": least.poses(rng.normal(size=(10, 3))), "near": near.likeness, "near rotations": near.rotations,
            "near points": near.points, "ratio": log_ratio(likeness, view.usual.others),
        },
    )  # fmt: skip


@pytest.mark.parametrize(
    ("off", "found"), [((0.7, 0.0, 0.2), True), ((0.9, 0.0, 0.0), False), ((0.0, 0.0, 0.3), False)]
)
def test_a_fix_far_from_where_it_was_looked_for_is_another_surface(
    off: tuple[float, float, float], found: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected, view = Pose2(0.3, 0.2, 3.1), Panorama(np.zeros((10, 72, 3), np.uint8), np.ones(72, np.float32), RIG)
    moved = expected.array() + np.array(off)
    moved[2] = math.remainder(moved[2], math.tau)
    match = ScanMatch(moved, 0.01 * np.eye(3), 0.9)
    monkeypatch.setattr("topomap.navigation.localiser.fix.match_scans", lambda *_: match)
    told = fix(view, view, expected)
    assert (told is not None) == found
    if told is not None:
        assert told.relative is match.relative
        assert told.covariance == pytest.approx(0.01 * np.eye(3) + MEASURED_FLOOR)


def test_places_up_to_a_metre_off_are_near() -> None:
    belief = Belief(Mixture.at(np.array([0.0, 0.0, 0.0]), np.eye(3), 0.1), square())
    places = np.array([[3.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.01, 0.0], [0.0, 0.5, 0.0], [5.0, 5.0, 0.0]])
    nearby = belief._nearby(places)
    assert {int(p): bool(n) for p, n in zip(nearby.places[0], nearby.near[0], strict=True)} == {
        1: True,
        2: False,
        3: True,
    }
    few = belief._nearby(places[:2])
    assert dict(zip(few.places[0].tolist(), few.near[0].tolist(), strict=True)) == {0: False, 1: True}


def test_the_lost_are_those_who_are_not_at_the_likeliest_place() -> None:
    topo = square()
    here = np.array([0.0, 0.0, 0.0])
    assert Belief(Mixture.at(here, np.eye(3), 0.1), topo).lost == pytest.approx(0.1)
    assert Belief(Mixture.unknown(), topo).lost == 1.0
    two = Mixture.at(here, np.eye(3), 0.1).joined_by(here[None] + 5.0, np.eye(3), np.log([0.9])).normalised()
    assert Belief(two, topo).lost == pytest.approx(1.0 - 0.9 / 1.9)


@pytest.mark.parametrize(("at", "doubt"), [(0.0, 0.2), (0.4, 0.2), (3.0, 1.0)])
def test_a_track_is_doubted_by_what_the_belief_has_elsewhere(at: float, doubt: float) -> None:
    belief = Belief(Mixture.at(np.array([at, 0.0, 0.0]), np.eye(3), 0.2), square())
    mapper = cast(Mapper, SimpleNamespace(track=SimpleNamespace(pose=Pose2()), catchment=0.0))
    assert Localiser()._doubt(belief, mapper) == pytest.approx(doubt)
