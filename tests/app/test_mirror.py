"""The simulator's raw mirror image and the stack's unwrapping: two packages, one picture."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim2d import worlds
from sim2d.config import CameraConfig
from sim2d.sensors.camera import Camera
from sim2d.sensors.mirror import MirrorRig as RawRig
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision.image.unwrap import MirrorRig, fit_mirror, unwrap

RAW = RawRig(width=900, height=900, centre_x=449.5, centre_y=449.5, inner_radius=150.0, outer_radius=440.0)


@pytest.fixture(scope="module")
def seen() -> tuple[np.ndarray, Panorama]:
    """The raw image and the panorama of one pose."""
    world, camera = worlds.load("ourlab"), Camera(CameraConfig(), np.random.default_rng(0))
    pose = (2.2, 2.6, 0.7)
    panorama = Panorama.from_recorded(camera.view(world, *pose), camera.rig)
    return camera.mirror_image(world, *pose, RAW), panorama


@pytest.mark.parametrize("fitted", [False, True])
def test_unwrapping_gives_the_panorama_back(seen: tuple[np.ndarray, Panorama], fitted: bool) -> None:
    raw, panorama = seen
    # the simulator counts the nose's direction counter-clockwise as it is looked at, unwrap from +x towards +y (down)
    known = MirrorRig(RAW.centre_x, RAW.centre_y, RAW.inner_radius, RAW.outer_radius, -math.pi / 2, "counter-clockwise")
    mirror = fit_mirror(raw, panorama) if fitted else known
    back = unwrap(raw, mirror, Rig())
    error = np.abs(back.image.astype(float) - panorama.image).mean()
    turned = np.abs(back.rolled(20).image.astype(float) - panorama.image).mean()
    assert error < (6.0 if not fitted else 10.0)
    assert turned > 2.5 * error, "the picture is rich enough for a turn of 10 degrees to show"
