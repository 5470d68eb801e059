"""People, doors and moved things: seen, measured, bumped into, and no part of anybody's dice."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pymunk
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim2d import worlds
from sim2d.body import Body
from sim2d.changes import Changes, middle, moved
from sim2d.config import BodyConfig, CameraConfig, SimConfig
from sim2d.errors import WorldError
from sim2d.render.raycast import cast
from sim2d.robot import SimRobot
from sim2d.sensors.camera import Camera
from sim2d.shapes import Box, Change, Cylinder, Gate, Ground, Look, Person, Route, Spec, Wall, rectangle
from sim2d.streams import stream
from sim2d.world import STATIC, World

GREY = Look((0.5, 0.5, 0.5), "plain")
SMALL = {"camera": {"width": 72, "height": 20, "forward_column": 36}, "laser": {"rays": 36}}
NOBODY = (-50.0, 0.0, 0.2)


def room(people: tuple[Person, ...] = (), changes: tuple[Change, ...] = ()) -> World:
    """A room of 10 x 10 m with a box, a bin and a door on its own."""
    wall = Wall((*rectangle(-5, -5, 5, 5), (-5, -5)), 2.6, GREY)
    ground = Ground(GREY, 1.0)
    box, bin_ = Box(rectangle(-3, 2, -2, 2.5), 1.0, GREY, "box"), Cylinder(3, 3, 0.3, 0.9, GREY, "bin")
    door = Gate((3.0, -1.0), (3.0, 1.0), 2.1, GREY, opens_at=0.5, name="door", closes_s=90.0)
    route = Route(((0, 0), (2, 0), (2, 2)), 1)
    return World(
        Spec("room", route, ground, ground, 2.6, (wall,), (box,), (bin_,), (door,), people=people, changes=changes)
    )


def ahead(world: World) -> float:
    return float(cast(world.scene(), 0.0, 0.0, np.zeros(1), 30.0)[0])


def test_somebody_in_the_way_is_measured_seen_and_gone_again() -> None:
    world = room((Person("p", ((2.0, 0.0), (2.0, 3.0)), speed=1.0, radius=0.25),))
    camera = Camera(CameraConfig(noise=0.0), stream(0, "test"))
    assert ahead(world) == pytest.approx(1.75)
    with_somebody = camera.view(world, 0.0, 0.0, 0.0)
    grid = world.scene().items
    for k in range(4):
        world.people.start(k * 0.5, 0.5, NOBODY)
    assert ahead(world) == pytest.approx(3.0)
    assert world.scene().items is grid  # nothing was laid anew for the one who walked
    without = camera.view(world, 0.0, 0.0, 0.0)
    middle_differs = np.abs(with_somebody.astype(int) - without)[:, 350:370].mean()
    beside_differs = np.abs(with_somebody.astype(int) - without)[:, 400:700].mean()
    assert middle_differs > 10 > beside_differs == 0


def test_people_walk_to_and_fro_at_their_speed() -> None:
    world = room((Person("p", ((2.0, 0.0), (2.0, 1.0), (3.0, 1.0)), speed=0.5, start_s=1.0),))
    walker = world.people.walkers[0]
    places = []
    for k in range(40):
        world.people.start(k * 0.25, 0.25, NOBODY)
        world.space.step(0.25)
        places.append((walker.x, walker.y))
    assert places[3] == (2.0, 0.0)
    assert places[11] == pytest.approx((2.0, 1.0))
    assert places[19] == pytest.approx((3.0, 1.0))
    assert places[23] == pytest.approx((2.5, 1.0))
    assert math.dist(walker._body.position, places[-1]) < 1e-9


def test_people_block_the_robot_and_wait_for_it() -> None:
    world = room((Person("p", ((1.0, 0.0), (-3.0, 0.0)), speed=0.5),))
    body, walker = Body(world, BodyConfig(), 0.0, 0.0, 0.0), world.people.walkers[0]
    for k in range(20):
        world.people.start(k * 0.25, 0.25, (body.x, body.y, body.radius))
        body.advance(0.0, 0.0, 0.25)
    assert math.hypot(body.x, body.y) < 1e-9  # nobody pushes it
    assert walker.x == pytest.approx(0.2 + 0.25 + 0.1, abs=0.13)
    for _ in range(8):
        body.advance(0.4, 0.0, 0.25)
    assert body.contact
    assert body.x <= walker.x - 0.44


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_ranges_equal_pymunk_with_people_on_their_way(seed: int) -> None:
    rng = np.random.default_rng(seed)
    people = tuple(
        Person(str(k), tuple(map(tuple, rng.uniform(-4.5, 4.5, (3, 2)))), radius=float(rng.uniform(0.1, 0.5)))
        for k in range(5)
    )
    world = room(people)
    for k in range(int(rng.integers(0, 12))):
        world.people.start(k * 0.25, 0.25, NOBODY)
        world.space.step(0.25)
    angles = rng.uniform(-math.pi, math.pi, 60)
    x, y = (float(v) for v in rng.uniform(-4.5, 4.5, 2))
    inside = world.space.point_query_nearest((x, y), 0.0, pymunk.ShapeFilter(mask=STATIC))
    if inside is not None and inside.distance < 1e-6:
        return
    ours = cast(world.scene(), x, y, angles, 30.0)
    for angle, our in zip(angles, ours, strict=True):
        end = (x + 30 * math.cos(angle), y + 30 * math.sin(angle))
        hit = world.space.segment_query_first((x, y), end, 0.0, pymunk.ShapeFilter(mask=STATIC))
        assert hit is not None
        assert our == pytest.approx(hit.alpha * 30, abs=1e-6)


def test_more_people_change_nobody_elses_dice() -> None:
    def run(count: int) -> list[tuple[float, float, float]]:
        config = SimConfig.model_validate(SMALL | {"people": {"extra": count}})
        robot = SimRobot(worlds.load("hall"), config, 7)
        return [(r.motion.forward, r.motion.turn, robot.truth().x) for _ in range(12) if (r := robot.sense())]

    def first_walker(count: int) -> Person:
        robot = SimRobot(worlds.load("hall"), SimConfig.model_validate({"people": {"extra": count}}), 7)
        return robot.world.people.walkers[0].person

    assert run(0) == run(3)
    assert first_walker(1) == first_walker(6)


def test_a_crowd_is_seen_and_the_same_seed_gives_the_same_bytes() -> None:
    def run(extra: int) -> list[bytes]:
        robot = SimRobot(worlds.load("hall"), SimConfig.model_validate(SMALL | {"people": {"extra": extra}}), 3)
        return [r.encoded for _ in range(6) if (r := robot.sense())]

    assert run(30) == run(30)
    assert run(30) != run(0)


def test_somebody_without_a_way_is_refused() -> None:
    with pytest.raises(WorldError, match="two points"):
        room((Person("p", ((1.0, 1.0),)),))


def test_a_door_opens_by_laps_and_closes_by_a_change() -> None:
    world = room(changes=(Change("door", at_s=9.0, opens=False), Change("door", at_s=20.0, opens=True)))
    changes = Changes(world)
    seen = []
    for laps, seconds in ((0.1, 1.0), (0.6, 5.0), (0.7, 9.0), (0.8, 10.0), (0.9, 21.0)):
        changes.update(laps, seconds, 0.0, NOBODY)
        seen.append(ahead(world))
    assert seen == pytest.approx([3.0, 5.0, 3.0, 3.0, 5.0])


def test_things_move_between_laps_but_not_onto_the_robot() -> None:
    world = room(
        changes=(
            Change("box", at_lap=1.0, moves_to=(1.5, 0.0), turn=math.pi / 2),
            Change("bin", at_lap=1.0, moves_to=(0.0, -2.0)),
        )
    )
    world.set_gate("door", True)
    changes = Changes(world)
    changes.update(0.9, 0.0, 0.0, NOBODY)
    assert ahead(world) == pytest.approx(5.0)
    changes.update(1.0, 0.0, 0.0, (1.4, 0.0, 0.2))
    assert ahead(world) == pytest.approx(5.0)  # the robot stands where the box shall go
    changes.update(1.1, 0.0, 0.0, NOBODY)
    assert ahead(world) == pytest.approx(1.25)  # a metre wide before, half a metre deep now
    right = cast(world.scene(), 0.0, 0.0, np.array([-math.pi / 2]), 30.0)[0]
    assert right == pytest.approx(1.7)
    hit = world.space.point_query_nearest((0.0, -2.0), 0.0, pymunk.ShapeFilter(mask=STATIC))
    assert hit is not None
    assert hit.distance < 0


def test_a_moved_box_keeps_its_size() -> None:
    box = Box(rectangle(0, 0, 2, 1), 1.0, GREY, "box")
    there = moved(box, (5.0, 5.0), 0.7)
    assert isinstance(there, Box)
    assert middle(there) == pytest.approx((5.0, 5.0))
    assert math.dist(there.points[0], there.points[2]) == pytest.approx(math.sqrt(5))
    assert replace(there, points=box.points) == box
