"""The shutter: how long a picture is exposed, and that its rows are read one after the other."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sim2d.config import ShutterConfig

Pose = tuple[float, float, float]
MOST = 9  # pictures that are blended: at 0.8 rad/s and 50 ms a picture moves by 4.6 columns of 720
SAMPLES = 8  # of each row's exposure
NEAR = 1.0  # [m] what is seen so near is to move by at most a column from picture to picture


def moments(
    config: ShutterConfig, rows: int, focal: float, pose: Pose, before: Pose, dt: float
) -> tuple[list[Pose], NDArray[np.float32]]:
    """Return the poses at which pictures are to be taken, and how much of each (rows, K) every row holds.

    The last row's exposure ends at `pose`; `before` is the pose dt [s] earlier.
    """
    whole = min(config.exposure + config.readout, dt)
    swept = math.hypot(pose[0] - before[0], pose[1] - before[1]) / NEAR + abs(pose[2] - before[2])
    count = min(MOST, 1 + math.ceil(swept * focal * whole / dt)) if dt > 0 else 1
    if count == 1:
        return [pose], np.ones((rows, 1), np.float32)
    times = np.linspace(-whole, 0.0, count)
    exposure = min(config.exposure, whole)
    first = -whole + (whole - exposure) * np.arange(rows) / max(1, rows - 1)
    inside = first[:, None] + exposure * (np.arange(SAMPLES) + 0.5) / SAMPLES
    hats = np.maximum(0.0, 1.0 - np.abs(inside[:, :, None] - times) / (whole / (count - 1)))
    return [_between(before, pose, 1.0 + float(t) / dt) for t in times], hats.mean(axis=1).astype(np.float32)


def blended(pictures: list[NDArray[np.uint8]], weights: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return the picture (H, W, 3) whose rows hold the pictures by the weights (H, K)."""
    if len(pictures) == 1:
        return pictures[0]
    total = sum(w[:, None, None] * picture for w, picture in zip(weights.T, pictures, strict=True))
    return np.asarray(np.rint(total), dtype=np.uint8)


def _between(a: Pose, b: Pose, share: float) -> Pose:
    x, y, heading = (p + share * (q - p) for p, q in zip(a, b, strict=True))
    return x, y, heading
