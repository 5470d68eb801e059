"""The panorama's geometry, its rolling with the heading, and its bytes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim2d import worlds
from sim2d.config import CameraConfig, LaserConfig
from sim2d.path import of_route
from sim2d.sensors.camera import Camera, decode
from sim2d.sensors.laser import Laser
from sim2d.shapes import Box, Ground, Look, Route, Spec, Wall, rectangle
from sim2d.streams import stream
from sim2d.world import World

QUIET = CameraConfig(noise=0.0, codec="png")
RED, GREEN = Look((1.0, 0.0, 0.0), "plain"), Look((0.0, 1.0, 0.0), "plain")
BLUE, WHITE = Look((0.0, 0.0, 1.0), "plain"), Look((1.0, 1.0, 1.0), "plain")


def box_world(height: float, distance: float) -> World:
    """A red box straight ahead of the origin, in a green room, on a blue floor."""
    box = Box(rectangle(distance, -0.5, distance + 0.4, 0.5), height, RED)
    room = Wall((*rectangle(-9, -9, 9, 9), (-9, -9)), 9.0, GREEN)
    ring = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0))
    return World(Spec("box", Route(ring, 1), Ground(BLUE, 1.0), Ground(WHITE, 1.0), 9.0, (room,), (box,)))


def column(image: np.ndarray, c: int, channel: int) -> np.ndarray:
    """Rows of a column in which a channel is the strongest."""
    return np.flatnonzero(image[:, c].argmax(axis=1) == channel)


@pytest.mark.parametrize(("height", "distance"), [(0.9, 2.0), (1.3, 3.1), (0.75, 1.5), (2.0, 6.0)])
def test_rows_of_top_and_ground_line(height: float, distance: float) -> None:
    camera = Camera(QUIET, stream(0, "test"))
    red = column(camera.view(box_world(height, distance), 0.0, 0.0, 0.0), 360, 0)
    rig = camera.rig
    top = rig.horizon_row - rig.focal * (height - rig.camera_height) / distance
    ground = rig.horizon_row + rig.focal * rig.camera_height / distance
    assert abs(red.min() - 0.5 - top) <= 0.5
    assert abs(red.max() + 0.5 - ground) <= 0.5


def test_what_stands_behind_a_low_box_is_seen_above_it() -> None:
    camera = Camera(QUIET, stream(0, "test"))
    image = camera.view(box_world(0.3, 2.0), 0.0, 0.0, 0.0)
    rig = camera.rig
    far_edge = rig.horizon_row + rig.focal * (rig.camera_height - 0.3) / 2.4  # of the box's lid
    red, blue, green = (column(image, 360, k) for k in (0, 2, 1))
    assert abs(red.min() - 0.5 - far_edge) <= 0.5
    assert blue.min() < red.min() < blue.max()
    assert len(green) > 0
    assert green.max() < blue.min()


def test_left_is_left_and_up_is_up() -> None:
    camera = Camera(QUIET, stream(0, "test"))
    world = box_world(2.0, 2.0)
    # turned right by 90 degrees the box lies to the left: in a clockwise image a quarter turn before the nose
    image = camera.view(world, 0.0, 0.0, -math.pi / 2)
    assert len(column(image, 180, 0)) > 10
    assert len(column(image, 540, 0)) == 0
    other = Camera(CameraConfig(noise=0.0, clockwise=False, forward_column=0), stream(0, "test"))
    assert len(column(other.view(world, 0.0, 0.0, -math.pi / 2), 180, 0)) > 10


@pytest.mark.parametrize("name", ["hall", "office-loop", "room-corridor"])
@pytest.mark.parametrize("k", [1, 90, 331])
def test_turning_by_k_columns_rolls_by_k(name: str, k: int) -> None:
    world = worlds.load(name)
    path = of_route(world.spec.route)
    x, y = path.at(5.0)
    camera = Camera(QUIET, stream(0, "test"))
    laser = Laser(LaserConfig(), stream(0, "test"))
    turned = 0.3 + k * math.tau / 720
    same = np.roll(camera.view(world, x, y, 0.3), k, axis=1) == camera.view(world, x, y, turned)
    assert same.all(axis=2).mean() >= 0.999
    np.testing.assert_allclose(np.roll(laser.exact(world, x, y, 0.3), -k), laser.exact(world, x, y, turned), atol=1e-9)


def test_texture_does_not_swim() -> None:
    """Coming 5 cm closer changes a view little; a texture bound to the screen would not shift as the walls do."""
    world = worlds.load("room-corridor")
    camera = Camera(QUIET, stream(0, "test"))
    a, b, c = (camera.view(world, 4.0 + d, 1.2, 0.0).astype(float) for d in (0.0, 0.02, 1.0))
    assert np.abs(a - b).mean() < 0.35 * np.abs(a - c).mean()


@pytest.mark.parametrize("codec", ["jpeg", "png"])
def test_the_image_is_what_the_bytes_say(codec: str) -> None:
    config = CameraConfig.model_validate({"codec": codec})
    world = worlds.load("room-corridor")
    image, encoded = Camera(config, stream(3, "image noise")).shoot(world, 4.0, 1.2, 0.0)
    np.testing.assert_array_equal(image, decode(encoded))
    clean = Camera(QUIET, stream(0, "test")).view(world, 4.0, 1.2, 0.0).astype(float)
    assert 0.5 < np.abs(image - clean).mean() < 5.0
    if codec == "png":
        middle = (clean > 20) & (clean < 235)
        assert (image - clean)[middle].std() == pytest.approx(config.noise, rel=0.1)


def test_no_bytes_no_image() -> None:
    with pytest.raises(ValueError, match="JPEG"):
        decode(b"nothing")
