"""What a panorama would show from a little beside where it was taken."""

from __future__ import annotations

import cv2
import numpy as np

from topomap.core.arrays import Float32Array, FloatArray, Image
from topomap.core.geometry import TAU, wrap_all
from topomap.core.panorama import Panorama
from topomap.vision.image.distances import Source, distances
from topomap.vision.matching.flow_kernels import between

MIDDLING = 2.5
"""The distance [m] of what was neither measured nor seen to stand on the floor: the way to a room's walls."""
ROUNDS = 5
"""Iterations after which the inverse of a flow of a few columns is exact to a hundredth of a column, of 720; after
three it is in nine of ten."""


def displaced(panorama: Panorama, x: float, y: float) -> Panorama:
    """Return the view predicted x [m] ahead and y [m] to the left, looking the same way; for a few tenths of a metre.

    Each column moves and grows by its distance: measured, else seen by the ground line, else the same all round.
    """
    rig = panorama.rig
    (origin,), (growth,) = flow(distances_or_middling(panorama), 0.0, np.array([[x, y]]))
    below = np.arange(rig.height)[:, np.newaxis] - rig.horizon_row
    rows = np.asarray(rig.horizon_row + below * growth, np.float32)
    columns = np.asarray((origin % TAU) * rig.width / TAU, np.float32)
    return Panorama(_sampled(panorama.image, columns, rows), None, rig)


def flow(far: FloatArray, first: float, points: FloatArray, rounds: int = ROUNDS) -> tuple[FloatArray, FloatArray]:
    """Return, for the views from points (D, 2) [m] ahead and to the left, where their columns come from: bearings
    (D, n) [rad] in the view at hand, and what to multiply rows below the horizon by (D, n) to find theirs.

    far (n,) [m]: how far away what each column shows stands; first [rad]: the first column's bearing, the others follow
    evenly all round.
    """
    bearings = first + np.arange(len(far)) * (TAU / len(far))
    reach = np.maximum(far, 2.0 * np.hypot(points[:, :1], points[:, 1:]))
    east, north = reach * np.cos(bearings) - points[:, :1], reach * np.sin(bearings) - points[:, 1:]
    moved, nearer = wrap_all(np.arctan2(north, east) - bearings), np.hypot(east, north) / reach
    origin = np.broadcast_to(bearings, moved.shape)
    for _ in range(rounds):  # the bearing that moves to each column's
        origin = bearings - between(moved, origin - first)
    return origin, between(nearer, origin - first)


def distances_or_middling(panorama: Panorama) -> FloatArray:
    """Return how far away what each column shows stands (W,) [m]: measured, else seen, else the same all round."""
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
