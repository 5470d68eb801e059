"""A mirror's round picture and the panorama it shows: both ways, and the mirror's place found in a picture."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import cv2
import numpy as np

from topomap.core.arrays import Float32Array, FloatArray, Image
from topomap.core.errors import DataError, ShapeError
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig

Turn = Literal["clockwise", "counter-clockwise"]


@dataclass(frozen=True, slots=True)
class MirrorRig:
    """How a mirror's ring lies in a raw picture.

    x, y: its centre; inner, outer: radii, of the panorama's lowest and highest row where inner_is_floor, else the
    other way round [pixels]; forward [rad]: the direction of the nose in the picture, from +x towards +y (down);
    turn: how directions run in the picture as bearings run counter-clockwise.
    """

    x: float
    y: float
    inner: float
    outer: float
    forward: float = 0.0
    turn: Turn = "counter-clockwise"
    inner_is_floor: bool = True

    def __post_init__(self) -> None:
        """Refuse a ring that is none. Raises DataError."""
        if not 0.0 <= self.inner < self.outer:
            raise DataError(f"a mirror's ring needs 0 <= inner < outer, got {self.inner:g} and {self.outer:g}")

    def direction(self, bearing: FloatArray) -> FloatArray:
        """Return the picture's direction of bearings (...) [rad]; y runs down, so counter-clockwise is negative."""
        sign = -1.0 if self.turn == "counter-clockwise" else 1.0
        return np.asarray(self.forward + sign * bearing, np.float64)

    def radius(self, row: FloatArray, height: int) -> FloatArray:
        """Return the radius [pixels] of panorama rows (...): pixel centres between the two rims."""
        share = (row + 0.5) / height
        share = 1.0 - share if self.inner_is_floor else share
        return np.asarray(self.inner + share * (self.outer - self.inner), np.float64)


def unwrap(raw: Image, mirror: MirrorRig, rig: Rig) -> Panorama:
    """Return the panorama of a raw mirror picture (R, C, 3), area-true where the ring is finer. Raises ShapeError."""
    _checked(raw)
    columns, rows = np.meshgrid(np.arange(rig.width, dtype=np.float64), np.arange(rig.height, dtype=np.float64))
    angle = mirror.direction(columns * TAU / rig.width)
    radius = mirror.radius(rows, rig.height)
    x, y = mirror.x + radius * np.cos(angle), mirror.y + radius * np.sin(angle)
    fine = max(TAU * mirror.outer / rig.width, (mirror.outer - mirror.inner) / rig.height)
    source = cv2.GaussianBlur(raw, (0, 0), 0.4 * fine) if fine > 1.5 else raw
    mapped = cv2.remap(source, x.astype(np.float32), y.astype(np.float32), cv2.INTER_LINEAR)
    return Panorama(np.ascontiguousarray(mapped, np.uint8), None, rig)


def wrap_up(panorama: Panorama, mirror: MirrorRig, size: tuple[int, int], around: int = 0) -> Image:
    """Return the raw picture (R, C, 3) a mirror would take of a panorama; `around` is the grey value elsewhere."""
    columns, rows = np.meshgrid(np.arange(size[1], dtype=np.float64), np.arange(size[0], dtype=np.float64))
    dx, dy = columns - mirror.x, rows - mirror.y
    radius, angle = np.hypot(dx, dy), np.arctan2(dy, dx)
    sign = -1.0 if mirror.turn == "counter-clockwise" else 1.0
    column = np.mod(sign * (angle - mirror.forward), TAU) * panorama.rig.width / TAU
    share = (radius - mirror.inner) / (mirror.outer - mirror.inner)
    share = 1.0 - share if mirror.inner_is_floor else share
    wide = np.concatenate([panorama.image, panorama.image[:, :2]], axis=1)
    row = np.clip(share * panorama.rig.height - 0.5, 0, panorama.rig.height - 1)
    picture = cv2.remap(wide, column.astype(np.float32), row.astype(np.float32), cv2.INTER_LINEAR)
    inside = (radius >= mirror.inner) & (radius <= mirror.outer)
    return np.where(inside[:, :, np.newaxis], picture, np.uint8(around)).astype(np.uint8)


def fit_mirror(raw: Image, reference: Panorama | None = None) -> MirrorRig:
    """Find centre and radii of the ring in a raw picture (R, C, 3), and direction from a reference panorama.

    The rims are where the mean brightness along circles jumps most, the centre where it jumps sharpest. Without a
    reference the nose is taken along +x and bearings run counter-clockwise. Raises DataError, ShapeError.
    """
    _checked(raw)
    grey = cv2.cvtColor(raw, cv2.COLOR_RGB2GRAY).astype(np.float32)
    if float(grey.std()) < 1.0:
        raise DataError("the picture holds nothing in which a mirror's ring could be found")
    x, y = _centre(grey)
    inner, outer = _rims(_profile(grey, x, y))
    found = MirrorRig(x, y, inner, outer)
    return found if reference is None else _turned(raw, found, reference)


