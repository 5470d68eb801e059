"""The one place where recorded columns become bearings."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import Room

from topomap.core.errors import ShapeError
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig


@dataclass(frozen=True)
class RecordedRig:
    width: int = 720
    height: int = 100
    horizon_row: float = 49.5
    focal: float = 720 / TAU
    camera_height: float = 0.6
    forward_column: int = 360
    clockwise: bool = True


@pytest.mark.parametrize(("clockwise", "column"), [(True, 180), (False, 540)])
def test_a_landmark_to_the_left_is_a_quarter_in(clockwise: bool, column: int) -> None:
    image = np.zeros((100, 720, 3), np.uint8)
    image[:, column] = 255  # people read panoramas clockwise: left of the nose is left in the picture
    panorama = Panorama.from_recorded(image, RecordedRig(clockwise=clockwise))
    assert np.flatnonzero(panorama.image[0, :, 0]).tolist() == [180]
    assert panorama.rig.bearing(180) == pytest.approx(math.pi / 2)


@given(st.integers(0, 23), st.booleans())
def test_ordering_is_lossless(forward: int, clockwise: bool) -> None:
    image = np.random.default_rng(forward).integers(0, 256, (5, 24, 3), dtype=np.uint8)
    rig = RecordedRig(24, 5, 2.0, 24 / TAU, 0.5, forward, clockwise)
    ordered = Panorama.from_recorded(image, rig).image
    way = -1 if clockwise else 1
    for j in range(24):
        assert (ordered[:, j] == image[:, (forward + way * j) % 24]).all()


def test_rolling_by_psi_aligns_a_robot_turned_by_psi() -> None:
    room, psi = Room(), 100 * TAU / 720
    goal, current = room.view(3, 2, 0.3), room.view(3, 2, 0.3 + psi)
    assert np.abs(current.rotated(psi).image.astype(int) - goal.image).max() <= 1
    aligned, wanted = current.rotated(psi).ranges, goal.ranges
    assert aligned is not None
    assert wanted is not None
    np.testing.assert_allclose(aligned, wanted, rtol=1e-4)


def test_derived_is_made_once_per_key() -> None:
    panorama, made = Room().view(3, 3), []
    for key in ("a", "a", "b"):
        panorama.derived(key, lambda p: made.append(p.rig.width))
    assert made == [720, 720]


def test_wrong_shapes_are_refused() -> None:
    image = np.zeros((100, 720, 3), np.uint8)
    with pytest.raises(ShapeError):
        Panorama(image[:, :700])
    with pytest.raises(ShapeError):
        Panorama(image.astype(np.float32))  # type: ignore[arg-type]
    with pytest.raises(ShapeError):
        Panorama(image, np.zeros(360, np.float32))
    with pytest.raises(ShapeError):
        Panorama.from_recorded(image, replace(RecordedRig(), width=360))
    with pytest.raises(ShapeError):
        Panorama(image, rig=Rig(height=50))
