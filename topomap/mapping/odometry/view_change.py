"""How much the view changed between two readings: as it is, and with the light taken out of it."""

from __future__ import annotations

import cv2
import numpy as np

from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.mapping.odometry.seen_way import SECTORS
from topomap.vision.image.compare import Signature, rotation_difference, sector_means, signature, turned

LEAST = 0.35
"""Change below which nothing is a break: photographs outdoors change by up to 0.31 over 3 cm, views on the way into a
corridor by 0.23 a step; carried on by 2 m a view changes by 0.38 at least in `hall`, by 0.6 in `room-corridor`."""
AROUND = 2.5
"""[signature pixels] Surroundings (sigma) that a pixel is held against, so that light that falls on a part of the room
drops out: a tenth of the view in all."""
FLAT = 0.1
"""Contrast, of that of the whole view, below which surroundings are bare and their noise counts for less."""


def seen_turn(now: Panorama, before: Panorama) -> float:
    """Return how far the robot turned between two views [rad]."""
    return rotation_difference(signature(now), signature(before))[1]


def view_change(now: Panorama, before: Panorama, turn: float) -> tuple[float, float]:
    """Return how two views differ (rms), turned by the odometry's turn or nearly: median over sectors, and whole."""
    return change_by(signature(now), signature(before), turn)


def structure_change(now: Panorama, before: Panorama, turn: float) -> float:
    """Return how two views differ where light is taken out (rms), turned by about `turn` [rad]: median over sectors."""
    return change_by(_structure(now), _structure(before), turn)[0]


def change_by(a: Signature, b: Signature, turn: float) -> tuple[float, float]:
    """Return how two views differ (rms), one turned by `turn` [rad] or nearly: median over sectors, and whole."""
    turns = turn + np.array([-1.0, 0.0, 1.0]) * TAU / a.pixels.shape[1]
    squares: FloatArray = np.square(turned(a, turns) - b.pixels[None]).mean(axis=1)
    by_sector = sector_means(squares, SECTORS)
    return float(np.sqrt(np.median(by_sector, axis=1).min())), float(np.sqrt(squares.mean(axis=1).min()))


def _structure(panorama: Panorama) -> Signature:
    """Return the signature with each pixel held against the mean and the contrast around it."""
    return panorama.derived("structure", _without_light)


def _without_light(panorama: Panorama) -> Signature:
    pixels = signature(panorama).pixels
    off = pixels - _around(pixels)
    held = np.asarray(off / (np.sqrt(np.maximum(_around(np.square(off)), 0.0)) + FLAT), np.float32)
    return Signature(held, np.fft.rfft(held, axis=1).astype(np.complex64))


def _around(pixels: Float32Array) -> Float32Array:
    """Return the mean around each pixel (R, C), around the seam too."""
    pad = min(int(np.ceil(4 * AROUND)), pixels.shape[1])
    wrapped = cv2.copyMakeBorder(pixels, 0, 0, pad, pad, cv2.BORDER_WRAP)
    blurred = cv2.GaussianBlur(wrapped, (0, 0), AROUND, borderType=cv2.BORDER_REPLICATE)
    return np.ascontiguousarray(blurred[:, pad : pad + pixels.shape[1]], np.float32)
