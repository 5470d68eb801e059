"""A log as a robot: it senses what was sensed then, bit by bit, and can't be steered."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from logs.budget import IMAGE_LIMIT
from logs.errors import LogError
from logs.header import Header, Rig
from logs.image_size import image_size
from logs.reader import LogReader
from logs.records import Odometry, Truth
from logs.schemas import codec, foxglove
from logs.topics import ODOMETRY, PANORAMA, RANGES, TRUTH
from logs.verify import State


@dataclass(frozen=True, slots=True)
class Motion:
    """The odometry increment: forward, left [m], turn [rad], covariance (3, 3) of these, dt [s]."""

    forward: float
    left: float
    turn: float
    covariance: NDArray[np.float64]
    dt: float


@dataclass(frozen=True, slots=True)
class Reading:
    """A recorded reading; fits `topomap.core.robot.Reading`."""

    stamp_ns: int
    image: NDArray[np.uint8]
    encoded: bytes
    ranges: NDArray[np.float32] | None
    motion: Motion
    rig: Rig
    contact: bool
    driven: bool


class ReplayRobot:
    """Plays a log back; fits `topomap.core.robot.Robot` and `TruthSource`; raises LogError as `LogReader`."""

    def __init__(self, path: Path | str, skip_damaged: bool = False) -> None:
        self._log = LogReader(path, skip_damaged)
        self._truth: Truth | None = None
        self._readings = self._play()

    @property
    def header(self) -> Header:
        """The log's header."""
        return self._log.header

    @property
    def state(self) -> State:
        """Whether all that was written is there."""
        return self._log.state

    @property
    def complete(self) -> bool:
        """Whether the log was closed properly."""
        return self._log.complete

    @property
    def steps(self) -> int:
        """How many readings the log holds."""
        contents = self._log.file.contents
        return sum(contents.counts[id] for id, one in contents.channels.items() if one.topic == ODOMETRY)

    def attachment(self, name: str) -> bytes | None:
        """Return the last attachment of a name, or None; raises LogError when it is damaged."""
        return self._log.attachment(name)

    def sense(self) -> Reading | None:
        """Return the next reading, None at the end; raises LogError for a damaged one."""
        return next(self._readings, None)

    def act(self, command: object) -> None:
        """Do nothing: the drive is history."""

    def stop(self) -> None:
        """Do nothing: the wheels are history."""

    def truth(self) -> Truth | None:
        """Return the true pose at the last reading, None where none was recorded."""
        return self._truth

    def close(self) -> None:
        """Close the log."""
        self._log.close()

    def _play(self) -> Iterator[Reading]:
        parts: dict[str, bytes] = {}
        stamp = -1
        for item in self._log.items(PANORAMA, RANGES, TRUTH, ODOMETRY):
            if item.stamp_ns != stamp:
                parts, stamp = {}, item.stamp_ns
            parts[item.topic] = item.data
            if item.topic == ODOMETRY and self._lost(parts):
                continue
            if item.topic == ODOMETRY:
                self._truth = codec.decode(Truth, parts[TRUTH]) if TRUTH in parts else None
                yield self._reading(stamp, parts)

    def _lost(self, parts: dict[str, bytes]) -> bool:
        """Return whether a damaged chunk took panorama or ranges of a reading whose odometry is there."""
        if not self._log.file.contents.damaged:
            return False
        return PANORAMA not in parts or (RANGES not in parts and codec.decode(Odometry, parts[ODOMETRY]).scanned)

    def _reading(self, stamp_ns: int, parts: dict[str, bytes]) -> Reading:
        odometry = codec.decode(Odometry, parts[ODOMETRY])
        if PANORAMA not in parts or (odometry.scanned and RANGES not in parts):
            raise LogError(f"{self._log.file.path}: the reading at {stamp_ns} lacks panorama or ranges")
        encoded, rig = foxglove.decode_image(parts[PANORAMA]), self._log.header.rig
        image = decoded(encoded)
        if image.shape != (rig.height, rig.width, 3):
            raise LogError(f"the panorama at {stamp_ns} is {image.shape}, the rig says ({rig.height}, {rig.width}, 3)")
        return Reading(
            stamp_ns=stamp_ns,
            image=image,
            encoded=encoded,
            ranges=foxglove.decode_scan(parts[RANGES]) if odometry.scanned else None,
            motion=_motion(odometry),
            rig=rig,
            contact=odometry.contact,
            driven=odometry.driven,
        )


def decoded(encoded: bytes) -> NDArray[np.uint8]:
    """Return the image (H, W, 3) RGB of its JPEG or PNG bytes; raises LogError when they aren't one."""
    size = image_size(encoded)
    if size is not None and size[0] * size[1] > IMAGE_LIMIT:
        raise LogError(f"a logged image says that it is {size[0]} x {size[1]}: more than any camera's")
    image = None if size is None else cv2.imdecode(np.frombuffer(encoded, np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise LogError("a logged image can't be decoded")
    return np.ascontiguousarray(image[:, :, ::-1], dtype=np.uint8)


def _motion(odometry: Odometry) -> Motion:
    if len(odometry.covariance) != 9:
        raise LogError(f"an increment's covariance has {len(odometry.covariance)} numbers, not 9")
    covariance = np.array(odometry.covariance, dtype=np.float64).reshape(3, 3)
    return Motion(odometry.forward, odometry.left, odometry.turn, covariance, odometry.dt)
