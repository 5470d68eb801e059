"""Small views: stored and taken ones are alike to the bit, and look where the large ones do."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from topomap.core.errors import DataError
from topomap.core.panorama import Panorama
from topomap.core.recorded import RecordedRig
from topomap.core.view_size import ViewSize, parse_view
from topomap.mapping.places.small_view import small_view, snapshot_of, view_of
from topomap.vision.image.compare import rotation_difference, signature

SIZE = ViewSize(90, 12, 4)


def panorama(width: int = 720, height: int = 100, seed: int = 0) -> Panorama:
    """A smooth view with ranges, nose in column 0."""
    rng = np.random.default_rng(seed)
    coarse = rng.integers(0, 256, (height // 10, width // 20, 3)).astype(np.float32)
    tiled = cv2.resize(np.tile(coarse, (1, 3, 1)), (3 * width, height), interpolation=cv2.INTER_CUBIC)
    image = np.clip(tiled[:, width : 2 * width], 0, 255).astype(np.uint8)
    rig = RecordedRig.cylinder(width, height, 0.6, forward_column=0, clockwise=False)
    far = (3.0 + np.sin(np.arange(width) * math.tau / width)).astype(np.float32)
    return Panorama.from_recorded(image, rig, far)


def test_a_stored_view_is_the_one_that_was_taken() -> None:
    small = small_view(panorama(), SIZE)
    stored = snapshot_of(small)
    assert len(stored.encoded) < 600
    back = view_of(stored, SIZE)
    assert np.array_equal(back.image, small.image)
    assert np.array_equal(back.ranges, small.ranges)
    assert back.rig == small.rig
    assert len(np.unique(small.image)) <= 16


@pytest.mark.parametrize(("width", "height"), [(720, 100), (361, 77), (1000, 64)])
def test_it_looks_where_the_large_one_does(width: int, height: int) -> None:
    whole = panorama(width, height)
    for angle in (0.0, 1.0, math.pi, -2.0):
        small, turned = small_view(whole, SIZE), small_view(whole.rotated(-angle), SIZE)
        _, rotation = rotation_difference(signature(turned), signature(small))
        assert math.remainder(rotation - angle, math.tau) == pytest.approx(0.0, abs=math.radians(1.0))


def test_column_zero_looks_along_the_nose_and_the_horizon_stays() -> None:
    image = np.zeros((100, 720, 3), np.uint8)
    image[:, [718, 719, 0, 1, 2]] = 255
    image[50:, 360] = 255
    whole = Panorama.from_recorded(image, RecordedRig.cylinder(720, 100, 0.6, forward_column=0, clockwise=False))
    small = small_view(whole, SIZE)
    assert small.image[:, :, 0].argmax(axis=1).tolist() == [0] * 12
    assert small.image[0, 1, 0] == small.image[0, 89, 0]
    assert small.rig.horizon_row == pytest.approx(5.5)
    assert small.rig.focal / small.rig.height == pytest.approx(whole.rig.focal / whole.rig.height)


def test_a_thing_nearby_is_not_lost_between_two_rays() -> None:
    whole = panorama()
    assert whole.ranges is not None
    ranges = whole.ranges.copy()
    ranges[244] = 0.5
    ranges[120] = np.nan
    small = small_view(Panorama(whole.image, ranges, whole.rig), SIZE)
    assert small.ranges is not None
    assert small.ranges[30] == small.ranges[31] == pytest.approx(0.5)
    assert np.isnan(small.ranges[15])
    assert small.ranges[0] == pytest.approx(3.0)


def test_a_camera_that_is_as_small_is_left_as_it_is() -> None:
    tiny = panorama(64, 20)
    assert small_view(tiny, SIZE) is tiny
    assert small_view(small_view(panorama(), SIZE), SIZE).rig.width == 90


@pytest.mark.parametrize("text", ["", "90", "90x12", "90x12x9", "8x12x4", "axbxc", "90x12x4x1", 5, None])
def test_another_size_is_refused(text: object) -> None:
    with pytest.raises(DataError, match="view"):
        parse_view(text)
