"""The stored views most similar to a given one at any rotation: exact, though most are ruled out uncompared.

The magnitudes of a view's spectrum along the columns don't change when the robot turns, and bound the
difference of two views at any rotation from below. Only the views whose least possible difference is low are compared
exactly.
"""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import Complex64Array, Float32Array, FloatArray, IntArray
from topomap.vision.image.compare import (
    RotationDifferences,
    Signature,
    chosen_differences,
    least_squared_differences,
)
from topomap.vision.image.surroundings import Surroundings
from topomap.vision.matching.spectra_kernels import spectra_powers

FREQUENCIES = 16
BLOCK = 64
AT_MOST = 1024


class PlaceIndex:
    """Signatures of one recipe in the order they came; grows by half; 4.3 to 6.5 kB a view."""

    def __init__(self) -> None:
        self._spectra: Complex64Array = np.zeros((0, 0, 0), np.complex64)
        self._keys: Float32Array = np.zeros((0, 0), np.float32)
        self._powers: FloatArray = np.zeros(0)
        self._count = 0

    def __len__(self) -> int:
        """Return the number of stored views."""
        return self._count

    @property
    def nbytes(self) -> int:
        """How much memory the stored views take [bytes], room for more included."""
        return self._spectra.nbytes + self._keys.nbytes + self._powers.nbytes

    def add(self, view: Signature) -> None:
        """Store a view at the end."""
        if self._count == len(self._spectra):
            size = max(64, self._count * 3 // 2)
            spectra = np.zeros((size, *view.spectrum.shape), np.complex64)
            keys, powers = np.zeros((size, len(_key(view))), np.float32), np.zeros(size)
            if self._count:
                spectra[: self._count], keys[: self._count] = self._spectra, self._keys
                powers[: self._count] = self._powers
            self._spectra, self._keys, self._powers = spectra, keys, powers
        self._count += 1
        self.replace(self._count - 1, view)

    def replace(self, place: int, view: Signature) -> None:
        """Store a view in place of an earlier one."""
        self._spectra[place], self._keys[place] = view.spectrum, _key(view)
        self._powers[place] = spectra_powers(view.spectrum[np.newaxis], view.pixels.shape[1])[0]

    def pixels(self, places: IntArray, columns: int) -> FloatArray:
        """Return the pixels (n, R, C) of some stored views (n,) of so many columns."""
        found: FloatArray = np.fft.irfft(self._spectra[places].astype(np.complex128), n=columns, axis=2)
        return found

    def compare(self, view: Signature, places: IntArray) -> RotationDifferences:
        """Return the differences to some stored views (n,)."""
        if not len(places):
            return RotationDifferences(np.zeros(0, np.float32), np.zeros(0))
        return next(chosen_differences(view, self._spectra, self._powers, [places]))

    def least(self, around: Surroundings, places: IntArray) -> tuple[FloatArray, IntArray]:
        """Return the least mean squared differences (n, C) to some stored views, of all points around, the view rolled
        by 0, 1, .. C-1 columns, and which point it was (n, C).
        """
        pixels = around.views[0].pixels.shape
        rows, columns = int(pixels[0]), int(pixels[1])
        return least_squared_differences(
            (rows, columns), around.spectra, around.powers, self._spectra[places], self._powers[places]
        )

    def search(self, view: Signature, count: int, first: int | None = None) -> tuple[IntArray, RotationDifferences]:
        """Return the `count` views most like this one among [0, first), by default all, best first.

        Exact unless more than 1,024 views could still be better by their keys.
        """
        end = self._count if first is None else min(first, self._count)
        if not end:
            return np.zeros(0, np.int64), self.compare(view, np.zeros(0, np.int64))
        if end <= 4 * BLOCK:
            places = np.arange(end)
            return _best(places, self.compare(view, places), count)
        likeness = self._keys[:end] @ _key(view)
        wanted = min(end, AT_MOST)
        order = np.argpartition(-likeness, wanted - 1)[:wanted]
        order = order[np.argsort(-likeness[order], kind="stable")]
        return _best(order, self._promising(view, order, likeness[order], count), count)

    def _promising(self, view: Signature, order: IntArray, likeness: Float32Array, count: int) -> RotationDifferences:
        """Return the differences to the first views of `order`: to so many that no later one can be among the best."""
        least = np.sqrt(np.maximum(2.0 - 2.0 * likeness.astype(float), 0.0))
        difference, rotation = np.empty(len(order), np.float32), np.empty(len(order))
        starts = range(0, len(order), BLOCK)
        blocks = chosen_differences(view, self._spectra, self._powers, (order[k : k + BLOCK] for k in starts))
        for start in starts:
            if start >= count and least[start] > np.partition(difference[:start], count - 1)[count - 1]:
                return RotationDifferences(difference[:start], rotation[:start])
            found = next(blocks)
            difference[start : start + BLOCK], rotation[start : start + BLOCK] = found.difference, found.rotation
        return RotationDifferences(difference, rotation)


def _best(places: IntArray, found: RotationDifferences, count: int) -> tuple[IntArray, RotationDifferences]:
    """Return the `count` of some places (n,) with the least differences (m <= n,), which are to the first of them."""
    best = np.argsort(found.difference, kind="stable")[:count]
    return places[best], RotationDifferences(found.difference[best], found.rotation[best])


def _key(view: Signature) -> Float32Array:
    """Return a unit-length key: the product of two keys is the most that the two views can correlate at any rotation.

    What the lowest frequencies leave out is one last number (by Cauchy and Schwarz).
    """
    rows, columns = view.pixels.shape
    weight = np.full(view.spectrum.shape[1], 2.0)
    weight[0] = 1.0
    if columns % 2 == 0:
        weight[-1] = 1.0
    magnitudes = np.abs(view.spectrum) * np.sqrt(weight / rows) / columns
    head = magnitudes[:, :FREQUENCIES].ravel()
    rest = float(np.square(magnitudes[:, FREQUENCIES:], dtype=np.float64).sum())
    return np.append(head, np.sqrt(rest)).astype(np.float32)
