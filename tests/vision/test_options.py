"""Every option of a method decides what it says: each on a case worked out by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from scenes import view

from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU, Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision.compass.phase_correlation import PhaseCorrelation
from topomap.vision.compass.rearrangement import Rearrangement
from topomap.vision.homing.avoiding import Avoiding, repulsion
from topomap.vision.homing.bipolar import BipolarMasks
from topomap.vision.homing.comalv import CentreOfMass
from topomap.vision.homing.convergence_point import ConvergencePoint
from topomap.vision.homing.delv import DistanceLandmarkVector, quantised
from topomap.vision.homing.did_moves import TrialMoves
from topomap.vision.homing.dtw import DynamicWarping
from topomap.vision.homing.fusion import MEMBERS, Fusion, Member
from topomap.vision.homing.moment import Moment
from topomap.vision.homing.random_masks import ReferenceMasks
from topomap.vision.homing.run_down import RunDown
from topomap.vision.image.colour_features import features
from topomap.vision.image.haar_masks import MaskSpec, masks, scores
from topomap.vision.image.landmarks import Landmarks
from topomap.vision.image.laser_landmarks import JumpSpec, jumps
from topomap.vision.image.pixel_selection import landmark_count
from topomap.vision.image.skyline import skyline
from topomap.vision.matching.image_flow import GreyView, fitted_image_flow
from topomap.vision.matching.mask_scores import inverse_scores
from topomap.vision.matching.still import still

HOME, POSE = Pose2(3.7, 2.8, 0.4), Pose2(3.3, 3.1, 0.4)
ANGLES = np.arange(720) * TAU / 720


def striped(values: FloatArray) -> Panorama:
    """Every column (W,) of one brightness in [0, 255], or (W, 3) of one colour."""
    columns = values if values.ndim == 2 else np.repeat(values[:, np.newaxis], 3, axis=1)
    return Panorama(np.repeat(columns[np.newaxis].astype(np.uint8), 100, axis=0))


def degrees_off(bearing: float, true: float) -> float:
    return math.degrees(abs(wrap(bearing - true)))


def test_a_moment_of_negative_order_pushes_away_with_its_factor() -> None:
    metres = np.where(np.abs(np.angle(np.exp(1j * ANGLES))) < 0.3, 1.0, 4.0)  # something near, straight ahead
    one = np.ones((1, 720))
    expected = (-1.0 * metres**-2.0 * np.cos(ANGLES)).mean()
    found = Moment(-1.0, "grey").vector(metres, one)
    assert found[0] == pytest.approx(expected)
    assert found[0] < 0.0
    assert Moment(3.0, "grey").vector(metres, one)[0] == pytest.approx((3.0 * metres**2 * np.cos(ANGLES)).mean())


def test_avoidance_keeps_clear_of_what_is_near() -> None:
    ranges = np.where(np.abs(np.angle(np.exp(1j * ANGLES))) < 0.3, 0.4, 4.0).astype(np.float32)
    push = repulsion(Panorama(np.zeros((100, 720, 3), np.uint8), ranges), 0.5)
    assert push[0] < 0.0
    assert abs(push[1]) < 1e-3
    wall = Pose2(0.7, 3.0, 0.0)  # the goal lies along the wall x = 0
    here, there = view(wall, 2), view(Pose2(0.7, 4.0, 0.0), 2)
    steered = [Avoiding(near=n) for n in (0.01, 0.5)]
    bearings = [one.home(one.describe(here), one.describe(there)).bearing for one in steered]
    assert degrees_off(bearings[0], math.pi / 2) < 1.0
    assert 5.0 < math.degrees(bearings[0] - bearings[1]) < 60.0


def test_a_mask_of_type_six_is_a_chessboard() -> None:
    spec = MaskSpec(count=40, kinds=(6,), centre=0.0)
    chosen = masks(spec, 720, 100, 49.5)
    assert (chosen.signs == np.array([1, -1, -1, 1])[:, np.newaxis]).all()
    left, top, right, bottom = np.moveaxis(chosen.corners, -1, 0)
    assert (left[0] == left[2]).all()
    assert (right[0] == left[1]).all()
    assert (bottom[0] == top[2]).all()
    upper, lower = np.arange(100) < 50, np.arange(100) >= 50
    half = np.arange(720) < 360
    board = np.where((upper[:, np.newaxis] & half) | (lower[:, np.newaxis] & ~half), 200, 40)
    edge = np.where(np.broadcast_to(half, (100, 720)), 200, 40)
    centred = np.abs(chosen.bearings - 359.5 * TAU / 720) < 0.15
    seen = [scores(Panorama(np.repeat(p[:, :, np.newaxis], 3, axis=2).astype(np.uint8)), spec) for p in (board, edge)]
    assert centred.any()
    assert seen[0][centred].min() > 5.0 * seen[1][centred].max()


def test_masks_are_as_wide_and_as_even_as_asked() -> None:
    spec = MaskSpec(count=200, width=(0.1, 0.2), height=(0.2, 0.4), even=True, kinds=(1,))
    chosen = masks(spec, 720, 100, 49.5)
    left, top, right, bottom = chosen.corners[0].T
    assert ((right - left >= 70) & (right - left <= 146)).all()
    assert ((bottom - top >= 18) & (bottom - top <= 42)).all()
    np.testing.assert_allclose(np.diff(chosen.bearings), TAU / 200)
    several = masks(replace(spec, candidates=4), 720, 100, 49.5)
    assert len(np.unique(several.bearings.round(9))) == 50


def test_of_each_directions_candidates_the_best_counts() -> None:
    method = ReferenceMasks(MaskSpec(count=12, even=True, candidates=3))
    found = np.array([0.1, 0.5, 0.2, 0.9, 0.1, 0.0, 0.0, 0.0, 0.3, 0.2, 0.2, 0.1])
    assert method._chosen(found).tolist() == [1, 3, 8, 9]
    assert len(ReferenceMasks(MaskSpec(count=12))._chosen(found)) == 12


def test_a_low_pass_takes_small_masks_their_scores() -> None:
    fine = striped(np.where(np.arange(720) // 6 % 2 == 0, 200.0, 40.0))
    narrow = MaskSpec(count=50, kinds=(2,), width=(12 / 720, 13 / 720))
    assert scores(fine, replace(narrow, blur=6.0)).mean() < 0.2 * scores(fine, narrow).mean()


def looks_of(number: int, levels: int = 2) -> FloatArray:
    return np.random.default_rng(number).normal(0.0, 1.0, 3 * levels)


def pairwise(clear: int, doubtful: int, moved: float) -> tuple[Landmarks, Landmarks]:
    """Masks of which the clear ones moved as after a step ahead, the doubtful ones, nearly alike, the other way."""
    bearings = np.linspace(0.2, TAU - 0.3, clear + doubtful)
    rows = [looks_of(k) for k in range(clear)]
    rows += [looks_of(99) + 0.02 * looks_of(100 + k) for k in range(doubtful)]
    step = np.where(np.arange(len(bearings)) < clear, moved, -moved) * np.sin(bearings)
    looks = np.array(rows)
    nothing = np.full(len(bearings), np.nan)
    here = Landmarks(bearings + step, looks + 0.01, nothing, Rig())
    return here, Landmarks(bearings, looks, nothing, Rig())


def test_bipolar_masks_keep_their_best_matches() -> None:
    here, there = pairwise(4, 6, 0.3)
    best = BipolarMasks(levels=1, kept=0.4, ambiguity=0.0).home(here, there)
    everything = BipolarMasks(levels=1, kept=1.0, ambiguity=0.0).home(here, there)
    assert degrees_off(best.bearing, math.pi) < 25.0
    assert degrees_off(best.bearing, everything.bearing) > 1.0


def test_ambiguous_masks_are_dropped() -> None:
    here, there = pairwise(0, 8, 0.02)
    assert BipolarMasks(levels=1, ambiguity=0.0).home(here, there).confidence > 0.0
    assert BipolarMasks(levels=1, ambiguity=0.9).home(here, there).confidence == 0.0
    two = Landmarks(there.bearings[:2], np.stack([looks_of(1), looks_of(1)]), np.full(2, np.nan), Rig())
    assert BipolarMasks(levels=1, score="inverse").home(two, two).confidence == 0.0


def test_weak_masks_are_inhibited() -> None:
    seen = striped(np.where(np.arange(720) < 360, 200.0, 60.0) + 3.0 * (np.abs(np.arange(720) - 200) < 60))
    counts = [len(BipolarMasks(inhibition=i).describe(seen)) for i in (0.0, 3.0)]
    assert counts[0] == 4
    assert counts[1] == 2
    alone = BipolarMasks(stage="masks").describe(seen)
    assert len(alone) > counts[1]


def test_printed_scores_add_up_the_levels() -> None:
    here, there = pairwise(3, 0, 0.1)
    found = inverse_scores(here, there, 1.0, 2)
    apart = np.abs(here.looks[1] - there.looks[1]).reshape(2, 3)
    assert found[1, 1] == pytest.approx((1.0 / (np.sqrt((apart**2).mean(axis=1)) + 0.05)).sum())
    assert not inverse_scores(here, there, 1e-3, 2)[0, 1:].any()
    assert found.argmax(axis=1).tolist() == [0, 1, 2]


def brute_count(current: FloatArray, goal: FloatArray, least: int) -> int:
    """5.1.2.1 by its words: the three most alike among the goal's k brightest, nearer ones more, over k squared."""
    width, best = len(goal), (-1.0, 0)
    here, there = np.argsort(-current, kind="stable"), np.argsort(-goal, kind="stable")
    for k in np.unique(np.linspace(min(least, width), width, 24).astype(int)):
        score = 0.0
        for column in here[:k]:
            among = there[:k][np.argsort(np.abs(goal[there[:k]] - current[column]), kind="stable")[:3]]
            score += sum(1.0 - abs(wrap((other - column) * TAU / width)) / math.pi for other in among)
        best = max(best, (score / k**2, -k))
    return -best[1]


