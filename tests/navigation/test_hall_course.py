"""The mission in the hall: the course, where home is noticed, and the way there, in a room of pillars."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from kept import as_before

from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, Command, HomeVector, Phase, Travel
from topomap.experiments.pillars import Pillar, Room, painted
from topomap.navigation.manoeuvres.hall_course import HallCourse, HallSettings
from topomap.navigation.pilot import Pilot, PilotSettings
from topomap.vision.aligned_homing import AlignedHoming
from topomap.vision.registry import aligned_homing

DT = 0.25
SETTINGS = HallSettings(ahead=3.0, behind=2.0, width=3.0)


def room(seed: int = 0) -> Room:
    rng = np.random.default_rng(seed)
    angles, reach = np.arange(9) * math.tau / 9 + rng.uniform(-0.2, 0.2, 9), rng.uniform(4.5, 6.5, 9)
    colours = rng.integers(20, 250, (9, 3)).tolist()
    pillars = [
        Pillar(1.5 + r * math.cos(a), 1.5 + r * math.sin(a), 0.4, (int(c[0]), int(c[1]), int(c[2])))
        for a, r, c in zip(angles, reach, colours, strict=True)
    ]
    return Room(pillars, 9.0, painted(rng))


class Ride:
    """A robot in the room whose odometer reads `scale` of its turns."""

    def __init__(self, course: HallCourse, scale: float = 1.0, seen: Room | None = None) -> None:
        self.course, self.scale, self.room = course, scale, seen or room()
        self.true = self.read = Pose2()
        self.path: list[tuple[float, float]] = []

    def view(self) -> Panorama:
        return self.room.view(self.true.x, self.true.y, self.true.heading)

    def go(self, most: int = 700) -> Travel:
        for _ in range(most):
            self.path.append((self.true.x, self.true.y))
            command, travel = self.course.step(self.view(), self.read, self.read)
            if travel.phase in (Phase.ARRIVED, Phase.FAILED):
                return travel
            self.true, self.read = moved(self.true, command), moved(self.read, command, self.scale)
        raise AssertionError("the mission doesn't end")


def moved(pose: Pose2, command: Command, scale: float = 1.0) -> Pose2:
    way, turn = command.forward * DT, command.turn * DT * scale
    return pose @ Pose2(way * math.cos(turn / 2), way * math.sin(turn / 2), turn)


def course(equalise: bool = False, homing: str = "area-centroid") -> HallCourse:
    settings = SETTINGS.model_copy(update={"equalise": equalise})
    return HallCourse(settings, Pilot(PilotSettings()), aligned_homing(homing, "visual-compass"))


@pytest.mark.parametrize("equalise", [False, True])
def test_it_drives_the_rectangle_notices_home_and_gets_there(equalise: bool) -> None:
    ride = Ride(course(equalise), 1.01)
    travel = ride.go()
    path = np.array(ride.path)
    assert path[:, 0].max() > 2.0
    assert path[:, 1].max() > 2.0
    assert ride.course.homing_from is not None
    assert math.dist(path[ride.course.homing_from], (0.0, 0.0)) < 1.5
    assert travel.phase is Phase.ARRIVED
    assert math.dist(path[-1], (0.0, 0.0)) < 0.3
    seen = ride.course.differences
    name = f"hall course {equalise}"
    as_before(name, {"path": path[::4], "from": [ride.course.homing_from]}, part=True)
    # the painted walls' edges fall on other pixels elsewhere
    as_before(name, {"differences": seen}, part=True, close=0.1)


def test_where_home_is_never_passed_it_says_so() -> None:
    class Elsewhere(Room):
        """Looks otherwise once home has been left."""

        def view(self, x: float, y: float, heading: float) -> Panorama:
            return room(0 if math.hypot(x, y) < 0.3 and not ride.path[5:] else 7).view(x, y, heading)

    ride = Ride(course(), 1.0, Elsewhere(room().pillars, 9.0, room().paint))
    travel = ride.go()
    assert travel.phase is Phase.FAILED
    assert "home wasn't noticed" in travel.note


def test_another_method_ends_the_same_course() -> None:
    ride = Ride(course())
    while ride.course.homing_from is None:
        command, _ = ride.course.step(ride.view(), ride.read, ride.read)
        ride.true, ride.read = moved(ride.true, command), moved(ride.read, command)
    seen = len(ride.course.differences)
    other = Ride(ride.course.homing_by(aligned_homing("run-down", "visual-compass")))
    other.true, other.read = ride.true, ride.read
    assert other.go().phase in (Phase.ARRIVED, Phase.FAILED)
    assert len(ride.course.differences) == seen, "the course stays as it was"


class Leads:
    """A method that leads to a spot (x, y) [m] and says at last that home lies `aside` [rad] of the nose."""

    policy: object = None

    def __init__(self, ride: Ride, to: tuple[float, float], aside: float | None = None) -> None:
        self.ride, self.to, self.aside = ride, to, aside

    def align(self, panorama: Panorama, home: Panorama, rotation: float | None) -> Alignment:
        here = self.ride.true
        there = math.dist((here.x, here.y), self.to) < 0.06
        bearing = self.aside if there and self.aside else here.bearing_to(Pose2(*self.to, 0.0))
        return Alignment(rotation=here.heading, residual=0.1, home=HomeVector(bearing, None, 1.0))


class Wanders(Leads):
    """A policy that goes by home, 0.12 m off, and stays half a metre behind it."""

    policy = SimpleNamespace(start=lambda goal: 0)

    def move(self, state: int, panorama: Panorama, rotation: float) -> tuple[int, HomeVector]:
        here, to = self.ride.true, Pose2(*[(0.3, 0.12), (0.0, 0.12), (-0.5, 0.12)][min(state, 2)], 0.0)
        way = min(here.distance(to), 0.3)
        return state + (way < 0.3), HomeVector(here.bearing_to(to), way, 1.0)


def led(kind: type[Leads], to: tuple[float, float] = (0.0, 0.0), aside: float | None = None) -> tuple[Travel, float]:
    """Return how a mission ends that a method leads, and how far from home [m]."""
    ride = Ride(course())
    while ride.course.homing_from is None:
        command, _ = ride.course.step(ride.view(), ride.read, ride.read)
        ride.true, ride.read = moved(ride.true, command), moved(ride.read, command)
    ride.course = ride.course.homing_by(cast(AlignedHoming, kind(ride, to, aside)))
    return ride.go(), math.hypot(ride.true.x, ride.true.y)


def test_beside_home_it_has_not_arrived() -> None:
    for to in ((0.05, 0.45), (0.4, -0.35), (0.0, 0.4)):
        travel, off = led(Leads, to)
        assert travel.phase is Phase.FAILED, (to, off)


def test_who_was_near_home_and_stands_elsewhere_has_not_arrived() -> None:
    travel, off = led(Wanders)
    assert travel.phase is Phase.FAILED or off < 0.3, off


def test_at_home_it_has_arrived_wherever_the_home_vector_points() -> None:
    travel, off = led(Leads, aside=2.5)
    assert travel.phase is Phase.ARRIVED
    assert off < 0.12
