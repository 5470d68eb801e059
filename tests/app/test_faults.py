"""What ends a drive before its time: the wheels are stopped once, and log, map, summary and report are written."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from round_world import RoundRobot

import topomap
from logs.recorder import Recorder
from topomap.app.interrupt import SIGNALS
from topomap.core.errors import ConfigError, DataError, RobotFault

AT = 25
NAN = float("nan")


class Faulty(RoundRobot):
    """A robot to which something happens at step 25."""

    def __init__(self, happens: Callable[[Faulty, topomap.Reading], topomap.Reading | None]) -> None:
        super().__init__(200)
        self.happens = happens
        self.called: list[str] = []

    def sense(self) -> topomap.Reading | None:
        reading = super().sense()
        assert reading is not None
        return self.happens(self, reading) if self._step == AT else reading

    def act(self, command: topomap.Command) -> None:
        self.called.append(f"act {command.forward:g}")

    def stop(self) -> None:
        super().stop()
        self.called.append("stop")


def changed(**values: object) -> Callable[[Faulty, topomap.Reading], topomap.Reading]:
    return lambda _, reading: dataclasses.replace(reading, quality=None, **values)


def moved(**values: float) -> Callable[[Faulty, topomap.Reading], topomap.Reading]:
    return lambda _, reading: dataclasses.replace(
        reading, quality=None, motion=dataclasses.replace(reading.motion, **values)
    )


def sends(number: int) -> Callable[[Faulty, topomap.Reading], topomap.Reading]:
    def happens(_: Faulty, reading: topomap.Reading) -> topomap.Reading:
        os.kill(os.getpid(), number)
        return reading

    return happens


def hangs(robot: Faulty, reading: topomap.Reading) -> topomap.Reading:
    time.sleep(30.0)
    return reading


def breaks(robot: Faulty, reading: topomap.Reading) -> topomap.Reading:
    raise ZeroDivisionError("the driver's own\nmistake")


def odd(_: Faulty, reading: topomap.Reading) -> topomap.Reading:
    object.__setattr__(reading, "encoded", b"GIF89a")
    return reading


FAULTS: dict[str, tuple[Callable[[Faulty, topomap.Reading], topomap.Reading], str]] = {
    "an increment of NaN": (moved(forward=NAN), "holds NaN"),
    "a turn without end": (moved(turn=math.inf), "holds NaN or infinite"),
    "a covariance of another shape": (moved(covariance=np.eye(2)), "covariance is (2, 2)"),
    "a stamp once more": (changed(stamp_ns=AT * 100_000_000), "isn't later than the one before"),
    "a stamp that runs backwards": (changed(stamp_ns=5), "stamps run backwards"),
    "a stamp of text": (changed(stamp_ns="now"), "can't be logged"),
    "an exception of the driver": (breaks, "ZeroDivisionError: the driver's own"),
    "a camera that hangs": (hangs, "didn't return within 0.5 s: its wheels were stopped"),
    "a picture of another kind": (odd, "neither JPEG nor PNG"),
}


@pytest.mark.parametrize(("happens", "says"), FAULTS.values(), ids=FAULTS)
def test_a_fault_is_one_line_and_all_is_written(
    happens: Callable[[Faulty, topomap.Reading], topomap.Reading], says: str, tmp_path: Path
) -> None:
    robot = Faulty(happens)
    with pytest.raises(RobotFault) as caught:
        topomap.drive(robot, tmp_path, deadline_s=0.5 if happens is hangs else 30.0)
    assert says in str(caught.value)
    assert robot.stops == 1
    assert {path.name for path in tmp_path.iterdir()} == {"run.mcap", "run.topomap", "summary.json", "report.html"}
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["steps"] == AT
    assert summary["fault"] == str(caught.value)
    assert summary["log"] == {"state": "whole", "note": None}
    assert summary["home"]["claimed"] is not True
    assert "fault" in (tmp_path / "report.html").read_text()
    assert len(topomap.load_map(tmp_path / "run.topomap").nodes) > 1


class Leaping(RoundRobot):
    """A robot whose odometer counts a thousand kilometres a step from step 15 on."""

    def sense(self) -> topomap.Reading | None:
        reading = super().sense()
        if reading is None or self._step < 15:
            return reading
        return dataclasses.replace(reading, quality=None, motion=dataclasses.replace(reading.motion, forward=1e6))


def test_what_an_odometer_counts_however_much_is_written_and_read(tmp_path: Path) -> None:
    topomap.drive(Leaping(40), out=tmp_path / "run")
    for name in ("run.topomap", "summary.json", "report.html"):
        assert (tmp_path / "run" / name).stat().st_size > 0
    assert np.abs(topomap.load_run(tmp_path / "run" / "run.mcap").dead_reckoning).max() > 1e7


def test_the_reading_at_fault_is_on_record_and_leads_a_replay_to_the_same_fault(tmp_path: Path) -> None:
    with pytest.raises(RobotFault) as caught:
        topomap.drive(Faulty(moved(forward=NAN)), tmp_path / "a")
    with pytest.raises(RobotFault) as again:
        topomap.replay(tmp_path / "a" / "run.mcap", tmp_path / "b")
    assert str(again.value) == str(caught.value)
    hashes = [json.loads((tmp_path / name / "summary.json").read_text())["graph_hash"] for name in "ab"]
    assert hashes[0] == hashes[1] != ""


@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
def test_every_signal_that_would_end_the_program_stops_the_wheels_first(number: int, tmp_path: Path) -> None:
    robot = Faulty(sends(number))
    started = signal.signal(number, signal.default_int_handler)  # whoever starts the tests may ignore it, as nohup does
    try:
        before = signal.getsignal(number)
        result = topomap.drive(robot, tmp_path, deadline_s=30.0)
        assert signal.getsignal(number) is before
    finally:
        signal.signal(number, started)
    assert result.interrupted
    assert result.signal == number
    assert result.fault == ""
    assert robot.called[-1] == "stop"
    assert robot.stops == 1
    assert {path.name for path in result.files} == {"run.mcap", "run.topomap", "summary.json", "report.html"}
    assert 0 < result.summary["steps"] <= AT + 1
    assert result.summary["log"]["state"] == "whole"


def test_a_signal_while_the_camera_hangs_stops_the_wheels_within_a_second(tmp_path: Path) -> None:
    stopped: list[float] = []

    class Hanging(Faulty):
        def stop(self) -> None:
            super().stop()
            stopped.append(time.monotonic())

    def happens(robot: Faulty, reading: topomap.Reading) -> topomap.Reading:
        stopped.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGTERM)
        return hangs(robot, reading)

    result = topomap.drive(Hanging(happens), tmp_path, deadline_s=30.0)
    assert result.signal == signal.SIGTERM
    assert stopped[1] - stopped[0] < 1.5
    assert result.summary["steps"] == AT


def test_act_that_hangs_is_a_fault_too(tmp_path: Path) -> None:
    class Stiff(RoundRobot):
        def act(self, command: topomap.Command) -> None:
            if self._step == AT:
                time.sleep(30.0)

    robot = Stiff(200)
    with pytest.raises(RobotFault, match=r"act\(\) didn't return within 0\.5 s: its wheels were stopped"):
        topomap.drive(robot, tmp_path, deadline_s=0.5)
    assert robot.stops == 1


def test_wheels_that_cannot_be_stopped_are_told_of(tmp_path: Path) -> None:
    class Runaway(RoundRobot):
        def stop(self) -> None:
            time.sleep(30.0)

    with pytest.raises(RobotFault, match=r"stop\(\) didn't return within 0\.5 s: its wheels may still turn"):
        topomap.drive(Runaway(20), tmp_path, deadline_s=0.5)
    assert (tmp_path / "report.html").exists()


def test_a_step_that_takes_too_long_halts_the_wheels_until_its_command(tmp_path: Path) -> None:
    from logs import topics
    from logs.reader import LogReader
    from logs.schemas.foxglove import decode_text

    slow = threading.Event()

    def progress(steps: int) -> None:
        if steps == AT and not slow.is_set():
            slow.set()
            time.sleep(1.2)

    robot = Faulty(lambda _, reading: reading)
    robot._steps = 60
    topomap.drive(robot, tmp_path, deadline_s=0.5, progress=progress, settings=["stack.mission.then=stop"])
    assert robot.stops == 1
    with LogReader(tmp_path / "run.mcap") as log:
        said = [decode_text(item.data).message for item in log.items(topics.TEXT)]
    assert [text for text in said if "the wheels were halted" in text]


def test_a_first_reading_may_take_longer_than_the_others(tmp_path: Path) -> None:
    class Slow(RoundRobot):
        def sense(self) -> topomap.Reading | None:
            if self._step < 0:
                time.sleep(0.8)
            return super().sense()

    result = topomap.drive(Slow(20), tmp_path, deadline_s=0.5)
    assert result.fault == ""


def test_a_full_disk_is_one_line_with_map_and_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The log's disk is full after some steps; what lies elsewhere is written."""
    write, steps = Recorder.write, []

    def full(self: Recorder, stamp_ns: int, topic: str, record: object) -> None:
        steps.append(stamp_ns)
        if len(set(steps)) > AT:
            raise self._failed(OSError(28, "No space left on device"))
        write(self, stamp_ns, topic, record)

    monkeypatch.setattr(Recorder, "write", full)
    robot = RoundRobot(100)
    with pytest.raises(RobotFault, match="No space left on device"):
        topomap.drive(robot, tmp_path)
    assert robot.stops == 1
    assert {path.name for path in tmp_path.iterdir()} == {"run.mcap", "run.topomap", "summary.json", "report.html"}


def test_a_disk_that_is_full_for_everything_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    robot = RoundRobot(30)
    with pytest.raises(DataError, match="No space left on device") as caught:
        topomap.drive(robot, tmp_path)
    assert "\n" not in str(caught.value)
    assert robot.stops == 1


@pytest.mark.parametrize("seconds", [0.0, -1.0, NAN])
def test_a_deadline_is_some_seconds(seconds: float, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="deadline_s"):
        topomap.drive(RoundRobot(5), tmp_path, deadline_s=seconds)
    result = topomap.drive(RoundRobot(5), tmp_path, deadline_s=math.inf)
    assert result.fault == ""
