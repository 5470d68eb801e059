"""A camera's lean is found in single views, learnt over many, taken out, and left alone where there is none."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from sim2d import worlds
from sim2d.config import CameraConfig
from sim2d.sensors.camera import Camera
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision.tilt.lean import UPRIGHT, Lean
from topomap.vision.tilt.mount import FIRST, Mount
from topomap.vision.tilt.upright import upright
from topomap.vision.tilt.verticals import lean_of

ROOM = worlds.load("ourlab")
DEGREE = math.radians(1.0)


@cache
def view(roll: float, pitch: float, place: int = 0, width: int = 720, height: int = 100) -> Panorama:
    """What a camera that leans [degrees] sees at one of many places of `ourlab`."""
    camera = CameraConfig(
        noise=0, roll_deg=roll, pitch_deg=pitch, width=width, height=height, forward_column=width // 2
    )
    made = Camera(camera, np.random.default_rng(0))
    pose = (2.0 + 0.1 * (place % 12), 2.4 + 0.05 * (place % 7), 0.35 * place)
    image, _ = made.shoot(ROOM, *pose)
    return Panorama.from_recorded(image, made.rig)


@pytest.mark.parametrize(("roll", "pitch"), [(0.0, 0.0), (2.0, 0.0), (0.0, -3.0), (-1.0, 1.5)])
def test_one_view_tells_it(roll: float, pitch: float) -> None:
    said = lean_of(view(roll, pitch))
    assert said is not None
    assert math.degrees(said.lean.roll) == pytest.approx(roll, abs=0.15 + 0.15 * abs(roll))
    assert math.degrees(said.lean.pitch) == pytest.approx(pitch, abs=0.15 + 0.15 * abs(pitch))
    assert said.sigma < 0.5 * DEGREE


def test_it_is_told_in_any_size() -> None:
    said = lean_of(view(2.0, 0.0, width=1440, height=220))
    assert said is not None
    assert math.degrees(said.lean.roll) == pytest.approx(2.0, abs=0.4)


def test_taken_out_the_view_is_the_upright_cameras() -> None:
    stands, leans = view(0.0, 0.0), view(2.0, -1.0)
    back = upright(leans, Lean(2.0 * DEGREE, -1.0 * DEGREE))
    inner = slice(8, -8)  # what the leaning camera saw of them
    off, before = (np.abs(p.image[inner].astype(float) - stands.image[inner]).mean() for p in (back, leans))
    assert off < 0.4 * before
    rest = lean_of(back)
    assert rest is not None
    assert rest.lean.size < 0.3 * DEGREE


def test_nothing_upright_says_nothing() -> None:
    rng = np.random.default_rng(0)
    grey = np.full((100, 720, 3), 120, np.uint8)
    noise = np.clip(grey + rng.normal(0.0, 2.0, grey.shape), 0, 255).astype(np.uint8)
    stripes = grey.copy()
    stripes[::8] = 20  # level edges alone
    one = grey.copy()
    one[:, 100:103] = 0  # a single post tells one direction only
    for image in (grey, noise, stripes, one):
        assert lean_of(Panorama(image)) is None
    assert lean_of(Panorama(np.zeros((2, 8, 3), np.uint8), None, Rig(8, 2, 0.5, 8 / math.tau))) is None


def test_an_upright_camera_is_left_alone_to_the_bit() -> None:
    mount = Mount()
    for place in range(40):
        assert mount.see(view(0.0, 0.0, place)).lean == UPRIGHT
        assert not mount.restated
    assert mount.estimate is not None
    assert not mount.estimate.taken_out
    assert math.hypot(mount.estimate.roll, mount.estimate.pitch) < 0.2 * DEGREE
    whole = view(0.0, 0.0)
    assert upright(whole, UPRIGHT) is whole


def test_a_mount_is_found_within_its_sigma_and_said_again_seldom() -> None:
    mount, changes = Mount(), 0
    for place in range(40):
        mount.see(view(2.0, 1.0, place))
        changes += mount.restated
        assert mount.lean == UPRIGHT or place >= FIRST - 1
    found = mount.estimate
    assert found is not None
    assert found.taken_out
    assert found.sway == 0.0
    assert found.sigma < 0.6 * DEGREE
    assert math.hypot(found.roll - 2.0 * DEGREE, found.pitch - DEGREE) < 3.0 * found.sigma
    assert 1 <= changes <= 2


def test_a_leaning_world_is_not_a_leaning_camera() -> None:
    """Things that hang askew lean with the room: turned about, they say one thing and another."""
    mount = Mount()
    for place in range(80):
        mount.see(view(3.0, 0.0).rotated(math.tau * place / 20))
    found = mount.estimate
    assert found is not None
    assert found.sigma > 0.5 * DEGREE
    assert math.hypot(found.roll, found.pitch) < found.sigma
    assert mount.lean == UPRIGHT


def swaying() -> Iterator[tuple[Panorama, float]]:
    """Views of a camera under which the body leans to and fro in roll, and by how much [rad]."""
    for place in range(36):
        roll = round(2.0 * math.sin(1.7 * place), 1)
        yield view(roll, 0.0, place), roll * DEGREE


def test_a_body_that_sways_is_followed() -> None:
    mount, errors = Mount(every=1), []
    for place, (panorama, roll) in enumerate(swaying()):
        taken = mount.see(panorama)
        if place >= 20:
            errors.append(math.hypot(taken.lean.roll - roll, taken.lean.pitch))
    assert mount.estimate is not None
    assert mount.estimate.sway == pytest.approx(math.sqrt(2.0) * DEGREE, rel=0.7)
    assert np.median(errors) < 0.4 * DEGREE


def test_ranges_and_rig_stay() -> None:
    far = np.full(720, 2.0, np.float32)
    leaning = Panorama(view(2.0, 0.0).image, far)
    back = upright(leaning, Lean(2.0 * DEGREE))
    assert back.ranges is far
    assert back.rig == leaning.rig
    assert replace(Lean(0.1), pitch=0.2) - Lean(0.1) == Lean(0.0, 0.2)
