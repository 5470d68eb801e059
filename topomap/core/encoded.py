"""Panoramas as PNG or JPEG bytes, and back to pixels."""

from __future__ import annotations

import struct

import cv2
import numpy as np

from topomap.core.arrays import Image
from topomap.core.errors import DataError, ShapeError

MOST_PIXELS = 2**26
"""Pixels of a picture at most: 200 MB, ten times a large camera's; a small file may say that it has a thousand times
that."""


def decode(encoded: bytes) -> Image:
    """Return the RGB image (H, W, 3) of JPEG or PNG bytes. Raises DataError."""
    width, height = image_size(encoded) or (0, 0)
    if width * height > MOST_PIXELS:
        raise DataError(f"an image of {width} x {height} pixels is larger than the {MOST_PIXELS} that are read")
    try:
        image = cv2.imdecode(np.frombuffer(encoded, np.uint8), cv2.IMREAD_COLOR_RGB) if encoded else None
    except cv2.error:  # of other kinds of files it refuses sizes itself
        image = None
    if image is None:
        raise DataError(f"{len(encoded)} bytes that should be a JPEG or PNG panorama can't be decoded")
    return image.astype(np.uint8, copy=False)


def encode(image: Image, quality: int | None = None) -> bytes:
    """Return an RGB image (H, W, 3) uint8 as PNG (lossless), or as JPEG of a quality in 1..100. Raises ShapeError."""
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or not image.size:
        raise ShapeError(f"image is {image.dtype} {image.shape}, it must be uint8 (H, W, 3), RGB")
    bgr = np.ascontiguousarray(image[:, :, ::-1])
    if quality is None:
        return cv2.imencode(".png", bgr)[1].tobytes()
    return cv2.imencode(".jpg", bgr, (cv2.IMWRITE_JPEG_QUALITY, quality))[1].tobytes()


def image_size(encoded: bytes) -> tuple[int, int] | None:
    """Return width and height [pixels] of PNG or JPEG bytes by their headers, undecoded; None for anything else."""
    if encoded[:8] == b"\x89PNG\r\n\x1a\n" and len(encoded) >= 24:
        width, height = struct.unpack(">II", encoded[16:24])
        return width, height
    return _jpeg_size(encoded) if encoded[:2] == b"\xff\xd8" else None


def _jpeg_size(encoded: bytes) -> tuple[int, int] | None:
    """Return the size that the frame header of a JPEG image says: the marker SOFn, after others of known length."""
    place = 2
    while place + 9 <= len(encoded) and encoded[place] == 0xFF:
        marker, length = encoded[place + 1], int.from_bytes(encoded[place + 2 : place + 4], "big")
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack(">HH", encoded[place + 5 : place + 9])
            return width, height
        place += 2 + length
    return None
