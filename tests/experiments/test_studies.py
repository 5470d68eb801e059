from __future__ import annotations

import json
import math

import numpy as np
import pytest

from topomap.bench.homing.bench import Table
from topomap.bench.homing.contestant import Pairwise
from topomap.bench.pool import Store, workers
from topomap.core.geometry import TAU, wrap
from topomap.evaluation.statistics import angular_errors
from topomap.experiments import STUDIES, Lab, converging, masks_score, moved, occlusion, routes, stationary
from topomap.experiments.pillars import Pillar, Room, painted, plain, room_arena, room_recipe, square_grid
from topomap.experiments.study import near_and_far
from topomap.vision.arena import Arena, Recipe
from topomap.vision.homing.dtw import DynamicWarping
from topomap.vision.homing.moment import Moment
from topomap.vision.image.ring import RingSpec

MOMENT = Pairwise("moment", Moment(2.0, "equal"))


def furnished(name: str, seed: int, _options: tuple[str, ...] = ()) -> Arena:
    """A painted room with six pillars around a 5 x 5 grid."""
    rng = np.random.default_rng(seed)
    angles = rng.uniform(0.0, TAU, 6)
    pillars = [Pillar(2.4 * math.cos(a), 2.4 * math.sin(a), 0.25, (30, 40 * k, 200)) for k, a in enumerate(angles)]
    return room_arena(name, Room(pillars, 4.0, painted(rng)), 0.8, 0.4)


def measured(recipe: Recipe, *several: Pairwise) -> Table:
    with workers(1, Store(None)) as hands:
        return Lab(lambda *_: recipe, (0,), hands, lambda: None).measured([recipe], several)


def error(recipe: Recipe, one: Pairwise = MOMENT) -> float:
    mean = measured(recipe, one).rows[0].mean
    assert mean is not None
    return mean.value


def test_a_room_shows_pillars_and_wall_where_they_are() -> None:
    room = Room([Pillar(0.0, 2.0, 0.5, (10, 20, 30))], 3.0, plain((200, 200, 200)))
    seen = room.view(0.0, 0.5, 0.0)
    assert seen.ranges is not None
    assert seen.ranges[180] == pytest.approx(1.0)
    assert tuple(seen.image[50, 180]) == (10, 20, 30)
    assert seen.ranges[540] == pytest.approx(3.5)
    assert seen.ranges[0] == pytest.approx(math.sqrt(9.0 - 0.25))
    turned = room.view(0.0, 0.5, math.pi / 2)
    assert np.array_equal(turned.image, seen.rolled(-180).image)


def test_grid_places_stand_clear_of_pillars_and_wall() -> None:
    room = Room([Pillar(1.0, 0.0, 0.3, (0, 0, 0))], 2.0, plain((200, 200, 200)))
    places = {(round(float(x), 3), round(float(y), 3)) for x, y in square_grid(room, 2.0, 0.5)}
    assert (0.5, 0.0) in places
    assert (1.0, 0.0) not in places
    assert (1.5, 1.5) not in places


def test_mask_scores_differ_the_more_the_farther_and_lead_home_from_near() -> None:
    arena = furnished("masks", 3)
    index = near_and_far(arena)
    near, far = (masks_score.compare(arena, index[name]) for name in ("near", "far"))
    assert near.true == pytest.approx(math.atan2(-near.place[1], -near.place[0]))
    assert angular_errors(np.array([near.three]), np.array([near.true]))[0] < 45.0
    assert np.abs(near.raw).sum() < np.abs(far.raw).sum()
    away, sums = masks_score.sums_by_distance(arena)
    law = masks_score.fitted(away, sums)
    assert law.rank > 0.8
    assert law.at(np.array([law.half]))[0] == pytest.approx(law.top / 2)


def test_the_window_adds_up_ninety_degrees_of_masks() -> None:
    pair = masks_score.compare(furnished("masks", 3), 0)
    share = masks_score.WINDOW / TAU
    assert pair.windowed.mean() == pytest.approx(pair.raw.sum() * share, rel=0.05)


@pytest.mark.parametrize(
    ("name", "good", "bad"), [("K1 > 0, K2 = 0", 0, 1), ("K1 = 0, K2 not 0", 3, 2), ("K1, K2 both not 0", 0, 1)]
)
def test_the_model_that_homes_is_the_one_whose_constant_is_positive(name: str, good: int, bad: int) -> None:
    k1, k2 = routes.constants(name)
    assert (k1, -k1, k2, -k2)[good] > 0.01
    room = routes.landmarks(name)
    goal = room.view(0.0, 0.0, 0.0)
    for angle in np.arange(8) * TAU / 8:
        seen = room.view(0.8 * math.cos(angle), 0.8 * math.sin(angle), 0.0)
        off = [abs(wrap(routes.RouteModel(k).home(seen, goal).bearing - angle - math.pi)) for k in (good, bad)]
        assert off[0] < math.pi / 2 < off[1]


