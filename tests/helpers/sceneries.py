"""Views of nothing in particular, parts of which can be hidden."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import Image
from topomap.core.panorama import Panorama
from topomap.vision.image.sectors import SECTORS

WIDTH, PATCH = 720, 20


def scenery(seed: int) -> Image:
    """Patches of grey that are large enough for a signature to keep them."""
    patches = np.random.default_rng(seed).integers(0, 256, (5, WIDTH // PATCH), dtype=np.uint8)
    grey = np.kron(patches, np.ones((PATCH, PATCH), np.uint8))
    return np.repeat(grey[:, :, None], 3, axis=2)


def seen(image: Image) -> Panorama:
    return Panorama(image)


def with_people(image: Image, directions: list[int]) -> Image:
    """The view with something before it in some of SECTORS directions."""
    hidden = image.copy()
    for k in directions:
        left, right = k * WIDTH // SECTORS, (k + 1) * WIDTH // SECTORS
        hidden[:, left:right] = scenery(k + 1)[:, left:right]
    return hidden
