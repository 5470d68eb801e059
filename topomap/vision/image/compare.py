"""How different two views are: small z-normalised pictures of a panorama and their differences.

The scale of every `rms` here: 0 for the same view, sqrt(2) = 1.4 for unrelated ones.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from topomap.core.arrays import Complex64Array, Float32Array, FloatArray, IntArray
from topomap.core.errors import ShapeError
from topomap.core.geometry import TAU, wrap, wrap_all
from topomap.core.panorama import Panorama
from topomap.vision.matching.spectra_kernels import (
    all_products,
    chosen_products,
    least_differences,
    lowest_points,
    spectra_powers,
    spectra_products,
)

BLANK = 1e-3
"""Standard deviation in grey values below which a picture holds nothing; it is then all zeros."""


@dataclass(frozen=True, slots=True)
class SignatureSpec:
    """The recipe of a signature: columns, rows [pixels], blur (sigma) [signature pixels], colour or grey."""

    columns: int = 90
    rows: int = 10
    blur: float = 1.0
    colour: bool = False


PLACE = SignatureSpec()
ARRIVAL = SignatureSpec(columns=180, rows=25)


@dataclass(frozen=True, slots=True, eq=False)
class Signature:
    """A small view: pixels (R, C) float32 of mean 0 and variance 1 (colour: the channels stacked as rows;
    blank: zeros) and their spectrum (R, C//2 + 1) complex64 along the columns.
    """

    pixels: Float32Array
    spectrum: Complex64Array


def normalised(pixels: Float32Array) -> Float32Array:
    """Return pixels of any shape with mean 0 and variance 1, or zeros where there is nothing to see."""
    deviation = float(pixels.std(dtype=np.float64))
    if deviation < BLANK:
        return np.zeros_like(pixels)
    return ((pixels - np.float32(pixels.mean(dtype=np.float64))) / np.float32(deviation)).astype(np.float32)


def all_normalised(pictures: Float32Array) -> Float32Array:
    """Return pictures (D, R, C), each as `normalised` makes it, to the bit."""
    values = pictures.reshape(len(pictures), -1).astype(np.float64)
    mean = values.mean(axis=1, keepdims=True)
    deviation = np.sqrt(np.square(values - mean).mean(axis=1))
    shape = (len(pictures), *([1] * (pictures.ndim - 1)))
    seen = deviation >= BLANK
    over = np.where(seen, deviation, 1.0).astype(np.float32).reshape(shape)
    result: Float32Array = (pictures - mean.astype(np.float32).reshape(shape)) / over
    result[~seen] = 0.0
    return result


def shrunk(panorama: Panorama, columns: int, rows: int, blur: float = 0.0, colour: bool = False) -> Float32Array:
    """Return the view at (rows, columns[, 3]) float32 grey values, area-averaged, blurred around the seam.

    Output column i is centred on input column (i + 0.5) W/columns - 0.5. A smaller panorama keeps its size.
    """
    picture = panorama.image if colour else cv2.cvtColor(panorama.image, cv2.COLOR_RGB2GRAY)
    size = (min(columns, panorama.rig.width), min(rows, panorama.rig.height))
    small = cv2.resize(picture.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    if blur <= 0.0:
        return np.asarray(small, np.float32)
    pad = min(int(np.ceil(4 * blur)), size[0])
    wrapped = cv2.copyMakeBorder(small, 0, 0, pad, pad, cv2.BORDER_WRAP)
    blurred = cv2.GaussianBlur(wrapped, (0, 0), blur, borderType=cv2.BORDER_REPLICATE)
    return np.ascontiguousarray(blurred[:, pad : pad + size[0]], np.float32)


def signature(panorama: Panorama, spec: SignatureSpec = PLACE) -> Signature:
    """Return the panorama's signature, computed once per panorama and recipe."""
    return panorama.derived(spec, lambda p: _signature(p, spec))


def _signature(panorama: Panorama, spec: SignatureSpec) -> Signature:
    small = shrunk(panorama, spec.columns, spec.rows, spec.blur, spec.colour)
    if spec.colour:
        small = np.concatenate([small[:, :, c] for c in range(3)])
    pixels = normalised(small)
    return Signature(pixels, np.fft.rfft(pixels, axis=1).astype(np.complex64))


def rms(a: Signature, b: Signature) -> float:
    """Return the root mean square difference of two aligned signatures. Raises ShapeError."""
    return float(np.sqrt(np.mean(np.square(_difference(a, b)), dtype=np.float64)))


def mean_abs(a: Signature, b: Signature) -> float:
    """Return the mean absolute difference of two aligned signatures. Raises ShapeError."""
    return float(np.mean(np.abs(_difference(a, b)), dtype=np.float64))


def _difference(a: Signature, b: Signature) -> Float32Array:
    if a.pixels.shape != b.pixels.shape:
        raise ShapeError(f"signatures differ in shape: {a.pixels.shape} and {b.pixels.shape}")
    return a.pixels - b.pixels


def turned(view: Signature, angles: FloatArray) -> FloatArray:
    """Return a view's pixels (N, R, C) as seen by a robot turned back by angles (N,) [rad], to any fraction."""
    frequencies = np.arange(view.spectrum.shape[1])
    phases = np.exp(-1j * frequencies[None] * (angles % TAU)[:, None])
    rolled: FloatArray = np.fft.irfft(view.spectrum[None] * phases[:, None, :], n=view.pixels.shape[1], axis=2)
    return rolled


def sector_means(values: FloatArray, sectors: int) -> FloatArray:
    """Return the means (N, sectors) of values (N, C) over equal parts of all columns."""
    columns = values.shape[1]
    bounds = np.linspace(0, columns, sectors, endpoint=False).astype(np.int64)
    means: FloatArray = np.add.reduceat(values, bounds, axis=1) / np.diff(np.append(bounds, columns))
    return means


@dataclass(frozen=True, slots=True, eq=False)
class RotationDifferences:
    """For each of N stored views: difference (N,), the rms minimised over rotation, and rotation (N,) [rad],
    as in `Alignment`: the current heading minus the stored one.
    """

    difference: Float32Array
    rotation: FloatArray


def rotation_difference(current: Signature, stored: Signature) -> tuple[float, float]:
    """Return the rotation-minimised rms of two signatures and the rotation [rad]. Raises ShapeError."""
    found = rotation_differences(current, stored.spectrum[np.newaxis])
    return float(found.difference[0]), float(found.rotation[0])


def rotation_within(current: Signature, stored: Signature, middle: float, reach: float) -> tuple[float, float]:
    """Return the least rms of two signatures over rotations [rad] within `reach` of `middle`, and that rotation.

    Raises ShapeError.
    """
    if stored.spectrum.shape != current.spectrum.shape:
        raise ShapeError(f"signatures differ in shape: {stored.pixels.shape} and {current.pixels.shape}")
    squares = squared_differences(current, stored.spectrum[np.newaxis])[0]
    columns = len(squares)
    steps = np.arange(math.ceil((middle - reach) * columns / TAU), math.floor((middle + reach) * columns / TAU) + 1)
    best = int(steps[squares[steps % columns].argmin()]) if len(steps) else round(middle * columns / TAU)
    below, here, above = (squares[[(best + step) % columns]] for step in (-1, 0, 1))
    offset, low = parabola(below, here, above)
    rotation = wrap(float(best + offset[0]) * TAU / columns)
    return math.sqrt(max(float(low[0]), 0.0)), rotation


def rotation_differences(
    current: Signature, spectra: Complex64Array, powers: FloatArray | None = None
) -> RotationDifferences:
    """Compare with N stored spectra (N, R, C//2 + 1) at every rotation at once, to a fraction of a column.

    powers (N,): theirs, where they are known. Raises ShapeError.
    """
    if spectra.shape[1:] != current.spectrum.shape:
        raise ShapeError(f"stored spectra are {spectra.shape[1:]}, the signature's is {current.spectrum.shape}")
    theirs = spectra_powers(spectra, current.pixels.shape[1]) if powers is None else powers
    return _rotated(current, spectra_products(spectra, np.conj(current.spectrum)), theirs, _power(current))


def chosen_differences(
    current: Signature, spectra: Complex64Array, powers: FloatArray, blocks: Iterable[IntArray]
) -> Iterator[RotationDifferences]:
    """Compare as `rotation_differences` does with some blocks (n,) of stored spectra (N, R, C//2 + 1), one by one."""
    own, conjugate = _power(current), np.conj(current.spectrum)
    for block in blocks:
        yield _rotated(current, chosen_products(spectra, block, conjugate), powers[block], own)


def _rotated(current: Signature, products: Complex64Array, theirs: FloatArray, own: float) -> RotationDifferences:
    """Return the differences by the products (N, C//2 + 1) of spectra, and powers theirs (N,) and own."""
    rows, columns = current.pixels.shape
    correlation = np.fft.irfft(products, n=columns, axis=1)
    where, low = lowest_points(theirs, own, correlation, np.float32(2.0 / (rows * columns)))
    rotation = wrap_all(where * (TAU / columns))
    return RotationDifferences(np.sqrt(np.maximum(low, 0.0)).astype(np.float32), rotation)


def _power(current: Signature) -> float:
    return float(np.square(current.pixels, dtype=np.float64).mean())


def squared_differences(current: Signature, spectra: Complex64Array, powers: FloatArray | None = None) -> FloatArray:
    """Return the mean squared difference (N, C) of stored views to the current one rolled by 0, 1, .. C-1
    columns.

    powers (N,): of the stored views, where they are known.
    """
    rows, columns = current.pixels.shape
    products = spectra_products(spectra, np.conj(current.spectrum))
    theirs = spectra_powers(spectra, columns) if powers is None else powers
    correlation = np.fft.irfft(products, n=columns, axis=1)
    result: FloatArray = theirs[:, np.newaxis] + _power(current) - (2.0 / (rows * columns)) * correlation
    return result


def powers(pixels: Float32Array) -> FloatArray:
    """Return the mean squares (D,) of the pixels (D, R, C) of views: 1 but for rounding, 0 for blank ones."""
    squares: FloatArray = np.square(pixels.reshape(len(pixels), -1), dtype=np.float64)
    return np.asarray(squares.mean(axis=1))


def least_squared_differences(
    pixels: tuple[int, int], spectra: Complex64Array, own: FloatArray, stored: Complex64Array, theirs: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Return the least of the squared differences (N, C) of N stored views to D others, and whose it is (N, C): what
    `squared_differences` returns for one after the other, to the bit.

    pixels: rows and columns of a view; spectra (D, R, C//2 + 1) with powers own (D,), stored (N, R, C//2 + 1) with
    powers theirs (N,).
    """
    rows, columns = pixels
    correlation = np.fft.irfft(all_products(stored, np.conj(spectra)), n=columns, axis=2)
    scale = np.float32(2.0 / (rows * columns))
    found: tuple[FloatArray, IntArray] = least_differences(theirs, own, correlation, scale)
    return found


def parabola(below: FloatArray, here: FloatArray, above: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the offset (N,) in [-0.5, 0.5] and value (N,) of the minimum through three neighbours."""
    bend = below - 2.0 * here + above
    safe = np.where(bend > 1e-12, bend, np.inf)
    offset = np.clip(0.5 * (below - above) / safe, -0.5, 0.5)
    return offset, here - 0.25 * (below - above) * offset
