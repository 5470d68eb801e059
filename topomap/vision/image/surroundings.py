"""What is predicted to be seen around a place: small views of one panorama from a grid of points beside it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from topomap.core.arrays import Complex64Array, Float32Array, FloatArray
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.vision.image.compare import PLACE, Signature, normalised, shrunk
from topomap.vision.image.displaced import distances_or_middling, flow

FINER = 2
"""Columns and rows of the picture that is displaced, to one of the small view: more gain nothing."""
ROUNDS = 3
"""A small view's columns are four times as wide as those for which five rounds are asked."""
STEP, ALONG, ASIDE = 0.15, 3, 2
"""[m] Between neighbouring points, and how many there are before, behind and to either side: 0.45 m, as snapshots a
metre apart need (in `office-loop` a view differs by 0.13 to 0.2 from a snapshot within 0.1 m of a point, by 0.35 and
0.59 from one that lay 0.04 and 0.18 m beyond the farthest), and 0.3 m, as far as a driver keeps beside a route; a view
from half a step off differs as little as one taken again."""


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """Points (D, 2) [m], ahead and to the left of the robot, and the view predicted from each, looking the same way.

    spectra (D, R, C//2 + 1) complex64: all the views' in one.
    """

    points: FloatArray
    views: tuple[Signature, ...]
    spectra: Complex64Array


def surroundings(panorama: Panorama) -> Surroundings:
    """Return the small views predicted around a panorama's place, computed once; the first one is its own."""
    return panorama.derived("surroundings", _surroundings)


def _surroundings(panorama: Panorama) -> Surroundings:
    along, aside = (STEP * np.arange(-count, count + 1) for count in (ALONG, ASIDE))
    points = np.stack(np.meshgrid(along, aside, indexing="ij"), axis=-1).reshape(-1, 2)
    points = points[np.argsort(np.hypot(points[:, 0], points[:, 1]), kind="stable")]
    pixels = predicted(panorama, points)
    spectra: Complex64Array = np.fft.rfft(pixels, axis=2).astype(np.complex64)
    return Surroundings(points, tuple(Signature(*one) for one in zip(pixels, spectra, strict=True)), spectra)


def predicted(panorama: Panorama, points: FloatArray) -> Float32Array:
    """Return the pixels (D, R, C) of the small views predicted from points (D, 2) [m], ahead and to the left."""
    return np.stack([normalised(one) for one in _shrunk_again(_displaced(panorama, points), len(points))])


def _displaced(panorama: Panorama, points: FloatArray) -> Float32Array:
    """Return the pictures (D R, C) seen from the points, one below the other."""
    rig = panorama.rig
    small = shrunk(panorama, FINER * PLACE.columns, FINER * PLACE.rows)
    rows, columns = small.shape
    wide, high = rig.width / columns, rig.height / rows
    bearings = ((np.arange(columns) + 0.5) * wide - 0.5) * (TAU / rig.width)
    whole = np.arange(rig.width) * (TAU / rig.width)
    far = np.interp(bearings, whole, distances_or_middling(panorama), period=TAU)
    horizon = (rig.horizon_row + 0.5) / high - 0.5
    below = np.arange(rows)[:, np.newaxis] - horizon
    origin, growth = flow(far, float(bearings[0]), points, ROUNDS)
    across = ((origin * (rig.width / TAU) + 0.5) / wide - 0.5) % columns
    down = horizon + below * growth[:, np.newaxis, :]
    ring = np.concatenate([small, small[:, :1]], axis=1)
    x = np.repeat(across.astype(np.float32), rows, axis=0)
    y = down.reshape(-1, columns).astype(np.float32)
    return np.asarray(cv2.remap(ring, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), np.float32)


def _shrunk_again(pictures: Float32Array, count: int) -> Float32Array:
    """Return (D, R, C) small views of the pictures (D R', C'), blurred as a place's signature is."""
    high, columns = len(pictures) // count, pictures.shape[1]
    rows = min(PLACE.rows, high)
    whole = pictures.reshape(count, high, columns)
    return np.stack([_one(one, (min(PLACE.columns, columns), rows)) for one in whole])


def _one(picture: Float32Array, size: tuple[int, int]) -> Float32Array:
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    pad = min(int(np.ceil(4 * PLACE.blur)), size[0])
    wrapped = cv2.copyMakeBorder(small, 0, 0, pad, pad, cv2.BORDER_WRAP)
    blurred = cv2.GaussianBlur(wrapped, (0, 0), PLACE.blur, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(blurred[:, pad : pad + size[0]], np.float32)