def _checked(raw: Image) -> None:
    if raw.ndim != 3 or raw.shape[2] != 3 or raw.dtype != np.uint8:
        raise ShapeError(f"a raw picture is uint8 (R, C, 3), got {raw.dtype} {raw.shape}")


def _profile(grey: Float32Array, x: float, y: float, step: float = 0.5) -> tuple[FloatArray, FloatArray]:
    """Return radii and the jumps of brightness outwards between circles around (x, y), robustly over directions."""
    most = min(x, y, grey.shape[1] - 1 - x, grey.shape[0] - 1 - y)
    radius = np.arange(2.0, max(most, 4.0), step)
    angle = np.arange(180) * (TAU / 180)
    at_x = (x + radius[:, np.newaxis] * np.cos(angle)).astype(np.float32)
    at_y = (y + radius[:, np.newaxis] * np.sin(angle)).astype(np.float32)
    rings = cv2.remap(grey, at_x, at_y, cv2.INTER_LINEAR).astype(np.float64)
    reach = 4
    jumps = rings[2 * reach :] - rings[: -2 * reach]
    middle = radius[reach:-reach]
    return middle, np.asarray(np.abs(np.median(jumps, axis=1)), np.float64)


def _rims(profile: tuple[FloatArray, FloatArray]) -> tuple[float, float]:
    """Return the two rims: the strongest jump, and the strongest at least a sixth of the radius away from it."""
    radius, jump = profile
    first = int(jump.argmax())
    gap = max(float(radius[-1]) / 6.0, 4.0)
    apart = np.where(np.abs(radius - radius[first]) >= gap, jump, -1.0)
    second = int(apart.argmax())
    low, high = sorted((_peak(radius, jump, first), _peak(radius, jump, second)))
    return low, high


def _peak(radius: FloatArray, jump: FloatArray, at: int) -> float:
    near = slice(max(at - 5, 0), at + 6)
    weight = np.maximum(jump[near] - 0.5 * jump[at], 0.0)
    return float(np.sum(weight * radius[near]) / max(float(weight.sum()), 1e-9))


def _centre(grey: Float32Array) -> tuple[float, float]:
    """Climb to where the rims are sharpest, from the picture's middle, in ever smaller steps."""
    x, y = (grey.shape[1] - 1) / 2.0, (grey.shape[0] - 1) / 2.0
    step = max(grey.shape) / 16.0
    while step >= 0.25:
        tried = [(x + i * step, y + j * step) for j in (-1, 0, 1) for i in (-1, 0, 1)]
        best = max(tried, key=lambda p: _sharpness(grey, *p))
        step = step / 2.0 if best == (x, y) else step
        x, y = best
    return x, y


def _sharpness(grey: Float32Array, x: float, y: float) -> float:
    if min(x, y, grey.shape[1] - 1 - x, grey.shape[0] - 1 - y) < 0.2 * min(grey.shape):
        return -1.0
    jump = np.sort(_profile(grey, x, y, 1.0)[1])
    return float(np.square(jump[-8:]).sum())


def _turned(raw: Image, mirror: MirrorRig, reference: Panorama) -> MirrorRig:
    """Choose nose, sense of rotation and which rim is the floor by the reference panorama."""
    tried = []
    for turn in ("counter-clockwise", "clockwise"):
        for floor in (True, False):
            rig = replace(mirror, turn=turn, inner_is_floor=floor)
            shift, score = _shift(unwrap(raw, rig, reference.rig), reference)
            sign = -1.0 if turn == "counter-clockwise" else 1.0
            tried.append((score, replace(rig, forward=math.remainder(rig.forward + sign * shift, TAU))))
    return max(tried, key=lambda t: t[0])[1]


def _shift(seen: Panorama, reference: Panorama) -> tuple[float, float]:
    """Return the bearing [rad] in `seen` of the reference's nose, and how well the two correlate there."""
    a, b = (_standard(p.image) for p in (seen, reference))
    product = np.fft.rfft(a, axis=1) * np.conj(np.fft.rfft(b, axis=1))
    curve = np.fft.irfft(product.sum(axis=0), n=a.shape[1]) / a.size
    best = int(curve.argmax())
    return best * TAU / a.shape[1], float(curve[best])


def _standard(image: Image) -> FloatArray:
    values = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float64)
    return np.asarray((values - values.mean()) / max(float(values.std()), 1e-6), np.float64)
