"""Anybody's robot driven from Python: all that a simulated run writes, and wheels that are stopped whatever happens."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from round_world import RIG, RoundRobot

import topomap
from topomap.core.errors import ConfigError, DataError, RobotFault, ShapeError

MOTION = topomap.Motion(0.1, 0.0, 0.0, np.diag([1e-4, 1e-6, 1e-5]), 0.1)


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> tuple[topomap.RunResult, RoundRobot]:
    robot = RoundRobot(130)
    return topomap.drive(robot, tmp_path_factory.mktemp("own") / "run", settings=["stack.mission.then=stop"]), robot


def test_all_that_a_simulated_run_has(driven: tuple[topomap.RunResult, RoundRobot]) -> None:
    result, robot = driven
    assert {path.name for path in result.files} == {"run.mcap", "run.topomap", "summary.json", "report.html"}
    assert robot.stops == 1
    assert json.loads(result.folder.summary.read_text()) == result.summary
    assert result.summary["steps"] == 129  # the first step without a driver ends the mission
    assert result.summary["closures"]["accepted"] > 0
    assert len(topomap.load_map(result.folder.map).nodes) > 10
    run = topomap.load_run(str(result.folder.log))
    assert run.world == "own robot"
    assert "sim" not in run.config
    assert 'src="http' not in result.folder.report.read_text()


def test_without_truth_what_needs_it_is_null(driven: tuple[topomap.RunResult, RoundRobot]) -> None:
    summary = driven[0].summary
    for ate in ("dead_reckoning_ate_m", "map_ate_m", "online_ate_m"):
        assert summary[ate] == {"se2": None, "sim2": None}
    assert summary["rotation_scale"]["true"] is None
    for share in ("false", "gross", "possible", "recall"):
        assert summary["closures"][share] is None
    assert summary["seed"] is None


def test_its_log_replays_to_the_same_map(driven: tuple[topomap.RunResult, RoundRobot]) -> None:
    again = topomap.replay(driven[0].folder.log)
    assert again.folder.path == driven[0].folder.path / "replay"
    assert again.summary["graph_hash"] == driven[0].summary["graph_hash"] != ""
    other = topomap.replay(
        driven[0].folder.log, driven[0].folder.path / "other", settings=["stack.mapper.snapshots.threshold=0.3"]
    )
    assert other.summary["graph_hash"] != driven[0].summary["graph_hash"]


def test_numpy_floats_give_the_same_map(driven: tuple[topomap.RunResult, RoundRobot], tmp_path: Path) -> None:
    numbers = topomap.drive(RoundRobot(130, np.float64), tmp_path, settings=["stack.mission.then=stop"])
    assert numbers.summary["graph_hash"] == driven[0].summary["graph_hash"]


def test_the_check_has_nothing_to_say_about_it() -> None:
    assert topomap.check_robot(RoundRobot(200)) == ()


def test_a_lost_sensor_stops_the_wheels_and_leaves_a_log(tmp_path: Path) -> None:
    robot = RoundRobot(130, fails_at=40)
    with pytest.raises(RobotFault, match=r"sense\(\) at step 40 failed: OSError: the camera is gone") as caught:
        topomap.drive(robot, tmp_path)
    assert robot.stops == 1
    assert len(topomap.load_run(tmp_path / "run.mcap").stamps_ns) == 40
    assert isinstance(caught.value.result, topomap.RunResult)
    assert {path.name for path in caught.value.result.files} == {path.name for path in tmp_path.iterdir()}
    assert len(caught.value.result.files) == 4
    assert json.loads((tmp_path / "summary.json").read_text())["fault"] == str(caught.value)


@pytest.mark.parametrize("fails_at", [0])
def test_a_sensor_lost_from_the_start_stops_the_wheels(fails_at: int, tmp_path: Path) -> None:
    robot = RoundRobot(130, fails_at=fails_at)
    with pytest.raises(RobotFault, match=r"first sense\(\) failed: OSError: the camera is gone"):
        topomap.drive(robot, tmp_path)
    assert robot.stops == 1


def test_a_robot_without_readings_is_one_line(tmp_path: Path) -> None:
    robot = RoundRobot(0)
    with pytest.raises(DataError, match="first sense"):
        topomap.drive(robot, tmp_path)
    assert robot.stops == 1


def test_a_wrong_setting_is_told_before_the_robot_is_asked_anything(tmp_path: Path) -> None:
    robot = RoundRobot(0)
    with pytest.raises(ConfigError, match=r"unknown key stack\.nonsense"):
        topomap.drive(robot, tmp_path / "out", settings=["stack.nonsense=1"])
    assert robot.stops == 0
    assert not (tmp_path / "out").exists()


def test_truth_goes_to_the_metrics_where_it_is_known(tmp_path: Path) -> None:
    from sim2d import worlds
    from sim2d.robot import SimRobot
    from topomap.app.config import load_config

    robot = SimRobot(worlds.load(str(Path(__file__).parents[1] / "helpers" / "den.toml")), load_config().sim, 0)
    result = topomap.drive(robot, tmp_path, truth=robot, name="den", settings=["stack.mission.then=stop"])
    assert result.summary["world"] == "den"
    assert result.summary["map_ate_m"]["se2"] < 0.2
    assert result.summary["closures"]["false"] == 0


SCRIPT = """
import topomap
from round_world import RoundRobot
class Endless(RoundRobot):
    def sense(self):
        if self._step == 20:
            print("on its way", flush=True)
        return super().sense()
