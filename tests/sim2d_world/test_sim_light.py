"""Light by the hour, exposure, and what the default keeps."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from pydantic import ValidationError

from sim2d.config import CameraConfig, SimConfig
from sim2d.render.hours import lamp_level, sky_level, sun
from sim2d.robot import SimRobot
from sim2d.sensors.camera import Camera
from sim2d.shapes import Decal, Ground, Light, Look, Route, Spec, Wall
from sim2d.streams import stream
from sim2d.world import World

GREY = (0.5, 0.5, 0.5)
SMALL = {"width": 180, "height": 40, "forward_column": 90, "noise": 0.0}


def room(*lights: Light, gloss: float = 0.0, lamps: float = 3.0, inner: tuple[Wall, ...] = ()) -> World:
    """A grey room of 8 x 6 m with a window in its southern wall and a partition-free floor."""
    window = Decal("window", 3.0, 2.0, 0.5, 2.2, (0.9, 0.9, 0.9), 1)
    corners = ((0.0, 0.0), (8.0, 0.0), (8.0, 6.0), (0.0, 6.0), (0.0, 0.0))
    walls = tuple(
        Wall((a, b), 2.6, Look(GREY, "plain", 0, (window,) if k == 0 else ()))
        for k, (a, b) in enumerate(pairwise(corners))
    )
    ground = Ground(Look(GREY, "plain"), 3.0, gloss)
    ceiling = Ground(Look(GREY, "plain"), 3.0, lamps=lamps, first_lamp=0.0)
    route = Route(((2.0, 3.0), (6.0, 3.0), (6.0, 4.0)), 1)
    return World(Spec("room", route, ground, ceiling, 2.6, (*walls, *inner), lights=lights))


def view(world: World, x: float = 4.0, y: float = 3.0, **settings: float | str) -> np.ndarray:
    return Camera(CameraConfig.model_validate(SMALL | settings), stream(0, "test")).view(world, x, y, 0.0).astype(float)


def test_windows_shine_by_day_and_are_black_at_night() -> None:
    world = room()
    day, night, even = view(world, hour=14), view(world, hour=24), view(world)
    panes = (slice(12, 18), slice(130, 140))  # to the right of the nose, above eye level
    assert np.median(day[panes]) > 1.3 * np.median(even[panes])
    assert np.median(night[panes]) < 0.1 * np.median(even[panes])


def test_the_light_comes_back_as_it_was() -> None:
    world = room()
    before = view(world)
    for hour in (6.0, 14.0, 20.0):
        assert np.abs(view(world, hour=hour) - before).mean() > 2
    np.testing.assert_array_equal(view(world), before)


def test_by_day_it_is_brighter_near_the_window_and_at_night_it_is_not() -> None:
    """The floor below the window against the floor at the far wall."""
    world = room()

    def ratio(hour: float) -> float:
        near, far = view(world, 4.0, 1.5, hour=hour), view(world, 4.0, 4.5, hour=hour)
        return float(near[32:].mean() / far[32:].mean())

    assert ratio(14.0) > 1.25 * ratio(24.0)


def test_a_wall_keeps_a_lamp_from_the_other_side() -> None:
    lamp = Light(1.0, 3.0, 2.5)
    free, split = (room(lamp, lamps=0.0, inner=walls) for walls in ((), (_partition(),)))
    assert view(split, 6.0, 3.0, hour=24)[30:].mean() < 0.8 * view(free, 6.0, 3.0, hour=24)[30:].mean()


def _partition() -> Wall:
    return Wall(((4.0, 0.0), (4.0, 6.0)), 2.6, Look(GREY, "plain"))


def test_the_sun_falls_through_the_window_at_noon_from_the_south() -> None:
    world = room(lamps=0.0)
    camera = Camera(CameraConfig(hour=13.0), stream(0, "test"))
    camera.view(world, 4.0, 3.0, 0.0)
    glow = world.daylight.glow
    patch = glow.field[int((1.2 - glow.y) / glow.cell), int((4.0 - glow.x) / glow.cell), 0]
    beside = glow.field[int((1.2 - glow.y) / glow.cell), int((2.0 - glow.x) / glow.cell), 0]
    assert patch > beside + 0.3


def test_hours() -> None:
    assert sky_level(14) > sky_level(6) > sky_level(20) > sky_level(24) == 0.0
    assert lamp_level(24) > lamp_level(14)
    assert sun(3.0)[1] == sun(22.0)[1] == 0.0
    azimuth, height = sun(13.0)
    assert azimuth == pytest.approx(-math.pi / 2)
    assert height == pytest.approx(math.radians(55))


def test_a_polished_floor_mirrors_the_wall_and_a_dull_one_does_not() -> None:
    red = Wall(((6.0, 1.0), (6.0, 5.0)), 2.6, Look((1.0, 0.0, 0.0), "plain"))
    dull, polished = (view(room(gloss=gloss, inner=(red,))) for gloss in (0.0, 0.4))
    below = (slice(30, 40), slice(85, 95))
    assert polished[below][..., 0].mean() > polished[below][..., 1].mean() + 15
    assert dull[below][..., 0].mean() == pytest.approx(dull[below][..., 1].mean(), abs=1)


@pytest.mark.parametrize("hour", [None, 6.0, 14.0, 24.0])
def test_automatic_exposure_meets_its_target(hour: float | None) -> None:
    world = room()
    config = CameraConfig.model_validate(SMALL | {"exposure": "auto", "hour": hour})
    assert Camera(config, stream(0, "test")).view(world, 4.0, 3.0, 0.0).mean() == pytest.approx(110, rel=0.12)


def test_gain_brightens() -> None:
    world = room()
    plain, bright = view(world), view(world, gain=1.5)
    unsaturated = plain < 160
    np.testing.assert_allclose(bright[unsaturated], 1.5 * plain[unsaturated], atol=1.3)


def test_the_light_changes_in_mid_run() -> None:
    def images(*changes: dict[str, float]) -> list[bytes]:
        camera = SMALL | {"hour": 14, "light_changes": changes}
        robot = SimRobot(room(), SimConfig.model_validate({"camera": camera, "laser": {"rays": 9}}), 0)
        return [reading.encoded for _ in range(8) if (reading := robot.sense()) is not None]

    same = [a == b for a, b in zip(images(), images({"hour": 24, "at_s": 1.0}), strict=True)]
    assert same == [True] * 5 + [False] * 3


def test_a_light_change_has_one_moment() -> None:
    with pytest.raises(ValidationError, match="at_s or at_lap"):
        CameraConfig.model_validate({"light_changes": [{"hour": 3}]})
