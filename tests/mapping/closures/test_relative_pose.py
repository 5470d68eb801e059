"""A closure's relative pose: where ranges begin to search, what is believed beside them, and how exactly."""

from __future__ import annotations

import math

import numpy as np
import pytest

from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, HomeVector, PlaceMatch
from topomap.core.rig import Rig
from topomap.mapping.closures.appearance import Look
from topomap.mapping.closures.relative_pose import RelativePoseEstimator, RelativePoseSettings
from topomap.vision.matching.scan_match import MEASURED, ScanMatch, Surfaces

TRUE = Pose2(0.3, 0.4, 0.5)  # half a metre away, one of the starts
WHERE = "topomap.mapping.closures.relative_pose.match_scans"


def look(home: bool = True) -> Look:
    """What sight says of a view at TRUE: the place lies behind it."""
    bearing = math.atan2(-TRUE.y, -TRUE.x) - TRUE.heading
    return Look(PlaceMatch(0, 0.3, 0.0), Alignment(TRUE.heading, 0.3, HomeVector(bearing) if home else None))


def view(ranges: bool = True) -> Panorama:
    rig = Rig(width=48, height=16, horizon_row=7.5, focal=48 / math.tau)
    return Panorama(np.zeros((16, 48, 3), np.uint8), np.ones(48, np.float32) if ranges else None, rig)


class Matcher:
    """Stands for the scan matcher: notes where it is to begin and finds what it is told to."""

    def __init__(self, found: ScanMatch | None, by: Surfaces = MEASURED) -> None:
        self.found, self.by, self.starts = found, by, list[FloatArray]()

    def __call__(self, a: Float32Array, b: Float32Array, guess: FloatArray, surfaces: Surfaces) -> ScanMatch | None:
        self.starts.append(guess)
        return self.found if surfaces is self.by else None


def test_ranges_begin_at_the_spot_and_on_the_line_that_leads_home(monkeypatch: pytest.MonkeyPatch) -> None:
    matcher = Matcher(ScanMatch(TRUE.array(), 1e-6 * np.eye(3), 0.8))
    monkeypatch.setattr(WHERE, matcher)
    RelativePoseEstimator(RelativePoseSettings()).measure(look(), view(), view())
    assert np.array(matcher.starts) == pytest.approx(np.array([[0, 0, 0.5], [0.15, 0.2, 0.5], [0.3, 0.4, 0.5]]))


def test_without_a_home_vector_they_begin_at_the_spot(monkeypatch: pytest.MonkeyPatch) -> None:
    matcher = Matcher(ScanMatch(TRUE.array(), 1e-6 * np.eye(3), 0.8))
    monkeypatch.setattr(WHERE, matcher)
    RelativePoseEstimator(RelativePoseSettings()).measure(look(home=False), view(), view())
    assert np.array(matcher.starts) == pytest.approx(np.array([[0, 0, 0.5]]))


def test_what_is_measured_and_what_is_believed_are_weighed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Along x as uncertain as the belief, so half way; along y exact but for the least error of ranges."""
    own = np.diag([0.35**2 - 0.03**2, 0.0, 0.0])
    monkeypatch.setattr(WHERE, Matcher(ScanMatch(TRUE.array(), own, 0.8)))
    found = RelativePoseEstimator(RelativePoseSettings(position_sigma=0.35)).measure(look(), view(), view())
    assert found.relative.x == pytest.approx(0.15)
    assert found.relative.y == pytest.approx(0.4 * 0.35**2 / (0.35**2 + 0.03**2))
    assert found.covariance[0, 0] == pytest.approx(0.35**2 / 2)
    assert found.covariance[1, 1] == pytest.approx(1 / (1 / 0.35**2 + 1 / 0.03**2))
    assert found.covariance[2, 2] == pytest.approx(1 / (1 / math.radians(4) ** 2 + 1 / math.radians(0.5) ** 2))
    assert found.share == 0.8


@pytest.mark.parametrize("place", [True, False])
def test_unmeasured_it_is_the_same_spot_as_inexactly_as_that_is(monkeypatch: pytest.MonkeyPatch, place: bool) -> None:
    monkeypatch.setattr(WHERE, Matcher(None))
    found = RelativePoseEstimator(RelativePoseSettings()).measure(look(), view() if place else None, view())
    assert found.relative == Pose2(0.0, 0.0, 0.5)
    assert np.sqrt(np.diag(found.covariance)) == pytest.approx([0.35, 0.35, math.radians(4)])
    assert found.share == 0.0


def test_the_match_of_most_rays_wins(monkeypatch: pytest.MonkeyPatch) -> None:
    found = iter([0.3, 0.9, 0.5])
    monkeypatch.setattr(WHERE, lambda *_: ScanMatch(TRUE.array(), 1e-6 * np.eye(3), next(found)))
    assert RelativePoseEstimator(RelativePoseSettings()).measure(look(), view(), view()).share == 0.9