robot = Endless(100_000)
result = topomap.drive(robot, "out")
print(result.interrupted, robot.stops, result.summary["steps"] > 0)
"""


def test_ctrl_c_ends_the_drive_and_keeps_what_was_mapped(tmp_path: Path) -> None:
    here = Path(__file__).parents
    path = os.pathsep.join([str(here[1] / "helpers"), str(here[2])])
    process = subprocess.Popen(
        [sys.executable, "-c", SCRIPT], cwd=tmp_path, env={**os.environ, "PYTHONPATH": path}, stdout=subprocess.PIPE,
        text=True,
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdout.readline() == "on its way\n"
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=120)[0] == "True 1 True\n"
    assert (tmp_path / "out" / "report.html").exists()


def test_it_drives_in_a_thread_too(tmp_path: Path) -> None:
    done: list[topomap.RunResult] = []
    worker = threading.Thread(target=lambda: done.append(topomap.drive(RoundRobot(10), tmp_path)))
    worker.start()
    worker.join(120)
    assert done[0].summary["steps"] == 9 or done[0].summary["steps"] == 10


def test_a_reading_shows_the_stack_what_is_logged() -> None:
    image = np.random.default_rng(0).integers(0, 256, (40, 180, 3), dtype=np.uint8)
    png = topomap.Reading(stamp_ns=1, motion=MOTION, rig=RIG, image=image)
    assert np.array_equal(png.image, image)
    jpeg = topomap.Reading(stamp_ns=1, motion=MOTION, rig=RIG, image=image, quality=80)
    assert jpeg.encoded[:2] == b"\xff\xd8"
    assert not np.array_equal(jpeg.image, image)
    again = topomap.Reading(stamp_ns=1, motion=MOTION, rig=RIG, encoded=jpeg.encoded, image=image)
    assert np.array_equal(again.image, jpeg.image)
    ranges = topomap.Reading(stamp_ns=1, motion=MOTION, rig=RIG, image=image, ranges=np.ones(180)).ranges
    assert ranges is not None
    assert ranges.dtype == np.float32


@pytest.mark.parametrize(
    ("values", "error", "message"),
    [
        ({}, ShapeError, "must be uint8"),
        ({"image": np.zeros((40, 180, 3))}, ShapeError, "float64"),
        ({"image": np.zeros((40, 90, 3), np.uint8)}, ShapeError, "the rig says"),
        ({"encoded": b"no image"}, DataError, "can't be decoded"),
        ({"image": np.zeros((40, 180, 3), np.uint8), "ranges": np.ones(90)}, ShapeError, "ranges are"),
    ],
)
def test_a_reading_that_cannot_be_is_refused(values: dict[str, object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        topomap.Reading(stamp_ns=1, motion=MOTION, rig=RIG, **values)


def test_the_face_is_light_and_complete() -> None:
    heavy = (
        "import sys, topomap; print([m for m in ('numpy', 'cv2', 'gtsam', 'numba', 'pydantic') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", heavy], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
    for name in topomap.__all__:
        assert getattr(topomap, name) is not None, name
    assert 20 <= len(topomap.__all__) <= 37
    assert set(topomap.__all__) <= set(dir(topomap))
    with pytest.raises(AttributeError, match="it offers"):
        topomap.nonsense  # noqa: B018
