"""What the optics do to the light: vignetting, lenses that differ in colour, supports of a mirror."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sim2d.config import LensConfig
from sim2d.records import CameraRig

SOFT_DEG = 1.0  # [degree] over which one lens is blended into the next


def transmission(rig: CameraRig, config: LensConfig, rng: np.random.Generator) -> NDArray[np.float32] | None:
    """Return the share of light (H, W, 3) that reaches each pixel, or None where the optics change nothing.

    The first lens looks along the nose; lenses share the turn evenly, and each has colour gains of its own.
    """
    if not (config.vignetting or config.seam or config.supports):
        return None
    columns: NDArray[np.float64] = np.arange(-rig.forward_column, rig.width - rig.forward_column) * math.tau / rig.width
    light = _vignette(rig, config, columns)[:, :, None] * _colours(config, columns, rng)[None]
    light *= _supports(config, columns)[None, :, None]
    out: NDArray[np.float32] = light.astype(np.float32)
    return out


def _vignette(rig: CameraRig, config: LensConfig, columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the share (H, W) that is left away from the axes of the lenses, 1 - vignetting at the corners."""
    half = math.pi / config.lenses
    aside = np.abs(np.remainder(columns + half, 2 * half) - half) / half
    rows = np.abs(np.arange(rig.height) - rig.horizon_row)
    upright = rows / max(float(rows.max()), 1.0)
    lost: NDArray[np.float64] = config.vignetting * 0.5 * (aside[None] ** 2 + upright[:, None] ** 2)
    return 1.0 - lost


def _colours(config: LensConfig, columns: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """Return the colour gains (W, 3), which change from lens to lens within a degree."""
    gains = np.exp(rng.normal(0.0, config.seam, (config.lenses, 3)))
    place = np.remainder(columns / math.tau * config.lenses + 0.5, config.lenses)
    lens = np.floor(place).astype(int) % config.lenses
    soft = math.radians(SOFT_DEG) / math.tau * config.lenses
    share = np.clip((place - np.floor(place)) / soft, 0.0, 1.0)[:, None]
    out: NDArray[np.float64] = share * gains[lens] + (1 - share) * gains[lens - 1]
    return out


def _supports(config: LensConfig, columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return 0 (W,) where a bar that holds the mirror stands before the view, 1 elsewhere; the first stands behind."""
    if not config.supports:
        return np.ones(len(columns))
    apart = math.tau / config.supports
    off = np.abs(np.remainder(columns - math.pi + apart / 2, apart) - apart / 2)
    return (off > math.radians(config.support_deg) / 2).astype(float)
