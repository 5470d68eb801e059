"""A replay senses what was sensed, bit by bit."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from log_samples import EPOCH, RIG, STEP, header, jpeg, odometry, write_log

from logs import records as log
from logs import topics
from logs.errors import LogError
from logs.recorder import Recorder
from logs.replay import ReplayRobot


def test_readings_are_bit_equal(tmp_path: Path) -> None:
    steps = write_log(tmp_path / "run.mcap", 6)
    robot = ReplayRobot(tmp_path / "run.mcap")
    assert robot.steps == 6
    assert robot.truth() is None
    for i, step in enumerate(steps):
        reading = robot.sense()
        image, scan, motion = step[topics.PANORAMA], step[topics.RANGES], step[topics.ODOMETRY]
        assert isinstance(image, log.Image)
        assert isinstance(scan, log.Scan)
        assert isinstance(motion, log.Odometry)
        assert reading is not None
        assert reading.stamp_ns == EPOCH + i * STEP
        assert reading.encoded == image.encoded
        bgr = cv2.imdecode(np.frombuffer(image.encoded, np.uint8), cv2.IMREAD_COLOR)
        assert bgr is not None
        expected = cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB)
        np.testing.assert_array_equal(reading.image, expected)
        assert reading.ranges is not None
        assert reading.ranges.dtype == np.float32
        assert reading.ranges.tobytes() == scan.ranges.tobytes()
        found = (reading.motion.forward, reading.motion.left, reading.motion.turn, reading.motion.dt)
        assert found == (motion.forward, motion.left, motion.turn, motion.dt)
        assert tuple(reading.motion.covariance.reshape(-1)) == motion.covariance
        assert reading.motion.covariance.shape == (3, 3)
        assert (reading.contact, reading.driven, reading.rig) == (motion.contact, True, RIG)
        assert robot.truth() == step[topics.TRUTH]
        robot.act(object())
    assert robot.sense() is None
    assert robot.sense() is None
    robot.stop()
    robot.close()


def test_no_ranges_and_no_truth_stay_none(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    with Recorder(tmp_path / "run.mcap", header()) as recorder:
        recorder.write(EPOCH, topics.PANORAMA, log.Image(jpeg(rng)))
        recorder.write(EPOCH, topics.ODOMETRY, odometry(rng, scanned=False))
    robot = ReplayRobot(tmp_path / "run.mcap")
    reading = robot.sense()
    assert reading is not None
    assert reading.ranges is None
    assert robot.truth() is None


def test_png_replays_without_loss(tmp_path: Path) -> None:
    image = np.random.default_rng(0).integers(0, 255, (10, 72, 3), dtype=np.uint8)
    encoded = cv2.imencode(".png", image[:, :, ::-1])[1].tobytes()
    with Recorder(tmp_path / "run.mcap", header()) as recorder:
        recorder.write(EPOCH, topics.PANORAMA, log.Image(encoded))
        recorder.write(EPOCH, topics.ODOMETRY, odometry(np.random.default_rng(0), scanned=False))
    reading = ReplayRobot(tmp_path / "run.mcap").sense()
    assert reading is not None
    np.testing.assert_array_equal(reading.image, image)


def test_a_reading_without_its_panorama_is_an_error_not_a_gap(tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", header()) as recorder:
        recorder.write(EPOCH, topics.ODOMETRY, odometry(np.random.default_rng(0)))
    with pytest.raises(LogError, match="lacks panorama"):
        ReplayRobot(tmp_path / "run.mcap").sense()