def test_a_run_that_begins_by_the_wrong_model_changes_it_and_arrives() -> None:
    one = routes.run(routes.landmarks("K1 > 0, K2 = 0"), 1)
    assert one.models[0] != 0
    assert one.models[-1] == 0
    assert one.reached
    assert np.hypot(*one.path[-1]) <= routes.REACHED


def test_opposite_models_err_by_opposite_angles_whatever_the_columns() -> None:
    several = [
        Pairwise(f"{k} {chosen}", routes.RouteModel(k, chosen)) for k in (0, 1) for chosen in ("all", "automatic")
    ]
    rows = {row.method: row for row in measured(Recipe("models", 2, furnished), *several).rows}
    for chosen in ("all", "automatic"):
        one, two = (rows[f"{k} {chosen}"].mean for k in (0, 1))
        assert one is not None
        assert two is not None
        assert one.value + two.value == pytest.approx(180.0, abs=1e-6)
    assert rows["0 all"].mean != rows["0 automatic"].mean


def test_lengths_of_home_vectors_grow_with_the_distance() -> None:
    with workers(1, Store(None)) as hands:
        lab = Lab(lambda room, seed, _: Recipe(room, seed, furnished), (4,), hands, lambda: None)
        values = converging.vector_length(lab).values
    assert isinstance(values, dict)
    metres = values["area centroid (5 to 95 %)"]
    assert metres["y"] == pytest.approx(metres["x"], rel=0.35)
    assert values["moment's centroid (5 to 95 %)"]["y"][-1] < 0.8 * metres["y"][-1]


def test_the_full_search_costs_no_more_than_the_stationary_points_and_leads_home() -> None:
    arena = furnished("stationary", 5)
    index = near_and_far(arena)["near"]
    field = stationary.score_field(arena, index)
    assert field.costs[field.least] <= field.costs[field.found, field.found]
    assert abs(wrap((field.found - field.true) * TAU / len(field.costs))) < math.radians(30.0)
    mean = field.costs.mean()
    assert field.costs[field.found, field.found] < 0.7 * mean
    full = stationary.FullSearch(stationary.COARSE)
    seen, goal = (full.describe(arena.source.view(*at, 0.0)) for at in (arena.at(index), arena.home))
    true = math.atan2(-arena.positions[index, 1], -arena.positions[index, 0])
    assert abs(wrap(full.home(seen, goal).bearing - true)) < math.radians(30.0)


def test_places_are_told_apart_by_the_hull_of_the_objects() -> None:
    corners = [Pillar(x, y, 0.1, (0, 0, 0)) for x, y in ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))]
    room = Room(corners, 4.0, plain((200, 200, 200)))
    assert occlusion.zones(np.array([[0.0, 0.9], [0.0, 1.5], [2.5, 0.0]]), room).tolist() == [0.0, 1.0, 2.0]


def test_a_moment_suffers_beside_the_objects_that_hide_others() -> None:
    table = measured(room_recipe("cans", 0, occlusion.cans_arena), MOMENT)
    inside, around, _ = (part.mean() for part in occlusion.errors_by_zone(table.entries[0], (0,)))
    assert inside < 20.0
    assert around > 1.5 * inside


@pytest.mark.parametrize("where", ["far", "near"])
def test_the_error_grows_with_the_moved_angle(where: moved.Where) -> None:
    none, some, half = (error(moved.moved_recipe(where, degrees, 0)) for degrees in (0, 60, 180))
    assert none < 8.0
    assert none < some < half


def test_only_the_sector_is_moved() -> None:
    rooms = moved.rooms(0)
    views = moved.MovedViews(rooms["now"], rooms["near"], math.pi / 2, math.radians(60.0))
    seen, now = views.view(0.0, 0.0, 0.0), rooms["now"].view(0.0, 0.0, 0.0)
    assert seen.ranges is not None
    assert now.ranges is not None
    changed = np.flatnonzero(seen.ranges != now.ranges)
    assert changed.min() >= 120
    assert changed.max() <= 240
    assert seen.ranges[180] == pytest.approx(moved.CLOSE)


@pytest.mark.parametrize(
    "name",
    ["score-histogram", "four-routes", "pixel-selection", "stationary-points", "occlusion", "moved-objects",
     "potential", "convergence-point", "vector-length"],
)  # fmt: skip
def test_a_study_makes_its_figure_and_plain_values(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(routes, "ARRANGEMENTS", dict(list(routes.ARRANGEMENTS.items())[1:3]))
    for module, setting, value in (
        (routes, "SPACING", 1.0), (routes, "STARTS", 2), (moved, "ANGLES", (0, 60)), (moved, "SPACING", 1.0),
        (occlusion, "SPACING", 0.7), (stationary, "COARSE", DynamicWarping(spec=RingSpec(columns=24))),
    ):  # fmt: skip
        monkeypatch.setattr(module, setting, value)
    with workers(1, Store(None)) as hands:
        lab = Lab(lambda room, seed, _: Recipe(room, seed, furnished), (0,), hands, lambda: None)
        found = STUDIES[name].make(lab)
    assert found.figure.axes
    assert json.dumps(found.values, allow_nan=False)