@pytest.mark.parametrize("seed", range(4))
def test_the_number_of_landmark_pixels_is_that_of_the_best_score(seed: int) -> None:
    rng = np.random.default_rng(seed)
    goal = rng.permutation(120) / 120
    current = np.roll(goal, 5) + 1e-4 * rng.normal(size=120)
    found = landmark_count(current, goal, 10)
    assert found == pytest.approx(brute_count(current, goal, 10), abs=15)
    assert found < 120


def test_features_by_threshold() -> None:
    grey = np.repeat([10.0, 60.0, 120.0, 250.0], 180)
    seen = striped(grey)
    bright = features(seen, "bright")[0]
    np.testing.assert_allclose(bright, np.where(grey > 90.0, grey / 255.0, 0.0), atol=1e-6)
    assert features(seen, "hsv-threshold")[0].tolist() == (grey > 127.5).astype(float).tolist()
    red = striped(np.tile([100.0, 10.0, 10.0], (720, 1)))
    assert features(red, "hsv-threshold").all()  # dark, yet of a strong colour


def test_the_rearrangement_knows_the_way_home() -> None:
    for pose in (Pose2(3.2, 2.8, 1.3), Pose2(3.9, 3.4, -0.8)):
        home = Rearrangement().align(view(pose, 2), view(HOME, 2)).home
        assert home is not None
        assert degrees_off(home.bearing, pose.bearing_to(HOME)) < 5.0
        assert home.distance == pytest.approx(pose.distance(HOME), rel=0.1)


