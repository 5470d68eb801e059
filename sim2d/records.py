"""What the simulated robot hands over: frozen records of primitives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

EPOCH_NS = 1_700_000_000 * 1_000_000_000


@dataclass(frozen=True, slots=True)
class CameraRig:
    """How the panorama was taken: width, height [pixels]; row of eye level; focal [pixels]; camera height [m]."""

    width: int
    height: int
    horizon_row: float
    focal: float
    camera_height: float
    forward_column: int
    clockwise: bool


@dataclass(frozen=True, slots=True, eq=False)
class OdometerReading:
    """An arc as read: forward along it [m], left (always 0) [m], turn [rad]; covariance (3, 3); dt [s]."""

    forward: float
    left: float
    turn: float
    covariance: NDArray[np.float64]
    dt: float


@dataclass(frozen=True, slots=True, eq=False)
class SimReading:
    """One step's senses: image (H, W, 3) uint8 RGB decoded from `encoded`; ranges (R,) float32 [m], NaN for nothing."""

    stamp_ns: int
    image: NDArray[np.uint8]
    encoded: bytes
    ranges: NDArray[np.float32] | None
    motion: OdometerReading
    rig: CameraRig
    contact: bool
    driven: bool


@dataclass(frozen=True, slots=True)
class SetDown:
    """Where a robot is set down in mid-run: pose x, y [m], heading [rad], and the number of its first step."""

    pose: tuple[float, float, float]
    step: int = 0


@dataclass(frozen=True, slots=True)
class SimTruth:
    """The true pose in the world's frame [m, rad] at a stamp; contact: the body touches something."""

    stamp_ns: int
    x: float
    y: float
    heading: float
    contact: bool


@dataclass(frozen=True, slots=True)
class TrueCalibration:
    """The systematic errors that were drawn for a run (convention: `sim2d.config.OdometerConfig`)."""

    rotation_scale: float
    distance_scale: float
    curvature: float
