"""Numba's compiling ahead of the first step: a robot on the move can't wait seconds for it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cache

import cv2
import numpy as np

from topomap.app.config import StackConfig
from topomap.app.wiring import build_navigator
from topomap.core.arrays import Float32Array, FloatArray, Image
from topomap.core.panorama import Panorama
from topomap.vision.registry import aligned_homing, aligner

WIDTH, HEIGHT = 64, 24  # kernels are compiled by type, whatever the size
AROUND, LAP = 60, 12.0  # steps and way [m] round the circle
ENOUGH = 90  # steps: by then loops have been closed and solved


@dataclass(frozen=True)
class _Rig:
    width: int = WIDTH
    height: int = HEIGHT
    horizon_row: float = (HEIGHT - 1) / 2
    focal: float = WIDTH / math.tau
    camera_height: float = 0.5
    forward_column: int = 0
    clockwise: bool = False


@dataclass(frozen=True)
class _Motion:
    turn: float = math.tau / AROUND
    forward: float = LAP / AROUND
    left: float = 0.0
    dt: float = 0.2
    covariance: FloatArray = field(default_factory=lambda: np.diag([1e-4, 1e-8, 1e-6]))


@dataclass(frozen=True)
class _Reading:
    stamp_ns: int
    image: Image
    encoded: bytes
    ranges: Float32Array | None
    motion: _Motion = _Motion()
    rig: _Rig = _Rig()
    contact: bool = False
    driven: bool = True


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
            image, encoded, far = views[k % AROUND]
            navigator.step(_Reading((k + 1) * 200_000_000, image, encoded, far))


def _home(config: StackConfig) -> None:
    """Ask the methods that are named for one home vector; a user's own object is left alone, as it may keep count."""
    here, there = (Panorama.from_recorded(image, _Rig(), far) for image, _, far in (_view(0, True), _view(1, True)))
    if isinstance(config.mapper.aligner, str):
        aligner(config.mapper.aligner).align(there, here, 0.0)
    if isinstance(config.travel.homing, str) and isinstance(config.travel.aligner, str):
        homing = aligned_homing(config.travel.homing, config.travel.aligner)
        homing.home(there, here, 0.0)
        if homing.policy is not None:
            homing.move(homing.policy.start(here), there, 0.0)


def _view(place: int, ranges: bool) -> tuple[Image, bytes, Float32Array | None]:
    """Return a view like no other, over a plain floor, and the walls of a round room about the circle."""
    rng = np.random.default_rng(place)
    image = np.repeat(rng.integers(0, 256, (HEIGHT, WIDTH // 4, 3), dtype=np.uint8), 4, axis=1)
    image[-HEIGHT // 3 :] = 128
    bearings = math.tau * np.arange(WIDTH) / WIDTH
    across = LAP / math.tau * np.sin(bearings)
    room = 2 * LAP / math.tau
    far = np.sqrt(room**2 - (LAP / math.tau * np.cos(bearings)) ** 2) + across
    _, encoded = cv2.imencode(".png", image)
    return image, encoded.tobytes(), far.astype(np.float32) if ranges else None
