"""The ring around the horizon: a panorama's middle rows, averaged in a few bands, as sequences over the
bearing.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from topomap.core.arrays import Float32Array
from topomap.core.panorama import Panorama
from topomap.vision.image.compare import normalised


@dataclass(frozen=True, slots=True)
class RingSpec:
    """The recipe: columns; bands between top and bottom (shares of the height); blur (sigma) [columns];
    colour.
    """

    columns: int = 360
    bands: int = 5
    top: float = 0.25
    bottom: float = 0.75
    blur: float = 1.0
    colour: bool = True


RING = RingSpec()


def ring(panorama: Panorama, spec: RingSpec) -> Float32Array:
    """Return the bands (F, C) float32, of mean 0 and variance 1 over all, computed once per panorama and
    recipe.
    """
    return panorama.derived(spec, lambda p: _ring(p, spec))


def _ring(panorama: Panorama, spec: RingSpec) -> Float32Array:
    height, width = panorama.image.shape[:2]
    rows = panorama.image[round(spec.top * height) : max(round(spec.bottom * height), 1)]
    columns = min(spec.columns, width)
    picture = rows if spec.colour else cv2.cvtColor(rows, cv2.COLOR_RGB2GRAY)[:, :, np.newaxis]
    small = cv2.resize(picture.astype(np.float32), (columns, spec.bands), interpolation=cv2.INTER_AREA)
    bands = small.reshape(spec.bands, columns, -1).transpose(2, 0, 1).reshape(-1, columns)
    return normalised(_blurred(np.ascontiguousarray(bands), spec.blur))


def _blurred(bands: Float32Array, sigma: float) -> Float32Array:
    if sigma <= 0.0:
        return bands
    reach = min(int(np.ceil(3 * sigma)), bands.shape[1])
    taps = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2).astype(np.float32)
    wrapped = np.concatenate([bands[:, -reach:], bands, bands[:, :reach]], axis=1)
    kernel = (taps / taps.sum()).reshape(1, -1)
    return np.ascontiguousarray(cv2.filter2D(wrapped, -1, kernel)[:, reach : reach + bands.shape[1]])
