"""The batch ray cast against pymunk's own query, ray by ray."""

from __future__ import annotations

import math

import numpy as np
import pymunk
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sim2d import worlds
from sim2d.render.raycast import cast
from sim2d.shapes import Box, Cylinder, Gate, Ground, Look, Route, Spec, Wall
from sim2d.world import STATIC, World

GREY = Look((0.5, 0.5, 0.5), "plain")
REACH = 30.0


def world_of(walls=(), boxes=(), cylinders=(), gates=()) -> World:
    ground = Ground(GREY, tile=1.0)
    route = Route(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)), laps=1)
    return World(Spec("test", route, ground, ground, 2.6, tuple(walls), tuple(boxes), tuple(cylinders), tuple(gates)))


def pymunk_ranges(world: World, x: float, y: float, angles) -> np.ndarray:
    only_static = pymunk.ShapeFilter(mask=STATIC)
    out = np.full(len(angles), np.nan)
    for k, angle in enumerate(angles):
        end = (x + REACH * math.cos(angle), y + REACH * math.sin(angle))
        hit = world.space.segment_query_first((x, y), end, 0.0, only_static)
        if hit is not None:
            out[k] = hit.alpha * REACH
    return out


def random_world(rng: np.random.Generator) -> World:
    walls, boxes, cylinders = [], [], []
    for _ in range(int(rng.integers(0, 12))):
        walls.append(Wall(tuple(map(tuple, rng.uniform(-9, 9, (int(rng.integers(2, 5)), 2)))), 2.0, GREY))
    for _ in range(int(rng.integers(0, 6))):
        centre, size = rng.uniform(-9, 9, 2), rng.uniform(0.1, 2)
        corners = np.sort(rng.uniform(0, math.tau, int(rng.integers(3, 7))))
        if np.diff(corners, append=corners[0] + math.tau).min() > 0.1:
            ring = centre + size * np.stack([np.cos(corners), np.sin(corners)], axis=-1)
            boxes.append(Box(tuple(map(tuple, ring)), 2.0, GREY))
    for _ in range(int(rng.integers(0, 6))):
        cylinders.append(Cylinder(*map(float, rng.uniform(-9, 9, 2)), float(rng.uniform(0.05, 1)), 2.0, GREY))
    return world_of(walls, boxes, cylinders)


def is_inside(world: World, x: float, y: float) -> bool:
    """Inside a solid the two disagree by definition: pymunk reports no exits, and a robot is never there."""
    near = world.space.point_query_nearest((x, y), 0.0, pymunk.ShapeFilter(mask=STATIC))
    return near is not None and near.distance < 1e-6


def test_the_share_of_grazing_rays_is_tiny() -> None:
    """Of thousands of random rays hardly any meets a corner so closely that the two disagree."""
    rays = differing = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        world = random_world(rng)
        x, y = (float(v) for v in rng.uniform(-10, 10, 2))
        if not is_inside(world, x, y):
            angles = rng.uniform(-math.pi, math.pi, 200)
            ours, theirs = cast(world.scene(), x, y, angles, REACH), pymunk_ranges(world, x, y, angles)
            differing += int((~np.isclose(ours, theirs, rtol=0, atol=1e-6, equal_nan=True)).sum())
            rays += len(angles)
    print(f"grazing rays: {differing} of {rays}")
    assert rays > 4000
    assert differing <= 1e-3 * rays


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.integers(0, 2**32 - 1))
def test_ranges_equal_pymunk(seed: int) -> None:
    rng = np.random.default_rng(seed)
    world = random_world(rng)
    x, y = (float(v) for v in rng.uniform(-10, 10, 2))
    if is_inside(world, x, y):
        return
    angles = rng.uniform(-math.pi, math.pi, 90)
    ours, theirs = cast(world.scene(), x, y, angles, REACH), pymunk_ranges(world, x, y, angles)
    # a ray that grazes a corner may pass it on either side
    differs = ~np.isclose(ours, theirs, rtol=0, atol=1e-6, equal_nan=True)
    assert differs.sum() <= 1, (ours[differs], theirs[differs])


@pytest.mark.parametrize("angle", [0.0, math.pi / 2, math.pi, -math.pi / 2])
def test_rays_along_the_grid(angle: float) -> None:
    world = world_of([Wall(((-4, -4), (4, -4), (4, 4), (-4, 4), (-4, -4)), 2.0, GREY)])
    assert cast(world.scene(), 0.0, 0.0, np.array([angle]), REACH)[0] == pytest.approx(4.0, abs=1e-9)


def test_an_empty_world_returns_nothing() -> None:
    assert np.isnan(cast(world_of().scene(), 0.3, 0.4, np.linspace(0, 6, 20), REACH)).all()


def test_opening_the_gate_lets_rays_through() -> None:
    world = world_of(
        [Wall(((5, -2), (5, 2)), 2.0, GREY)], gates=[Gate((2.0, -1.0), (2.0, 1.0), 2.0, GREY, opens_at=1.5)]
    )
    ahead = np.zeros(1)
    assert cast(world.scene(), 0.0, 0.0, ahead, REACH)[0] == pytest.approx(2.0)
    assert not world.open_gates(1.4)
    assert world.open_gates(1.5)
    assert cast(world.scene(), 0.0, 0.0, ahead, REACH)[0] == pytest.approx(5.0)


@pytest.mark.parametrize("name", ["hall", "office-loop", "room-corridor"])
def test_no_ray_escapes_a_named_world(name: str) -> None:
    world = worlds.load(name)
    x, y = world.spec.route.ring[0]
    angles = np.linspace(-math.pi, math.pi, 720)
    ours = cast(world.scene(), x, y, angles, 200.0)
    assert np.isfinite(ours).all()
    near = ours < REACH
    np.testing.assert_allclose(ours[near], pymunk_ranges(world, x, y, angles)[near], atol=1e-6)
