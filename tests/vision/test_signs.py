"""METHODS.md's corrected signs on a landmark ring with a known displacement, and the fields that don't home alone."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scenes import view

from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU, Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.core.rig import Rig
from topomap.vision.homing import Moment
from topomap.vision.homing.acv import AverageCorrectionalVector
from topomap.vision.homing.alv import AverageLandmarkVector
from topomap.vision.homing.comalv import CentreOfMass
from topomap.vision.homing.delv import DistanceLandmarkVector
from topomap.vision.homing.random_masks import RandomMasks
from topomap.vision.homing.run_down import FIELDS
from topomap.vision.image.distances import polynomial
from topomap.vision.image.haar_masks import MaskSpec, masks, scores
from topomap.vision.image.landmarks import Landmarks, matched
from topomap.vision.matching.equal_distance_search import flow
from topomap.vision.matching.inhibition import inhibited
from topomap.vision.matching.moment_potential import convergence_point, rigid_fit

RING = np.column_stack([3 * np.cos(np.arange(12) * TAU / 12 + 0.1), 3 * np.sin(np.arange(12) * TAU / 12 + 0.1)])
DIRECTIONS = [k * math.pi / 4 + 0.2 for k in range(8)]


def seen_from(x: float, y: float) -> Landmarks:
    """The ring of 12 landmarks, each of its own look, from a place [m]."""
    rays = RING - (x, y)
    bearings = np.mod(np.arctan2(rays[:, 1], rays[:, 0]), TAU)
    return Landmarks(bearings, np.eye(12), np.hypot(*rays.T), Rig())


def off(home: HomeVector, direction: float) -> float:
    """How far [deg] the answer is from the way back along `direction`."""
    return math.degrees(abs(wrap(home.bearing - direction - math.pi)))


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize(
    ("method", "limit"),
    [
        (AverageLandmarkVector(), 3.0),
        (AverageLandmarkVector(pairing="all"), 3.0),
        (AverageCorrectionalVector(), 3.0),
        (DistanceLandmarkVector(), 0.01),
        (DistanceLandmarkVector(robust=False), 0.01),
        (DistanceLandmarkVector(pairing="full"), 0.01),
    ],
)
def test_landmark_vectors_point_home(method: AverageLandmarkVector, limit: float, direction: float) -> None:
    there, here = seen_from(0.0, 0.0), seen_from(0.8 * math.cos(direction), 0.8 * math.sin(direction))
    home = method.home(here, there)
    assert off(home, direction) < limit
    if home.distance is not None:
        assert home.distance == pytest.approx(0.8)


def test_the_correctional_vector_needs_the_wrap() -> None:
    """A landmark whose bearing passes 0 would otherwise count as moved by nearly a full turn."""
    there, here = seen_from(0.0, 0.0), seen_from(0.0, 0.5)
    assert (np.abs(there.bearings - here.bearings) > math.pi).any()
    assert off(AverageCorrectionalVector().home(here, there), math.pi / 2) < 10.0


def test_flow_template_is_the_exact_geometry() -> None:
    for direction in DIRECTIONS:
        step = np.array([math.cos(direction), math.sin(direction)]) * 0.6
        before, after = seen_from(0.0, 0.0), seen_from(*step)
        x = before.bearings - direction
        moved = flow(x, 0.6 / 3.0)
        np.testing.assert_allclose(np.sin(before.bearings + moved - after.bearings), 0.0, atol=1e-9)


def square(x: float, y: float) -> FloatArray:
    """Distances (720,) to the walls of a room of 4 x 3 m around the origin."""
    c, s = np.cos(np.arange(720) * TAU / 720), np.sin(np.arange(720) * TAU / 720)
    with np.errstate(divide="ignore"):
        sideways = np.where(c > 0, (2 - x) / c, (-2 - x) / c)
        along = np.where(s > 0, (1.5 - y) / s, (-1.5 - y) / s)
    return np.minimum(np.abs(sideways), np.abs(along))


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize(
    "moment", [Moment(form="centroid", feature="equal"), Moment(2, "equal"), Moment(3, "equal"),
               Moment(2, "equal", "pixel"), Moment(2, "equal", "area")]
)  # fmt: skip
def test_moments_point_home(moment: Moment, direction: float) -> None:
    """C minus H (a negative order repels: test_options.py)."""
    one = np.ones((1, 720))
    here, there = square(0.5 * math.cos(direction), 0.5 * math.sin(direction)), square(0, 0)
    x, y = moment.vector(here, one) - moment.vector(there, one)
    assert abs(wrap(math.atan2(y, x) - direction - math.pi)) < math.radians(25)


def test_void_moments_abstain() -> None:
    for moment in (Moment(0.0, "grey"), Moment(1.0, "equal"), Moment(-2.0, "equal", "area")):
        assert not moment.vector(square(0.4, 0.1), np.ones((1, 720))).any()


@pytest.mark.parametrize("exponent", [1.5, 2.0, 3.0, 4.0])
def test_the_convergence_point_is_one_place(exponent: float) -> None:
    """Seen from anywhere it is the same point of the world: metric for point landmarks, and a minimum."""
    landmarks = np.random.default_rng(4).uniform(-3, 3, (20, 2))
    weights = np.random.default_rng(5).uniform(0.2, 1, 20)
    shift = np.array([0.7, -0.3])
    here, there = (convergence_point(landmarks - s, weights, exponent) for s in (shift, 0 * shift))
    np.testing.assert_allclose(here - there, -shift, atol=3e-3)

    def potential(at: FloatArray) -> float:
        return float(weights @ np.hypot(*(landmarks - at).T) ** exponent)

    assert all(
        potential(there) < potential(there + d) for d in np.array([[0.05, 0], [-0.05, 0], [0, 0.05], [0, -0.05]])
    )


def test_rigid_fit_finds_rotation_and_place() -> None:
    current = np.array([[0.3, 0.1], [-0.2, 0.5], [0.4, -0.6]])
    turn = np.array([[math.cos(0.7), -math.sin(0.7)], [math.sin(0.7), math.cos(0.7)]])
    psi, shift, residual = rigid_fit(current, current @ turn.T + (1.0, 2.0))
    assert psi == pytest.approx(0.7)
    np.testing.assert_allclose(shift, (1.0, 2.0), atol=1e-12)
    assert residual < 1e-12


def test_the_polynomial_is_as_corrected() -> None:
    """(5.1)'s coefficients in the order of figure 5.6: a landmark ten rows up is 61.6 cm away, not metres."""
    assert polynomial(np.array([0.0, 10.0])) == pytest.approx([0.10, (10 + 50 + 1.43 + 0.18) / 100])


