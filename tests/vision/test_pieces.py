"""Small pieces of the methods, each where a mistake in it would show."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from topomap.core.errors import DataError
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, HomeVector
from topomap.core.rig import Rig
from topomap.vision.arena import central, spread
from topomap.vision.compass.scale_plane_compass import ScalePlaneCompass
from topomap.vision.contracts import Needs
from topomap.vision.eye_level import _peak
from topomap.vision.homing import auto
from topomap.vision.homing.convergence_point import ConvergencePoint
from topomap.vision.homing.did_moves import TrialMoves
from topomap.vision.homing.equal_warping import EqualWarping, RingWarping
from topomap.vision.homing.matched_filter import _upward
from topomap.vision.homing.view_vector import ViewVector
from topomap.vision.image.distances import fitted_coefficients, polynomial
from topomap.vision.image.keypoints import Keypoints, matched_keypoints
from topomap.vision.image.landmarks import MarkerSpec, _runs, markers
from topomap.vision.image.pixel_selection import selected
from topomap.vision.image.scale_planes import WarpingSpec
from topomap.vision.image.unwrap import _shift
from topomap.vision.matching.moment_potential import _gradient
from topomap.vision.matching.scan_search import _turns
from topomap.vision.matching.warping import rotations
from topomap.vision.tilt.verticals import _fitted


def blank(rig: Rig | None = None) -> Panorama:
    rig = rig or Rig()
    return Panorama(np.full((rig.height, rig.width, 3), 90, np.uint8), None, rig)


@pytest.mark.parametrize(("roll", "pitch"), [(0.03, 0.0), (0.0, -0.04), (-0.02, 0.05)])
def test_edges_that_run_as_a_lean_has_them_tell_it(roll: float, pitch: float) -> None:
    columns = np.arange(0, 360, 2)
    bearings = columns * TAU / 360
    stretch = 1.3
    run = stretch * (roll * np.cos(bearings) + pitch * np.sin(bearings))
    found = _fitted(np.column_stack([columns, run, np.full(len(run), 900.0)]), 360, stretch)
    assert found is not None
    assert [found.lean.roll, found.lean.pitch] == pytest.approx([roll, pitch], abs=1e-4)


def test_few_edges_tell_no_lean() -> None:
    edges = np.column_stack([np.arange(59.0), np.zeros(59), np.full(59, 900.0)])
    assert _fitted(edges, 360, 1.0) is None


def test_the_position_nearest_to_the_middle_is_central() -> None:
    positions = np.array([[0.0, 0.0], [4.0, 0.0], [2.2, 0.9], [4.0, 2.0]])
    assert central(positions) == (2.2, 0.9)


def test_positions_spread_out_until_there_is_no_other_one() -> None:
    positions = np.array([[0.0, 0.0], [0.3, 0.0], [0.0, 0.7], [0.0, 0.7]])
    assert spread(positions, (0.0, 0.0), 4) == [2, 1]
    assert spread(positions, (0.0, 0.0), 1) == [2]


def test_only_who_needs_the_cameras_height_asks_for_it() -> None:
    low, known = blank(replace(Rig(), camera_height=0.0)), blank(replace(Rig(), camera_height=0.4))
    Needs().check(low)
    Needs(camera_height=True).check(known)
    with pytest.raises(DataError, match="camera's height"):
        Needs(camera_height=True).check(low)
    with pytest.raises(DataError, match="ranges"):
        Needs(ranges=True).check(known)


def test_a_marker_is_a_run_of_its_colour_on_the_horizon() -> None:
    view = blank()
    middle, red = int(view.rig.horizon_row), (200, 20, 20)
    view.image[middle - 2 : middle + 3, 10:14] = red
    view.image[middle - 2 : middle + 3, 40:42] = red  # too narrow
    view.image[middle + 3 : middle + 6, 60:70] = red  # too low
    view.image[: middle - 2, 80:90] = red  # too high
    found = markers(view, MarkerSpec())
    assert found.bearings == pytest.approx([11.5 * TAU / view.rig.width])


def test_runs_go_around_the_circle_and_a_whole_one_has_no_ends() -> None:
    assert _runs(np.array([True, False, True, True])) == [(2, 3)]
    assert _runs(np.ones(4, np.bool_)) == []


def test_a_peak_between_rows_is_found_and_none_beyond_the_neighbours() -> None:
    rows = np.array([10.0, 12.0, 14.0])
    assert _peak(rows, np.array([1.0, 3.0, 2.0])) == pytest.approx(12.0 + 2.0 / 6.0)
    assert _peak(rows, np.array([0.0, 1.0, 1.9])) == pytest.approx(14.0)
    assert _peak(rows, np.array([1.0, 1.0, 1.0])) == 12.0


def test_two_rows_have_a_slope() -> None:
    assert _upward(np.array([[3.0], [1.0]], np.float32), 0.5) == pytest.approx(np.array([[4.0], [4.0]]))
    assert not _upward(np.ones((1, 3), np.float32), 0.5).any()


@pytest.mark.parametrize("method", [RingWarping(), EqualWarping()])
def test_two_blank_views_tell_no_way_home(method: RingWarping | EqualWarping) -> None:
    view = method.describe(blank())
    home = method.home(view, view)
    assert (home.distance, home.confidence) == (None, 0.0)
    assert math.isfinite(home.bearing)


@pytest.mark.parametrize("exponent", [1.0, 1.5, 3.0])
def test_the_slope_of_a_moments_potential_is_its_derivative(exponent: float) -> None:
    landmarks, weights = np.array([[1.0, 0.5], [-2.0, 1.0], [0.3, -1.5]]), np.array([1.0, 0.5, 2.0])

    def potential(at: np.ndarray) -> float:
        return float(weights @ np.hypot(*(at - landmarks).T) ** exponent)

    at, step = np.array([0.2, -0.1]), 1e-6
    slope = [(potential(at + d) - potential(at - d)) / (2 * step) for d in np.eye(2) * step]
    assert _gradient(at, landmarks, weights, exponent) == pytest.approx(slope, rel=1e-5)


def test_the_brightest_columns_of_the_horizon_are_selected() -> None:
    view = blank()
    view.image[:, [3, 50, 90]] = 200
    view.image[:, 120] = 150
    assert np.flatnonzero(selected(view, 3)).tolist() == [3, 50, 90]
    assert np.flatnonzero(selected(view, 4)).tolist() == [3, 50, 90, 120]


def test_trial_moves_go_to_the_least_difference_and_stay_where_none_is_less() -> None:
    moves = TrialMoves("basic", 4)
    assert moves.towards(np.array([5.0, 5.5, 4.9, 4.95, 6.0])) == pytest.approx((0.0, 1.0), abs=1e-12)
    assert moves.towards(np.array([5.0, 5.0, 5.5, 6.0, 7.0])) == (0.0, 0.0)
    assert TrialMoves("gradient", 2).towards(np.full(3, 5.0)) == (0.0, 0.0)
    assert TrialMoves("gradient", 2).towards(np.array([5.0, 5.3, 4.6])) == pytest.approx((-0.6, 0.8))


def test_rotations_within_a_window_are_searched_and_all_where_it_is_as_wide() -> None:
    column = TAU / 72
    assert rotations(0.0, 3 * column, 72) == (-3, 7)
    assert rotations(10 * column, 2.5 * column, 72) == (7, 7)
    assert rotations(0.0, 34.5 * column, 72) == (-35, 71)
    assert rotations(0.0, 34.5 * column, 71) == (0, 71)
    assert rotations(None, 3 * column, 72) == (0, 72)


@pytest.mark.parametrize(("apart", "sure"), [(1.9e-3, False), (2.1e-3, True), (2.9e-3, True)])
def test_convergence_points_nearer_than_both_are_off_tell_no_way(apart: float, sure: bool) -> None:
    rig = Rig()
    home = ConvergencePoint(1.5).home(ViewVector(0.0, apart, 1.0, rig), ViewVector(0.0, 0.0, 1.0, rig))
    assert (home.confidence > 0.0) == sure


def test_scans_are_tried_in_turns_a_step_apart_within_a_window_and_two_around_the_circle() -> None:
    assert _turns(0.5, 0.25, 0.1) == pytest.approx([0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8])
    assert _turns(0.5, 0.0, 0.1) == [0.5]
    around = _turns(0.5, math.pi, 0.13)
    assert (around[0], len(around)) == (0.0, 25)
    assert np.diff(around) == pytest.approx(TAU / 25)


def test_the_fitted_cubic_is_the_floors_distance_and_nothing_where_there_is_no_floor() -> None:
    rig = Rig()
    rows = np.array([70.0, 80.0, 95.0])
    told = polynomial(rig.height - 0.5 - rows, *fitted_coefficients(rig))
    assert told == pytest.approx(rig.camera_height * rig.focal / (rows - rig.horizon_row), rel=0.1)
    assert fitted_coefficients(replace(rig, horizon_row=rig.height - 1.0)) == (0.0, 0.0, 0.0, 0.0)
    assert polynomial(np.array([2.0])) == pytest.approx([0.1 + 0.1 + 4 * 0.000143 + 8 * 0.0000018])


@pytest.mark.parametrize("third", range(5))
def test_a_turn_of_thirds_of_a_column_is_found(third: int) -> None:
    compass = ScalePlaneCompass(WarpingSpec(72, 50, phases=3))
    rng = np.random.default_rng(6)
    fine = np.repeat(np.repeat(rng.integers(0, 256, (25, 108, 3), dtype=np.uint8), 4, axis=0), 4, axis=1)
    rig = Rig(432, 100, 49.5, 432 / TAU)
    goal, turned = Panorama(fine, None, rig), Panorama(np.roll(fine, 2 * third, axis=1), None, rig)
    found = compass.align(turned, goal).rotation
    assert abs(found) == pytest.approx(2 * third * TAU / 432, abs=0.3 * TAU / 216)


def test_two_points_a_view_are_enough_to_be_matched_and_one_is_not() -> None:
    def points(count: int) -> Keypoints:
        return Keypoints(np.arange(float(count)), np.zeros(count), np.eye(count, 128, dtype=np.float32), Rig())

    assert matched_keypoints(points(2), points(2)).rays[:, 0].tolist() == [0.0, 1.0]
    assert not len(matched_keypoints(points(2), points(1)).rays)
    assert not len(matched_keypoints(points(1), points(2)).rays)


def test_a_distance_that_is_told_is_kept_and_one_that_is_not_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(auto, "_distance", lambda *_: 7.0)
    for told, kept in ((1.5, 1.5), (0.0, 0.0), (None, 7.0)):
        found = Alignment(0.1, 0.5, HomeVector(0.3, told, 0.9))
        answer = auto.Auto()._sure("range", 0.5, found, blank(), blank())
        assert answer.alignment.home is not None
        assert answer.alignment.home.distance == kept


def test_what_points_nowhere_is_told_as_nothing() -> None:
    answer = auto.Auto()._sure("range", 0.5, Alignment(0.1, 0.5, None), blank(), blank())
    assert answer.alignment.home is not None
    assert (answer.alignment.home.bearing, answer.alignment.home.confidence) == (0.0, 0.0)


def test_a_view_correlates_with_itself_wholly_and_turned_by_its_turn() -> None:
    rng = np.random.default_rng(7)
    view = Panorama(rng.integers(0, 256, (40, 90, 3), dtype=np.uint8), None, Rig(90, 40, 19.5, 90 / TAU))
    assert _shift(view, view) == pytest.approx((0.0, 1.0))
    assert _shift(view.rolled(12), view) == pytest.approx((12 * TAU / 90, 1.0))
