"""One faulty driver for each line that `check_robot` can say, and drivers it has nothing to say about."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from kept import as_before
from played import Played

import topomap
from sim2d import worlds
from sim2d.records import SimReading
from sim2d.robot import SimRobot
from topomap.app.config import load_config
from topomap.core.records import Command
from topomap.navigation.robot_check.numbers import check_stamps

DEN = str(Path(__file__).parents[1] / "helpers" / "den.toml")
Change = Callable[[SimReading, int], object]


def robot(world: str = DEN, *settings: str, seed: int = 0) -> SimRobot:
    return SimRobot(worlds.load(world), load_config(None, settings).sim, seed)


@pytest.fixture(scope="module")
def readings() -> list[SimReading]:
    source = robot()
    return [reading for _ in range(120) if (reading := source.sense()) is not None]


@dataclass
class Faulty:
    """A driver that hands over what `change` makes of each reading."""

    readings: list[SimReading]
    change: Change
    stopped: bool = False

    def __post_init__(self) -> None:
        self._left = iter(range(len(self.readings)))

    def sense(self) -> object:
        k = next(self._left, None)
        return None if k is None else self.change(self.readings[k], k)

    def act(self, command: Command) -> None:
        pass

    def stop(self) -> None:
        self.stopped = True


def motion(**values: object) -> Change:
    return lambda r, _: replace(r, motion=replace(r.motion, **values))


def scaled(name: str, factor: float) -> Change:
    return lambda r, _: replace(r, motion=replace(r.motion, **{name: factor * getattr(r.motion, name)}))


def rig(**values: object) -> Change:
    return lambda r, _: replace(r, rig=replace(r.rig, **values))


def stamps(stamp: Callable[[int, int], object]) -> Change:
    return lambda r, k: replace(r, stamp_ns=stamp(r.stamp_ns, k))


def ranges(change: Callable[[np.ndarray], object]) -> Change:
    return lambda r, _: replace(r, ranges=change(r.ranges))


def png(image: np.ndarray) -> bytes:
    return cv2.imencode(".png", image[:, :, ::-1])[1].tobytes()


def without(name: str) -> Change:
    fields = ("stamp_ns", "image", "encoded", "ranges", "motion", "rig", "contact", "driven")
    return lambda r, _: SimpleNamespace(**{field: getattr(r, field) for field in fields if field != name})


def holed(r: SimReading, value: float) -> np.ndarray:
    return np.where(np.arange(len(r)) < 9, np.float32(value), r)


SKEW = np.diag([1e-4, 1e-4, 1e-4]) + np.array([[0, 1e-5, 0], [0, 0, 0], [0, 0, 0]])

FAULTS: dict[str, tuple[Change, str, str]] = {
    "columns run the other way": (rig(clockwise=False, forward_column=359), "rig.clockwise", "rolls the other way"),
    "nose behind": (rig(forward_column=0), "rig.forward_column", "out of about column"),
    "nose aside": (rig(forward_column=180), "rig.forward_column", "out of about column"),
    "turns clockwise": (scaled("turn", -1.0), "motion.turn", "counts clockwise"),
    "turns in degrees": (scaled("turn", 180 / math.pi), "motion.turn", "degrees"),
    "turns half": (scaled("turn", 0.4), "motion.turn", "times what the picture turns"),
    "turns unrelated": (lambda r, k: motion(turn=0.1 * math.sin(k))(r, k), "motion.turn", "doesn't follow"),
    "way in millimetres": (scaled("forward", 1000.0), "motion.forward", "millimetres"),
    "way aside in millimetres": (motion(left=90.0), "motion.left", "millimetres"),
    "way NaN": (motion(forward=math.nan), "motion.forward", "finite number"),
    "dt in milliseconds": (scaled("dt", 1e3), "motion.dt", "seconds since the reading before"),
    "stamps in seconds": (stamps(lambda t, _: t / 1e9), "stamp_ns", "counts seconds"),
    "stamps in whole seconds": (stamps(lambda t, _: t // 10**9), "stamp_ns", "counts seconds"),
    "stamps in milliseconds": (stamps(lambda t, _: t // 10**6), "stamp_ns", "counts milliseconds"),
    "stamps as floats": (stamps(lambda t, _: float(t)), "stamp_ns", "must be an int"),
    "stamp repeated": (stamps(lambda t, k: t - (250_000_000 if k == 7 else 0)), "stamp_ns", "is repeated"),
    "stamp backwards": (stamps(lambda t, k: t - (900_000_000 if k == 7 else 0)), "stamp_ns", "goes backwards"),
    "image smaller": (lambda r, _: replace(r, image=r.image[:, 1:], encoded=png(r.image[:, 1:])), "image",
                      "the rig says"),
    "image of floats": (lambda r, _: replace(r, image=r.image / 255.0), "image", "must be a uint8"),
    "image a list": (lambda r, _: replace(r, image=r.image.tolist()), "image", "must be a uint8"),
    "bytes no image": (lambda r, _: replace(r, encoded=b"\xff\xd8 not much"), "encoded", "can't be decoded"),
    "bytes missing": (lambda r, _: replace(r, encoded=b""), "encoded", "can't be decoded"),
    "bytes of another size": (lambda r, _: replace(r, encoded=png(r.image[:50])), "encoded", "decodes to (50,"),
    "bytes before compression": (lambda r, _: replace(r, image=r.image ^ 1), "encoded", "another image"),
    "red and blue swapped": (lambda r, _: replace(r, image=r.image[:, :, ::-1].copy()), "encoded", "red and blue"),
    "ranges too few": (ranges(lambda r: r[:360]), "ranges", "one ray a column"),
    "ranges a list": (ranges(lambda r: r.tolist()), "ranges", "one ray a column"),
    "ranges doubles": (ranges(lambda r: r.astype(float)), "ranges", "must be float32"),
    "ranges in millimetres": (ranges(lambda r: 1000 * r), "ranges", "millimetres"),
    "no echo as zero": (ranges(lambda r: holed(r, 0.0)), "ranges", "must be NaN"),
    "no echo as infinity": (ranges(lambda r: holed(r, math.inf)), "ranges", "must be NaN"),
    "ranges clockwise": (ranges(lambda r: np.roll(r[::-1], 1)), "ranges", "run clockwise"),
    "covariance zero": (motion(covariance=np.zeros((3, 3))), "motion.covariance", "all zeros"),
    "covariance skew": (motion(covariance=SKEW), "motion.covariance", "isn't symmetric"),
    "covariance negative": (motion(covariance=np.diag([1e-4, -1e-4, 1e-4])), "motion.covariance", "positive definite"),
    "covariance flat": (motion(covariance=np.diag([1e-4, 0.0, 1e-4])), "motion.covariance", "positive definite"),
    "covariance NaN": (motion(covariance=np.full((3, 3), math.nan)), "motion.covariance", "NaN"),
    "covariance small": (motion(covariance=np.eye(2)), "motion.covariance", "(3, 3)"),
    "horizon outside": (rig(horizon_row=200.0), "rig.horizon_row", "must lie in"),
    "focal in metres": (rig(focal=0.004), "rig.focal", "W/(2 pi)"),
    "camera height in centimetres": (rig(camera_height=60.0), "rig.camera_height", "metres"),
    "nose outside": (rig(forward_column=720), "rig.forward_column", "there are 720 columns"),
    "no width": (rig(width=0), "rig.width", "positive"),
    "rig changes": (lambda r, k: rig(camera_height=0.5 + k / 1000)(r, k), "rig", "changes"),
    "driven a word": (lambda r, _: replace(r, driven="yes"), "driven", "True or False"),
    "no contact": (without("contact"), "contact", "is missing"),
    "no motion": (without("motion"), "motion", "is missing"),
    "over at once": (lambda r, _: None, "sense", "returns None"),
    "sensor lost": (lambda r, _: 1 / 0, "sense or act", "raises ZeroDivisionError"),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_a_faulty_driver_is_told_so_in_one_line(readings: list[SimReading], name: str) -> None:
    change, field, words = FAULTS[name]
    faulty = Faulty(readings, change)
    found = topomap.check_robot(faulty)
    assert [one.field for one in found] == [field], [str(one) for one in found]
    assert words in found[0].message
    assert "\n" not in str(found[0])
    assert faulty.stopped
    as_before("robot check", {name: [str(found[0])]}, part=True)


@pytest.mark.parametrize("world", [DEN, "room-corridor", "hall"])
def test_a_sound_robot_is_told_nothing(world: str) -> None:
    assert topomap.check_robot(robot(world, seed=2)) == ()


@pytest.mark.parametrize("settings", [("sim.laser.dropout=1.0",), ("sim.camera.codec='png'",),
                                      ("sim.camera.width=180", "sim.camera.height=40", "sim.camera.forward_column=5",
                                       "sim.camera.clockwise=false", "sim.laser.rays=180")])  # fmt: skip
def test_other_rigs_are_as_good(settings: tuple[str, ...]) -> None:
    assert topomap.check_robot(robot(DEN, *settings)) == ()


def test_a_robot_that_never_turned_is_asked_to(readings: list[SimReading]) -> None:
    found = topomap.check_robot(Played(readings[:12]))
    assert [one.field for one in found] == ["motion.turn"]
    assert "drive=True" in found[0].message


def test_it_drives_only_when_asked() -> None:
    still, driven = Played([]), Played([])
    source = [replace(r, driven=False) for r in robot_readings(20)]
    for played, drive in ((still, False), (driven, True)):
        played._readings = iter(source)
        topomap.check_robot(played, readings=20, drive=drive)
        assert played.stopped
    assert set(still.commands) == {Command()}
    assert {c.turn > 0 for c in driven.commands[:10]} == {True}
    assert {c.forward > 0 for c in driven.commands[10:]} == {True}


def robot_readings(count: int) -> list[SimReading]:
    source = robot()
    return [reading for _ in range(count) if (reading := source.sense()) is not None]


def test_wheels_that_cannot_be_stopped_are_told(readings: list[SimReading]) -> None:
    class Runaway(Faulty):
        def stop(self) -> None:
            raise OSError("the port is closed")

    found = topomap.check_robot(Runaway(readings, lambda r, _: r))
    assert [str(one) for one in found] == ["stop: raises OSError: the port is closed; it must always stop the wheels"]


def test_stamps_are_told_by_the_times_between_readings(readings: list[SimReading]) -> None:
    """What the first reading counts as its time says nothing: there is none before it."""
    two = [replace(r, stamp_ns=round(r.stamp_ns / 1e6), motion=replace(r.motion, dt=0.25)) for r in readings[:2]]
    late = replace(two[0], motion=replace(two[0].motion, dt=250.0))
    assert [str(one) for one in check_stamps([late, two[1]])] == [str(one) for one in check_stamps(two)] != []
    assert check_stamps(readings[:2]) == []
    half = [readings[0], replace(readings[1], motion=replace(readings[1].motion, dt=0.5))]
    assert [one.field for one in check_stamps(half)] == ["motion.dt"]
