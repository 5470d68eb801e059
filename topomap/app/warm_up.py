"""Numba's compiling ahead of the first step: a robot on the move can't wait seconds for it."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from topomap.app.config import StackConfig
from topomap.app.wiring import build_navigator
from topomap.core.arrays import Float32Array, Image
from topomap.core.panorama import Panorama
from topomap.core.recorded import RecordedReading, RecordedRig
from topomap.core.records import Motion
from topomap.vision.matching.scan_match import match_scans
from topomap.vision.registry import aligned_homing, aligner

WIDTH, HEIGHT = 64, 24  # kernels are compiled by type, whatever the size
AROUND, LAP = 60, 12.0  # steps and way [m] round the circle
RAYS = 360  # so many as scans need that are to lie over one another
ENOUGH = 90  # steps: by then loops have been closed and solved


RIG = RecordedRig.cylinder(WIDTH, HEIGHT, 0.5, forward_column=0, clockwise=False)
MOTION = Motion(LAP / AROUND, 0.0, math.tau / AROUND, np.diag([1e-4, 1e-8, 1e-6]), 0.2)


def warm_up(config: StackConfig | None = None) -> None:
    """Compile what the stack will need: drive one round a made-up circle, once, then home by the settings' methods."""
    _drive_round()
    if config is not None:
        _home(config)


@cache
def _drive_round() -> None:
    """Drive a stack of its own till loops are closed, with ranges and without."""
    for ranges in (True, False):
        navigator = build_navigator(StackConfig())
        views = [_view(place, ranges) for place in range(AROUND)]
        for k in range(ENOUGH):
            image, far = views[k % AROUND]
            navigator.step(RecordedReading(stamp_ns=(k + 1) * 200_000_000, motion=MOTION, rig=RIG, image=image,
                                           ranges=far, driven=True))  # fmt: skip
    fine = np.full(RAYS, 3.0, np.float32)
    match_scans(fine, fine, np.zeros(3))


def _home(config: StackConfig) -> None:
    """Ask the methods that are named for one home vector; a user's own object is left alone, as it may keep count."""
    here, there = (Panorama.from_recorded(image, RIG, far) for image, far in (_view(0, True), _view(1, True)))
    if isinstance(config.mapper.aligner, str):
        aligner(config.mapper.aligner).align(there, here, 0.0)
    if isinstance(config.travel.homing, str) and isinstance(config.travel.aligner, str):
        homing = aligned_homing(config.travel.homing, config.travel.aligner)
        homing.home(there, here, 0.0)
        if homing.policy is not None:
            homing.move(homing.policy.start(here), there, 0.0)


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
