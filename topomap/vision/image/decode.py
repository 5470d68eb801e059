"""Encoded panoramas back to pixels."""

from __future__ import annotations

import cv2
import numpy as np

from topomap.core.arrays import Image
from topomap.core.errors import DataError


def decode(encoded: bytes) -> Image:
    """Return the RGB image (H, W, 3) of JPEG or PNG bytes. Raises DataError."""
    image = cv2.imdecode(np.frombuffer(encoded, np.uint8), cv2.IMREAD_COLOR_RGB)
    if image is None:
        raise DataError(f"{len(encoded)} bytes that should be a JPEG or PNG panorama can't be decoded")
    return image.astype(np.uint8, copy=False)