def test_levels_of_phase_correlation_undo_a_magnification() -> None:
    goal = view(HOME, 2)
    rows = np.clip(49.5 + (np.arange(100) - 49.5) / 1.08**3, 0, 99).astype(np.float32)
    maps = np.meshgrid(np.arange(720, dtype=np.float32), rows)
    nearer = Panorama(np.roll(cv2.remap(goal.image, maps[0], maps[1], cv2.INTER_LINEAR), -40, axis=1))
    plain, scaled = (PhaseCorrelation(levels=n).align(nearer, goal) for n in (0, 4))
    assert degrees_off(scaled.rotation, 40 * TAU / 720) < 1.0
    assert scaled.residual < 0.75 * plain.residual


@pytest.mark.parametrize("ahead", [0.5, 2.4, -1.7])
def test_the_vertical_flow_alone_shows_the_movement(ahead: float) -> None:
    """What lies ahead grows and what lies astern shrinks: v' = v (1 + a cos(t - b))."""
    rng = np.random.default_rng(3)
    coarse = rng.uniform(0, 255, (14, 1)).astype(np.float32)  # rows only: nothing moves sideways
    goal = np.repeat(cv2.resize(coarse, (1, 50), interpolation=cv2.INTER_CUBIC), 360, axis=1)
    t = np.arange(360) * TAU / 360
    grown = 1.0 + 0.08 * np.cos(t - ahead)
    rows = (24.5 + (np.arange(50)[:, np.newaxis] - 24.5) / grown).astype(np.float32)
    columns = np.broadcast_to(np.arange(360, dtype=np.float32), rows.shape).copy()
    moved = cv2.remap(goal, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    views = [GreyView(np.clip(p, 0, 255).astype(np.uint8), Rig()) for p in (moved, goal)]
    assert degrees_off(fitted_image_flow(*views)[0].direction, ahead) < 15.0


def test_quantised_distances() -> None:
    assert quantised(np.array([0.5, 2.1, 3.9, 4.0, np.nan]), 4)[:4].tolist() == [1.0, 3.0, 4.0, 4.0]
    here, there = view(POSE, 2), view(HOME, 2)
    fine, coarse = (DistanceLandmarkVector(levels=n).describe(here).metres for n in (0, 4))
    assert len(np.unique(coarse.round(6))) <= 4 < len(np.unique(fine.round(6)))
    assert DistanceLandmarkVector(levels=4).home(
        DistanceLandmarkVector(levels=4).describe(here), DistanceLandmarkVector(levels=4).describe(there)
    ) != DistanceLandmarkVector().home(
        DistanceLandmarkVector().describe(here), DistanceLandmarkVector().describe(there)
    )


def test_inhibition_changes_what_warping_says() -> None:
    here, there = view(POSE, 2), view(HOME, 2)
    kinds = [DynamicWarping(inhibition=kind) for kind in ("mean", "none", "target", "reverse", "both")]
    found = {kind.home(kind.describe(here), kind.describe(there)).bearing for kind in kinds}
    assert len(found) == 5
    target, reverse = (DynamicWarping(inhibition=kind) for kind in ("target", "reverse"))
    rings = [np.ascontiguousarray(target.describe(p).fine) for p in (there, here)]
    own = target._paired(rings[0], rings[1], 0, 360)[0]
    assert sorted(own[0].tolist()) == list(range(360))
    other = reverse._paired(rings[0], rings[1], 0, 360)[0]
    assert sorted(other[1].tolist()) == list(range(360))


def test_swing_undoes_a_wrong_compass() -> None:
    here, there = view(POSE, 2), view(HOME, 2)
    turned = here.rolled(30)  # the compass is 15 degrees off
    plain, swung = DynamicWarping(), DynamicWarping(swing=math.radians(15.0))
    right = plain.match(plain.describe(here), plain.describe(there))
    found = swung.match(swung.describe(turned), swung.describe(there))
    assert found.cost == pytest.approx(right.cost, rel=1e-3)
    assert degrees_off(found.home.bearing, right.home.bearing + math.radians(15.0)) < 0.5
    assert found.cost < plain.match(plain.describe(turned), plain.describe(there)).cost
    assert [round(math.degrees(t), 3) for t in DynamicWarping(swing=0.3, rotations=4).turns()] == [
        -5.73, 5.73, -17.189, 17.189,
    ]  # fmt: skip


def test_stationary_points_of_the_image_start_the_warping() -> None:
    """III of the thesis: 2D flow and unifying; another start than the ring's flow gives, and a better one blind."""
    here, there = view(POSE, 2), view(HOME, 2)
    one, two = DynamicWarping(), DynamicWarping(start="image")
    pairs = [(m.describe(here), m.describe(there)) for m in (one, two)]
    starts = [m.diffusion(*pair) for m, pair in zip((one, two), pairs, strict=True)]
    away = HOME.bearing_to(POSE)
    assert all(degrees_off(s, away) < 12.0 for s in starts)
    assert starts[0] != starts[1]
    blind = replace(pairs[1][0], coarse=np.zeros_like(pairs[1][0].coarse))
    assert two.diffusion(blind, pairs[1][1]) == starts[1]


def test_wing_and_unifying_count_together() -> None:
    here, there = view(POSE, 2), view(HOME, 2)
    pairs = {}
    for wings in ("unifying", "wing", "joined"):
        method = DynamicWarping(wings=wings)
        pairs[wings] = method._matched(method.describe(here).fine, method.describe(there).fine, 10)
    assert len(pairs["joined"][0]) == len(pairs["unifying"][0]) + len(pairs["wing"][0])
    assert pairs["joined"][2] == pytest.approx((pairs["unifying"][2] + 2 * pairs["wing"][2]) / 3)


def test_what_moved_by_itself_is_left_out() -> None:
    there = np.linspace(0.0, TAU, 72, endpoint=False)
    here = there + 0.2 * np.sin(there - 1.0)  # a step along 1.0 rad
    here[20:30] -= 0.5 * np.sign(np.sin(there[20:30] - 1.0))  # somebody walks
    kept = still(there, here, 1.0 + math.pi)
    assert not kept[20:30].any()
    assert np.delete(kept, np.arange(20, 30)).all()
    assert still(there, here[::-1].copy(), 0.0).all()  # where most seems to move, nothing is known


def test_newton_reaches_the_bottom_of_a_narrow_valley() -> None:
    def seen(method: TrialMoves) -> FloatArray:
        turns = np.arange(method.directions) * TAU / method.directions
        places = np.vstack([[0.0, 0.0], method.trial * np.column_stack([np.cos(turns), np.sin(turns)])])
        return 0.5 * ((places[:, 0] - 1.0) ** 2 + 4.0 * (places[:, 1] - 0.5) ** 2)

    gradient, four, eight = TrialMoves("gradient", 4), TrialMoves("newton", 4), TrialMoves("newton", 8)
    true = math.atan2(0.5, 1.0)
    assert degrees_off(math.atan2(*gradient.towards(seen(gradient))[::-1]), true) > 30.0
    for method in (four, eight):
        assert degrees_off(math.atan2(*method.towards(seen(method))[::-1]), true) < 1.0


def test_edges_or_brightness_draw_the_centre_of_mass() -> None:
    columns = 120.0 + 60.0 * np.cos(ANGLES - math.pi / 2)  # bright to the left, without an edge
    columns[480:560] += np.where(np.arange(80) // 8 % 2 == 0, 40.0, -40.0)  # stripes behind to the right
    plain, edges = (CentreOfMass(edges=e).describe(striped(columns)) for e in (False, True))
    assert degrees_off(math.atan2(plain.y, plain.x), math.pi / 2) < 5.0
    assert degrees_off(math.atan2(edges.y, edges.x), 520 * TAU / 720) < 15.0


def test_the_convergence_point_of_order_one_abstains() -> None:
    """Of equal features the geometric median of all that is seen is the robot itself."""
    for n, equal in ((1.0, True), (1.0, False), (2.0, True)):
        method = ConvergencePoint(n, "equal" if equal else "grey")
        home = method.home(method.describe(view(POSE, 2)), method.describe(view(HOME, 2)))
        assert (home.confidence == 0.0) == (n == 1.0 and equal)
        assert method.claims_homing == (home.confidence > 0.0)
        assert method.claims_homing == (method.describe(view(POSE, 2)).share > 0.0)


def test_run_down_by_grey_rgb_threshold_and_sorting() -> None:
    columns = np.full((720, 3), 40.0)
    columns[80:100, 0] = 250.0  # red ahead to the left
    columns[400:460, 2] = 250.0
    here, there = striped(columns), striped(np.full((720, 3), 40.0))
    grey, colour = RunDown("all"), RunDown("all", colour=True)
    assert grey.difference(here, there).tolist() != colour.difference(here, there).tolist()
    sorted_ = RunDown("sorting", count=20)
    seen = RunDown("sorting", count=20)._one(np.where(np.arange(720) < 20, 0.9, 0.1), np.full(720, 0.0))
    angles = np.arange(20) * TAU / 720
    np.testing.assert_allclose(seen, 0.9 * np.array([np.cos(angles).sum(), np.sin(angles).sum()]) / 720)
    assert sorted_.origin.row == "H22"
    above = RunDown("threshold")._one(np.where(np.arange(720) < 20, 0.9, 0.1), np.full(720, 0.0))
    np.testing.assert_allclose(above, seen)


def test_jumps_of_the_range_are_landmarks() -> None:
    ranges = np.full(720, 4.0, np.float32)
    ranges[200:221] = 2.0
    ranges[710:] = ranges[:11] = 1.5  # over the seam
    found = jumps(Panorama(np.zeros((100, 720, 3), np.uint8), ranges), JumpSpec())
    np.testing.assert_allclose(np.sort(found.bearings), [0.0, 210 * TAU / 720], atol=1e-9)
    assert sorted(found.looks[:, 0].round(3)) == sorted(round(d * 21 * TAU / 720, 3) for d in (1.5, 2.0))
    assert not len(jumps(Panorama(np.zeros((100, 720, 3), np.uint8), np.full(720, 3.0, np.float32)), JumpSpec()))


def test_the_skyline_is_where_the_sky_begins() -> None:
    image = np.full((100, 720, 3), 220, np.uint8)
    tops = (30 + 10 * np.sin(ANGLES * 2)).astype(int)
    for column, top in enumerate(tops):
        image[top:, column] = 60
    heights = skyline(Panorama(image))
    true = (49.5 - tops) / Rig().focal
    assert np.quantile(np.abs(heights - true), 0.9) < 2.6 / Rig().focal  # the line keeps to its neighbours
    assert np.abs(heights - true).mean() < 1.5 / Rig().focal


def test_fusion_outvotes_a_wrong_answer_and_knows_how_sure_it_is() -> None:
    here, there = view(POSE, 2), view(HOME, 2)
    true = POSE.bearing_to(HOME)

    class Wrong:
        needs, claims_homing = MEMBERS[0].method.needs, True

        def describe(self, panorama: Panorama) -> Panorama:
            return panorama

        def home(self, current: Panorama, goal: Panorama) -> object:
            return replace(MEMBERS[0].method.home(*(MEMBERS[0].method.describe(p) for p in (current, goal))),
                           bearing=wrap(true + 2.5), confidence=1.0)  # fmt: skip

    fused = Fusion((*MEMBERS[:3], Member(Wrong(), 5.0, 10.0))).home(here, there)
    assert degrees_off(fused.bearing, true) < 6.0
    alone = Fusion((Member(Wrong(), 1.0, 10.0),)).home(here, there)
    assert alone.confidence == pytest.approx(1 / (1 + math.exp(0.1)), abs=0.08)
    sure = Fusion().home(here, there)
    assert sure.confidence > 0.95
    assert degrees_off(sure.bearing, true) < 1.0
