"""What is predicted to be seen around a place: small views of one panorama from a grid of points beside it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from topomap.core.arrays import Complex64Array, Float32Array, FloatArray
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.vision.image.compare import PLACE, Signature, all_normalised, powers, shrunk
from topomap.vision.image.displaced import distances_or_middling, flow
from topomap.vision.matching.flow_kernels import pixel_maps

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

    spectra (D, R, C//2 + 1) complex64: all the views' in one; powers (D,): their pixels' mean squares.
    """

    points: FloatArray
    views: tuple[Signature, ...]
    spectra: Complex64Array
    powers: FloatArray


def surroundings(panorama: Panorama) -> Surroundings:
    """Return the small views predicted around a panorama's place, computed once; the first one is its own."""
    return panorama.derived("surroundings", _surroundings)


def _surroundings(panorama: Panorama) -> Surroundings:
    along, aside = (STEP * np.arange(-count, count + 1) for count in (ALONG, ASIDE))
    points = np.stack(np.meshgrid(along, aside, indexing="ij"), axis=-1).reshape(-1, 2)
    points = points[np.argsort(np.hypot(points[:, 0], points[:, 1]), kind="stable")]
    pixels = predicted(panorama, points)
    spectra: Complex64Array = np.fft.rfft(pixels, axis=2).astype(np.complex64)
    views = tuple(Signature(*one) for one in zip(pixels, spectra, strict=True))
    return Surroundings(points, views, spectra, powers(pixels))


def predicted(panorama: Panorama, points: FloatArray) -> Float32Array:
    """Return the pixels (D, R, C) of the small views predicted from points (D, 2) [m], ahead and to the left."""
    return all_normalised(_shrunk_again(_displaced(panorama, points), len(points)))


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
    origin, growth = flow(far, float(bearings[0]), points, ROUNDS)
    across = ((origin * (rig.width / TAU) + 0.5) / wide - 0.5) % columns
    ring = np.concatenate([small, small[:, :1]], axis=1)
    x, y = pixel_maps(across, growth, rows, horizon)
    return np.asarray(cv2.remap(ring, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), np.float32)


def _shrunk_again(pictures: Float32Array, count: int) -> Float32Array:
    """Return (D, R, C) small views of the pictures (D R', C'), blurred as a place's signature is."""
    high, columns = len(pictures) // count, pictures.shape[1]
    size = (min(PLACE.columns, columns), min(PLACE.rows, high))
    if (columns, high) == (FINER * size[0], FINER * size[1]):  # no pixel of two pictures: all are shrunk in one
        small = cv2.resize(pictures, (size[0], count * size[1]), interpolation=cv2.INTER_AREA)
    else:
        whole = pictures.reshape(count, high, columns)
        small = np.concatenate([cv2.resize(one, size, interpolation=cv2.INTER_AREA) for one in whole])
    return _blurred(np.asarray(small, np.float32).reshape(count, size[1], size[0]))


def _blurred(small: Float32Array) -> Float32Array:
    """Return pictures (D, R, C) blurred: round the circle, and with their first and last rows repeated."""
    count, rows, columns = small.shape
    reach = int(np.ceil(4 * PLACE.blur))
    pad = min(reach, columns)
    apart = np.clip(np.arange(-reach, rows + reach), 0, rows - 1)
    tall = np.ascontiguousarray(small[:, apart]).reshape(-1, columns)
    wrapped = cv2.copyMakeBorder(tall, 0, 0, pad, pad, cv2.BORDER_WRAP)
    blurred = cv2.GaussianBlur(wrapped, (0, 0), PLACE.blur, borderType=cv2.BORDER_REPLICATE)
    each = blurred.reshape(count, len(apart), columns + 2 * pad)
    return np.ascontiguousarray(each[:, reach : reach + rows, pad : pad + columns], np.float32)
