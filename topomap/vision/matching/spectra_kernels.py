"""Products and powers of pictures' spectra, compiled: the same input gives the same bits."""

from __future__ import annotations

import numpy as np
from numba import njit

from topomap.core.arrays import Complex64Array, Float32Array, FloatArray, IntArray


@njit(cache=True)
def spectra_products(spectra: Complex64Array, conjugate: Complex64Array) -> Complex64Array:
    """Return the sum over rows of spectra (N, R, F) times conjugate (R, F): (N, F).

    Real and imaginary parts apart: the compiler then takes eight lines at once, and the bits stay the same.
    """
    count, rows, lines = spectra.shape
    products = np.empty((count, lines), np.complex64)
    real, imaginary = np.empty(lines, np.float32), np.empty(lines, np.float32)
    for n in range(count):
        real[:], imaginary[:] = 0.0, 0.0
        for r in range(rows):
            for f in range(lines):
                a, b = spectra[n, r, f], conjugate[r, f]
                real[f] += a.real * b.real - a.imag * b.imag
                imaginary[f] += a.real * b.imag + a.imag * b.real
        for f in range(lines):
            products[n, f] = complex(real[f], imaginary[f])
    return products


@njit(cache=True)
def chosen_products(spectra: Complex64Array, chosen: IntArray, conjugate: Complex64Array) -> Complex64Array:
    """Return what `spectra_products` returns for some (n,) of spectra (N, R, F): (n, F), without a copy of these."""
    products = np.empty((len(chosen), spectra.shape[2]), np.complex64)
    for k in range(len(chosen)):
        products[k] = spectra_products(spectra[chosen[k] : chosen[k] + 1], conjugate)[0]
    return products


@njit(cache=True)
def lowest_points(
    theirs: FloatArray, own: float, correlation: Float32Array, scale: np.float32
) -> tuple[FloatArray, FloatArray]:
    """Return where the parabola through the least of theirs (N,) + own - scale * correlation (N, C) and its neighbours
    has its bottom (N,) [columns], and its value (N,).
    """
    count, columns = correlation.shape
    where, low = np.empty(count), np.empty(count)
    for n in range(count):
        both = theirs[n] + own
        best, here = 0, both - scale * correlation[n, 0]
        for c in range(1, columns):
            value = both - scale * correlation[n, c]
            if value < here:
                best, here = c, value
        below = both - scale * correlation[n, (best - 1) % columns]
        above = both - scale * correlation[n, (best + 1) % columns]
        bend = below - 2.0 * here + above
        offset = 0.5 * (below - above) / bend if bend > 1e-12 else 0.0
        offset = min(max(offset, -0.5), 0.5)
        where[n], low[n] = best + offset, here - 0.25 * (below - above) * offset
    return where, low


@njit(cache=True)
def all_products(spectra: Complex64Array, conjugates: Complex64Array) -> Complex64Array:
    """Return what `spectra_products` returns for each of conjugates (D, R, F): (D, N, F)."""
    products = np.empty((conjugates.shape[0], spectra.shape[0], spectra.shape[2]), np.complex64)
    for d in range(conjugates.shape[0]):
        products[d] = spectra_products(spectra, conjugates[d])
    return products


@njit(cache=True)
def least_differences(
    theirs: FloatArray, own: FloatArray, correlation: Float32Array, scale: np.float32
) -> tuple[FloatArray, IntArray]:
    """Return the least of theirs (N,) + own (D,) - scale * correlation (D, N, C) over D, and the first that has it."""
    views, count, columns = correlation.shape
    least, which = np.full((count, columns), np.inf), np.zeros((count, columns), np.int64)
    for d in range(views):
        for n in range(count):
            both = theirs[n] + own[d]
            for c in range(columns):
                value = both - scale * correlation[d, n, c]
                if value < least[n, c]:
                    least[n, c], which[n, c] = value, d
    return least, which


@njit(cache=True)
def spectra_powers(spectra: Complex64Array, columns: int) -> FloatArray:
    """Return each picture's mean power (N,) from its half spectrum (R, F): every line but the first and the Nyquist
    line counts twice (Parseval).
    """
    count, rows, lines = spectra.shape
    powers = np.zeros(count)
    single = lines - 1 if columns % 2 == 0 else lines
    for n in range(count):
        for r in range(rows):
            for f in range(lines):
                value = spectra[n, r, f]
                energy = value.real * value.real + value.imag * value.imag
                powers[n] += energy if f == 0 or f == single else 2.0 * energy
        powers[n] /= rows * columns * columns
    return powers
