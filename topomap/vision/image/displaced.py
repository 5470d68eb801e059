"""What a panorama would show from a little beside where it was taken."""

from __future__ import annotations

import math

import cv2
import numpy as np

from topomap.core.arrays import Float32Array, FloatArray, Image
from topomap.core.geometry import TAU, wrap_all
from topomap.core.panorama import Panorama
from topomap.vision.image.distances import Source, distances

MIDDLING = 2.5
"""The distance [m] of what was neither measured nor seen to stand on the floor: the way to a room's walls."""
ROUNDS = 5
"""Iterations after which the inverse of a flow of a few columns is exact to a hundredth of a column."""


def displaced(panorama: Panorama, x: float, y: float) -> Panorama:
    """Return the view predicted x [m] ahead and y [m] to the left, looking the same way; for a few tenths of a metre.

    Each column moves and grows by its distance: measured, else seen by the ground line, else the same all round.
    """
    rig = panorama.rig
    bearings = np.arange(rig.width) * (TAU / rig.width)
    far = np.maximum(_distances(panorama), 2.0 * math.hypot(x, y))
    east, north = far * np.cos(bearings) - x, far * np.sin(bearings) - y
    moved, nearer = wrap_all(np.arctan2(north, east) - bearings), np.hypot(east, north) / far
    origin = bearings
    for _ in range(ROUNDS):  # the bearing that moves to each column's
        origin = bearings - np.interp(origin, bearings, moved, period=TAU)
    below = np.arange(rig.height)[:, np.newaxis] - rig.horizon_row
    rows = np.asarray(rig.horizon_row + below * np.interp(origin, bearings, nearer, period=TAU), np.float32)
    columns = np.asarray((origin % TAU) * rig.width / TAU, np.float32)
    return Panorama(_sampled(panorama.image, columns, rows), None, rig)


def _distances(panorama: Panorama) -> FloatArray:
    sources: tuple[Source, ...] = ("ground",) if panorama.ranges is None else ("range", "ground")
    for source in sources:
        found = distances(panorama, source)
        if found.share > 0.0:
            return found.metres
    return np.full(panorama.rig.width, MIDDLING)


def _sampled(image: Image, columns: Float32Array, rows: Float32Array) -> Image:
    """Return the image (H, W, 3) at columns (W,), which go on round the circle, and rows (H, W)."""
    ring = np.concatenate([image, image[:, :1]], axis=1)
    across = np.ascontiguousarray(np.broadcast_to(columns, rows.shape))
    found = cv2.remap(ring, across, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return found.astype(np.uint8, copy=False)
