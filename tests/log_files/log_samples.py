"""Small logs for tests: readings as a robot would hand them over, written with the recorder alone."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from logs import topics
from logs.header import Errors, Header, Plan, Rig
from logs.recorder import Recorder
from logs.records import Image, Odometry, Pose, Scan, Truth

EPOCH = 1_700_000_000_000_000_000
STEP = 250_000_000
RIG = Rig(72, 10, 4.5, 72 / (2 * np.pi), 0.6, 36, True)


def header() -> Header:
    """Return a header with every field away from its default."""
    return Header(
        world="test-room",
        rig=RIG,
        seed=7,
        config='{"a": {"b": 0.1}}',
        versions={"topomap": "0.1.0", "numpy": "2"},
        start=Pose(1.0, 2.0, 0.3),
        errors=Errors(1.04, 0.95, 0.003),
        plan=Plan((((0.0, 0.0), (1.0, 0.1)),), ((1.0, 2.0, 0.5),), ((0.5, 0.5, "door"),)),
        replayed=True,
    )


def jpeg(rng: np.random.Generator, height: int = 10, width: int = 72) -> bytes:
    """Return a random JPEG."""
    image: NDArray[np.uint8] = rng.integers(0, 255, (height, width, 3), dtype=np.uint8)
    return bytes(cv2.imencode(".jpg", image)[1].tobytes())


def odometry(rng: np.random.Generator, scanned: bool = True) -> Odometry:
    """Return a random increment."""
    forward, left, turn = rng.normal(size=3).tolist()
    covariance = tuple(rng.normal(size=9).tolist())
    return Odometry(forward, left, turn, covariance, 0.25, bool(rng.random() < 0.5), True, scanned)


def write_step(recorder: Recorder, stamp_ns: int, rng: np.random.Generator) -> dict[str, object]:
    """Write one reading with its truth and return its records by topic."""
    ranges = rng.random(72).astype(np.float32)
    ranges[rng.random(72) < 0.1] = np.nan
    x, y, heading = rng.normal(size=3).tolist()
    step: dict[str, object] = {
        topics.PANORAMA: Image(jpeg(rng)),
        topics.RANGES: Scan(ranges),
        topics.TRUTH: Truth(stamp_ns, x, y, heading, True),
        topics.ODOMETRY: odometry(rng),
    }
    for topic, record in step.items():
        recorder.write(stamp_ns, topic, record)
    return step


def write_log(path: Path, steps: int, seed: int = 0, chunk_size: int = 262_144) -> list[dict[str, object]]:
    """Write a log of some steps and return what was written."""
    rng = np.random.default_rng(seed)
    with Recorder(path, header(), chunk_size=chunk_size) as recorder:
        return [write_step(recorder, EPOCH + i * STEP, rng) for i in range(steps)]
