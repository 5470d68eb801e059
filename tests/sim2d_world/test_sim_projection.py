"""Tilted mounts, other fields of view, blur, and the raw mirror image."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim2d import worlds
from sim2d.config import CameraConfig
from sim2d.sensors.camera import Camera
from sim2d.sensors.mirror import MirrorRig, mirror_map, tilt_map
from sim2d.shapes import Cylinder, Ground, Look, Route, Spec, Wall, rectangle
from sim2d.streams import stream
from sim2d.world import World

RED, GREEN, GREY = (Look(c, "plain") for c in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.6, 0.6, 0.6)))


def camera(**settings: float | bool) -> Camera:
    return Camera(CameraConfig.model_validate({"noise": 0.0, **settings}), stream(0, "test"))


def pole_world(bearing: float) -> World:
    """A thin red pole as high as the eye, 3 m away, in a green room."""
    pole = Cylinder(3 * math.cos(bearing), 3 * math.sin(bearing), 0.05, 0.6, RED)
    wall = Wall((*rectangle(-9, -9, 9, 9), (-9, -9)), 2.6, GREEN)
    ground = Ground(GREY, 1.0)
    return World(Spec("pole", Route(((0, 0), (1, 0), (1, 1)), 1), ground, ground, 2.6, (wall,), (), (pole,)))


def top_of_pole(image: np.ndarray) -> tuple[float, float]:
    """Column and row of the highest red pixels."""
    red = (image[..., 0] > 100) & (image[..., 1] < 60)
    row = int(np.flatnonzero(red.any(axis=1))[0])
    return float(np.flatnonzero(red[row]).mean()), row - 0.5


@pytest.mark.parametrize("bearing_deg", [0.0, 40.0, 90.0, -130.0])
@pytest.mark.parametrize(("roll_deg", "pitch_deg"), [(5.0, 0.0), (0.0, 5.0), (-3.0, 4.0)])
def test_a_tilted_camera_sees_a_point_where_turning_its_ray_says(
    bearing_deg: float, roll_deg: float, pitch_deg: float
) -> None:
    """The pole's top lies at eye level in the direction d: in the camera's frame at R^T d."""
    bearing, roll, pitch = (math.radians(v) for v in (bearing_deg, roll_deg, pitch_deg))
    tilted = camera(roll_deg=roll_deg, pitch_deg=pitch_deg)
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    turn = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]]) @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    x, y, z = turn.T @ np.array([math.cos(bearing), math.sin(bearing), 0.0])
    rig = tilted.rig
    column = (rig.forward_column - math.atan2(y, x) * rig.focal) % rig.width
    row = rig.horizon_row - rig.focal * z / math.hypot(x, y)
    seen = top_of_pole(tilted.view(pole_world(bearing), 0.0, 0.0, 0.0))
    assert abs((seen[0] - column + 360) % 720 - 360) <= 2.0  # the pole is 4 pixels wide, and leans
    assert abs(seen[1] - row) <= 1.5


def test_leaning_forward_moves_what_is_ahead_up_and_leaning_right_what_is_left_down() -> None:
    """What lies ahead of a camera that looks down appears higher; left of one that leans right, lower."""
    rig = camera().rig
    _, ahead = tilt_map(rig, 0.0, 0.1)
    _, left = tilt_map(rig, 0.1, 0.0)
    middle = 49
    assert ahead[middle, 360] > 5  # the middle pixel ahead looks at what is below eye level
    assert left[middle, 180] < -5


def test_without_tilt_the_map_is_the_identity() -> None:
    rig = camera().rig
    columns, rows = tilt_map(rig, 0.0, 0.0)
    np.testing.assert_allclose(columns, np.tile(np.arange(720), (100, 1)), atol=1e-3)
    np.testing.assert_allclose(rows[:, 0], np.arange(100) - 49.5, atol=1e-4)


def test_another_vertical_field_shows_the_same_rows_in_between() -> None:
    world = worlds.load("room-corridor")
    tall = camera(height=160, horizon_row=99.5).view(world, 4.0, 1.2, 0.3)
    usual = camera().view(world, 4.0, 1.2, 0.3)
    np.testing.assert_array_equal(tall[50:150], usual)


def test_half_the_columns_are_every_second_direction() -> None:
    world = worlds.load("room-corridor")
    half = camera(width=360, height=50, forward_column=180).view(world, 4.0, 1.2, 0.3).astype(float)
    whole = camera().view(world, 4.0, 1.2, 0.3).astype(float)
    mean = whole.reshape(50, 2, 360, 2, 3).mean(axis=(1, 3))
    assert np.abs(half - np.roll(mean, 0, axis=1)).mean() < 8


def test_blur_keeps_the_mean_takes_the_edges_and_goes_round() -> None:
    world = worlds.load("room-corridor")
    sharp, soft = (camera(blur=b).view(world, 4.0, 1.2, 0.3).astype(float) for b in (0.0, 2.0))
    assert soft.mean() == pytest.approx(sharp.mean(), rel=0.01)
    assert np.abs(np.diff(soft, axis=1)).mean() < 0.6 * np.abs(np.diff(sharp, axis=1)).mean()
    seam = np.abs(soft[:, 0] - soft[:, -1]).mean()
    assert seam < 4 * np.abs(np.diff(soft, axis=1)).mean()


@pytest.mark.parametrize("clockwise", [False, True])
def test_the_mirror_image_can_be_unrolled_again(clockwise: bool) -> None:
    """Reading the ring back by its rig alone gives the panorama, but for the interpolation."""
    mirror = MirrorRig(900, 880, 452.0, 430.0, 120.0, 420.0, 0.7, clockwise)
    cam = camera()
    world = worlds.load("room-corridor")
    raw = cam.mirror_image(world, 4.0, 1.2, 0.3, mirror).astype(float)
    usual = cam.view(world, 4.0, 1.2, 0.3).astype(float)
    rows, columns = np.mgrid[2:98, :720]
    bearing = -(columns - 360) * math.tau / 720
    angle = mirror.forward_angle + (-bearing if clockwise else bearing)
    radius = mirror.outer_radius - rows / 99 * (mirror.outer_radius - mirror.inner_radius)
    x = np.rint(mirror.centre_x + radius * np.cos(angle)).astype(int)
    y = np.rint(mirror.centre_y - radius * np.sin(angle)).astype(int)
    assert np.median(np.abs(raw[y, x] - usual[2:98])) <= 3
    assert np.abs(raw[y, x] - usual[2:98]).mean() < 0.35 * np.abs(np.roll(usual, 20, axis=1) - usual).mean()


def test_outside_the_ring_the_mirror_image_is_black() -> None:
    _, _, seen = mirror_map(camera().rig, MirrorRig())
    raw = camera().mirror_image(worlds.load("room-corridor"), 4.0, 1.2, 0.0, MirrorRig())
    assert not raw[~seen].any()
    assert raw[seen].mean() > 30
    assert seen.mean() == pytest.approx(math.pi * (230**2 - 60**2) / 480**2, rel=0.01)