def test_the_centre_of_mass_of_a_known_picture() -> None:
    """Intensity m + cos(t - a): O points along a, its length is half the deviation's."""
    angles = np.arange(720) * TAU / 720
    image = np.repeat((128 + 80 * np.cos(angles - 1.1))[np.newaxis, :, np.newaxis], 100, axis=0).repeat(3, axis=2)
    found = CentreOfMass().describe(Panorama(image.astype(np.uint8)))
    assert math.atan2(found.y, found.x) == pytest.approx(1.1, abs=0.01)
    assert found.length == pytest.approx(math.sqrt(2) / 2, abs=0.02)


@pytest.mark.parametrize("method", [CentreOfMass(), Moment(2, "rgb", distance="equal")])
def test_a_saddle_has_no_sign_of_its_own(method: CentreOfMass | Moment) -> None:
    """Going once around the goal the field turns once the other way: the winding number of a saddle is -1."""
    home = Pose2(3.7, 2.8, 0.0)
    goal = method.describe(view(home))
    poses = [Pose2(home.x + 0.4 * math.cos(a), home.y + 0.4 * math.sin(a)) for a in np.arange(8) * TAU / 8]
    way = [method.home(method.describe(view(p)), goal).bearing for p in poses]
    winding = sum(wrap(b - a) for a, b in zip(way, way[1:] + way[:1], strict=True)) / TAU
    assert winding == pytest.approx(-1.0)


def test_mask_scores_are_those_of_summing_pixels() -> None:
    panorama, spec = view(Pose2(3.7, 2.8)), MaskSpec(count=60, seed=2)
    grey = panorama.image @ np.array([0.299, 0.587, 0.114])
    grey = grey / grey.mean()
    chosen, found = masks(spec, 720, 100, 49.5), scores(panorama, spec)
    for k in range(60):
        means = []
        for sign in (1, -1):
            parts = [chosen.corners[n, k] for n in range(4) if chosen.signs[n, k] == sign]
            pixels = [grey[y0:y1, np.arange(x0, x1) % 720].ravel() for x0, y0, x1, y1 in parts]
            means.append(np.concatenate(pixels).mean() if pixels else 0.0)
        assert found[k] == pytest.approx(abs(means[0] - means[1]), abs=0.005)
    vector = RandomMasks(spec).describe(panorama)
    assert vector.x == pytest.approx(float(np.mean(found * np.cos(chosen.bearings))))


def test_matches_are_mutual_and_within_reach() -> None:
    pairs = matched(seen_from(0.3, 0.2), seen_from(0.0, 0.0), 1.0)
    assert sorted(pairs.goal) == list(range(12))
    assert (pairs.goal == pairs.current).all()
    assert not len(matched(seen_from(0.3, 0.2), seen_from(0.0, 0.0), 1e-3).goal)


def test_inhibition_keeps_what_it_says() -> None:
    home, current = np.array([0, 0, 1, 2, 2]), np.array([0, 1, 1, 2, 3])
    unlike = np.array([0.2, 0.1, 0.3, 0.5, 0.4])
    kept = {way: inhibited(home, current, unlike, way).tolist() for way in ("none", "target", "reverse", "both")}
    assert kept == {"none": [0, 1, 2, 3, 4], "target": [1, 2, 4], "reverse": [0, 1, 3, 4], "both": [1, 4]}


def test_the_four_fields_oppose_in_pairs() -> None:
    vectors = np.array(FIELDS).reshape(4, 2, 2) @ np.array([0.3, 0.8])
    np.testing.assert_array_equal(vectors[0], -vectors[1])
    np.testing.assert_array_equal(vectors[2], -vectors[3])
    assert vectors[0] @ vectors[2] == pytest.approx(0.0)
