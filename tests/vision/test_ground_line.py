"""The ground line: a line around a ring of columns, and distances against a simulated world's own."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topomap.app.views import world_recipe
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision.image.distances import distances
from topomap.vision.image.ground_line import ground_line, ground_ranges
from topomap.vision.image.seam import seam


def value(score: np.ndarray, path: np.ndarray, bend: float, jump: float) -> float:
    """What a line is worth, once around."""
    moves = np.abs(np.diff(np.append(path, path[0])))
    costs = np.where(moves <= 2, np.minimum(bend * moves, jump), jump)
    return float(score[path, np.arange(len(path))].sum() - costs.sum())


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000))
def test_no_random_line_is_worth_more_than_the_seam(seed: int) -> None:
    rng = np.random.default_rng(seed)
    score = rng.uniform(0, 1, (5, 9))
    best = value(score, seam(score, 0.15, 0.8), 0.15, 0.8)
    others = [value(score, rng.integers(0, 5, 9), 0.15, 0.8) for _ in range(200)]
    straight = [value(score, np.full(9, row), 0.15, 0.8) for row in range(5)]
    assert best >= max(others + straight) - 0.3, "once around may close a little worse than it could"


def test_a_line_goes_on_across_the_seam_and_breaks_where_a_thing_stands_before_it() -> None:
    score = np.zeros((20, 72))
    line = np.round(10 + 4 * np.sin(np.arange(72) * 2 * np.pi / 72)).astype(int)
    line[30:40] = 17
    score[line, np.arange(72)] = 1.0
    score[:, 5] = 0.0
    found = seam(score, 0.15, 0.8)
    assert np.array_equal(np.delete(found, 5), np.delete(line, 5))
    assert abs(found[5] - line[5]) <= 1


PLACES = [("office-loop", (12.0, 0.0, 0.3)), ("ourlab", (2.5, 2.5, 1.0)), ("room-corridor", (3.0, 2.0, 0.5))]


@pytest.mark.parametrize(("world", "pose"), PLACES)
def test_distances_are_those_of_the_world(world: str, pose: tuple[float, float, float]) -> None:
    view = world_recipe(world, 1, ()).arena().source.view(*pose)
    assert view.ranges is not None
    found = ground_ranges(Panorama(view.image, None, view.rig))
    visible = (view.ranges > 1.45) & (view.ranges < 4.0) & np.isfinite(found)
    assert visible.sum() > 100
    off = found[visible] / view.ranges[visible] - 1.0
    assert abs(np.median(off)) < 0.02
    assert np.percentile(np.abs(off), 70) < 0.06


def test_where_no_floor_is_seen_nothing_is_told() -> None:
    rig = Rig()
    grey = Panorama(np.full((rig.height, rig.width, 3), 90, np.uint8), None, rig)
    assert np.isnan(ground_ranges(grey)).all()
    assert distances(grey, "ground").share == 0.0
    sky = Rig(rig.width, rig.height, rig.height - 1.0, rig.focal)
    assert np.isnan(ground_ranges(Panorama(grey.image, None, sky))).all()


def test_turning_turns_the_line() -> None:
    view = world_recipe("ourlab", 1, ()).arena().source.view(2.0, 2.5, 0.0)
    rows = ground_line(view).rows
    turned = ground_line(view.rolled(100)).rows
    assert np.mean(np.roll(rows, 100) == turned) > 0.98
