"""Mirror pictures: there and back, and the ring found again in a picture."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scenes import view

from topomap.core.errors import DataError, ShapeError
from topomap.core.geometry import TAU, Pose2
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision.image.unwrap import MirrorRig, fit_mirror, unwrap, wrap_up

MIRROR = MirrorRig(330.0, 236.0, 60.0, 215.0, 0.8)
PANORAMA = view(Pose2(3.7, 2.8, 0.4))
SIZE = (480, 640)


@pytest.mark.parametrize("turn", ["clockwise", "counter-clockwise"])
@pytest.mark.parametrize("floor", [True, False])
def test_there_and_back(turn: str, floor: bool) -> None:
    mirror = MirrorRig(330.0, 236.0, 60.0, 215.0, 0.8, turn, floor)  # type: ignore[arg-type]
    back = unwrap(wrap_up(PANORAMA, mirror, SIZE), mirror, PANORAMA.rig)
    difference = np.abs(back.image[3:-3].astype(float) - PANORAMA.image[3:-3])
    assert difference.mean() < 5.0


def test_a_bearing_lies_where_the_rig_says() -> None:
    image = np.zeros((100, 720, 3), np.uint8)
    image[:, 178:183] = 255  # a post to the left
    raw = wrap_up(Panorama(image), MIRROR, SIZE)
    angle = 0.8 - math.pi / 2  # counter-clockwise, and y runs down
    x, y = round(330 + 140 * math.cos(angle)), round(236 + 140 * math.sin(angle))
    assert raw[y, x, 0] > 200


@pytest.mark.parametrize("turn", ["clockwise", "counter-clockwise"])
def test_the_fit_finds_the_ring_and_its_direction(turn: str) -> None:
    truth = MirrorRig(331.0, 233.0, 58.0, 212.0, 2.1, turn)  # type: ignore[arg-type]
    found = fit_mirror(wrap_up(PANORAMA, truth, SIZE), PANORAMA)
    assert math.hypot(found.x - truth.x, found.y - truth.y) < 2.0
    assert found.inner == pytest.approx(truth.inner, abs=2.5)
    assert found.outer == pytest.approx(truth.outer, abs=2.5)
    assert found.turn == turn
    assert found.inner_is_floor
    assert abs(math.remainder(found.forward - truth.forward, TAU)) < math.radians(1.5)


def test_what_is_no_mirror_picture_is_refused() -> None:
    with pytest.raises(DataError):
        fit_mirror(np.full((100, 100, 3), 7, np.uint8))
    with pytest.raises(DataError):
        MirrorRig(5.0, 5.0, 4.0, 3.0)
    with pytest.raises(ShapeError):
        unwrap(np.zeros((10, 10), np.uint8), MIRROR, Rig())
