"""Checks of a reading's arrays: image, encoded image, ranges, covariance."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import Image
from topomap.core.encoded import decode
from topomap.core.errors import DataError
from topomap.core.robot import Reading
from topomap.navigation.robot_check.finding import Finding, Findings, Readings

FAR = 200.0
"""[m] Median range beyond which it can't be metres: scanners of robots reach 100 m, and rooms end before."""
SYMMETRIC = 1e-9


def check_image(seen: Readings) -> Findings:
    """Find images that aren't (H, W, 3) uint8 as the rig says."""
    for reading in seen:
        image, rig = reading.image, reading.rig
        if not isinstance(image, np.ndarray) or image.dtype != np.uint8:
            kind = image.dtype if isinstance(image, np.ndarray) else type(image).__name__
            return [Finding("image", f"is {kind}, it must be a uint8 array")]
        if image.shape != (rig.height, rig.width, 3):
            return [Finding("image", f"is {image.shape}, the rig says ({rig.height}, {rig.width}, 3)")]
    return []


def check_encoded(seen: Readings) -> Findings:
    """Find bytes that aren't the image: the stack must see what is logged."""
    for reading in seen:
        try:
            logged = decode(bytes(reading.encoded))
        except (DataError, TypeError):
            return [Finding("encoded", "can't be decoded as PNG or JPEG")]
        if wrong := _difference(logged, reading.image):
            return [Finding("encoded", wrong)]
    return []


def _difference(logged: Image, image: Image) -> str:
    if logged.shape != image.shape:
        return f"decodes to {logged.shape}, the image is {image.shape}"
    if np.array_equal(logged, image):
        return ""
    swapped = np.abs(logged[..., ::-1].astype(int) - image).mean() < 0.3 * np.abs(logged.astype(int) - image).mean()
    if swapped:
        return "has red and blue swapped against the image, which must be RGB (OpenCV writes and reads BGR)"
    return "decodes to another image than `image`: hand over what the bytes decode to, as topomap.Reading does"


def check_ranges(seen: Readings) -> Findings:
    """Find ranges of another length, type or unit, and rays without an echo that aren't NaN."""
    for reading in seen:
        if reading.ranges is not None and (wrong := _ranges(reading)):
            return [Finding("ranges", wrong)]
    return []


def _ranges(reading: Reading) -> str:
    ranges = reading.ranges
    if not isinstance(ranges, np.ndarray) or ranges.shape != (reading.rig.width,):
        shape = getattr(ranges, "shape", type(ranges).__name__)
        return f"are {shape}, the rig says ({reading.rig.width},): one ray a column"
    if ranges.dtype != np.float32:
        return f"are {ranges.dtype}, they must be float32, as the log keeps them"
    known = ranges[~np.isnan(ranges)]
    if np.isinf(known).any() or (known <= 0).any():
        return "hold zero, negative or infinite values: a ray without an echo must be NaN"
    if len(known) and float(np.median(known)) > FAR:
        return f"have a median of {float(np.median(known)):.0f}: are they in millimetres? They must be in metres"
    return ""


def check_covariance(seen: Readings) -> Findings:
    """Find covariances of odometry that no filter can take."""
    for reading in seen[1:] or seen:
        if wrong := _covariance(reading.motion.covariance):
            return [Finding("motion.covariance", wrong)]
    return []


def _covariance(covariance: object) -> str:
    if not isinstance(covariance, np.ndarray) or covariance.shape != (3, 3):
        return f"is {getattr(covariance, 'shape', type(covariance).__name__)}, it must be a (3, 3) array"
    if not np.isfinite(covariance).all():
        return "holds NaN or infinite numbers"
    if not covariance.any():
        return "is all zeros: odometry is never exact; say how far off it may be [m^2, m^2, rad^2]"
    if np.abs(covariance - covariance.T).max() > SYMMETRIC * np.abs(covariance).max():
        return "isn't symmetric"
    least = float(np.linalg.eigvalsh(covariance).min())
    if least <= 0:
        return f"isn't positive definite (least eigenvalue {least:.3g}); every direction needs some variance"
    return ""
