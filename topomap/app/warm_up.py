"""Numba's compiling ahead of the first step: a robot on the move can't wait seconds for it."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from topomap.app.config import StackConfig
from topomap.app.wiring import build_navigator
from topomap.core.arrays import Float32Array, Image
from topomap.core.recorded import RecordedReading, RecordedRig
from topomap.core.records import Motion

WIDTH, HEIGHT = 64, 24  # kernels are compiled by type, whatever the size
AROUND, LAP = 60, 12.0  # steps and way [m] round the circle
ENOUGH = 90  # steps: by then loops have been closed and solved


RIG = RecordedRig.cylinder(WIDTH, HEIGHT, 0.5, forward_column=0, clockwise=False)
MOTION = Motion(LAP / AROUND, 0.0, math.tau / AROUND, np.diag([1e-4, 1e-8, 1e-6]), 0.2)


@cache
def warm_up() -> None:
    """Drive a stack of its own round a made-up circle till loops are closed, with ranges and without; once."""
    for ranges in (True, False):
        navigator = build_navigator(StackConfig())
        views = [_view(place, ranges) for place in range(AROUND)]
        for k in range(ENOUGH):
            image, far = views[k % AROUND]
            navigator.step(RecordedReading(stamp_ns=(k + 1) * 200_000_000, motion=MOTION, rig=RIG, image=image,
                                           ranges=far, driven=True))  # fmt: skip


def _view(place: int, ranges: bool) -> tuple[Image, Float32Array | None]:
    """Return a view like no other, over a plain floor, and the walls of a round room about the circle."""
    rng = np.random.default_rng(place)
    image = np.repeat(rng.integers(0, 256, (HEIGHT, WIDTH // 4, 3), dtype=np.uint8), 4, axis=1)
    image[-HEIGHT // 3 :] = 128
    bearings = math.tau * np.arange(WIDTH) / WIDTH
    across = LAP / math.tau * np.sin(bearings)
    room = 2 * LAP / math.tau
    far = np.sqrt(room**2 - (LAP / math.tau * np.cos(bearings)) ** 2) + across
    return image, far.astype(np.float32) if ranges else None
