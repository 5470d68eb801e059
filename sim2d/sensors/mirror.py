"""Other projections of the cylinder: the tilted mount, and the raw image of an omnidirectional mirror."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from sim2d.records import CameraRig

Image = NDArray[np.uint8]
Map = NDArray[np.float32]
PAD = 2  # columns beyond the seam, for interpolation


@dataclass(frozen=True, slots=True)
class MirrorRig:
    """The raw image of an upward-looking camera under a mirror: a ring around its centre.

    width, height [pixels]; centre_x, centre_y [pixels, x right, y down]; the panorama's last row lies on the circle of
    inner_radius and its first row on that of outer_radius [pixels], rows evenly between; forward_angle [rad]: where the
    nose points in the image, counter-clockwise from the right as it is looked at; clockwise: bearings grow clockwise.
    """

    width: int = 480
    height: int = 480
    centre_x: float = 239.5
    centre_y: float = 239.5
    inner_radius: float = 60.0
    outer_radius: float = 230.0
    forward_angle: float = math.pi / 2
    clockwise: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Tilt:
    """A camera's tilt: for every pixel its column and row on the upright cylinder, None where it stands upright."""

    maps: tuple[Map, Map] | None

    @staticmethod
    def of(rig: CameraRig, roll: float, pitch: float) -> Tilt:
        """Return the tilt by roll (to the right) and pitch (forward) [rad]."""
        return Tilt(tilt_map(rig, roll, pitch) if roll or pitch else None)


def mirror_map(rig: CameraRig, mirror: MirrorRig) -> tuple[Map, Map, NDArray[np.bool_]]:
    """Return for every pixel of the raw image its column and row in the panorama, and whether it shows any of it."""
    y, x = np.mgrid[: mirror.height, : mirror.width].astype(np.float64)
    right, up = x - mirror.centre_x, mirror.centre_y - y
    radius = np.hypot(right, up)
    bearing = np.arctan2(up, right) - mirror.forward_angle
    bearing = -bearing if mirror.clockwise else bearing
    share = (mirror.outer_radius - radius) / (mirror.outer_radius - mirror.inner_radius)
    seen = (share >= 0) & (share <= 1)
    return _columns(rig, bearing), (share * (rig.height - 1)).astype(np.float32), seen


def mirror_image(panorama: Image, rig: CameraRig, mirror: MirrorRig) -> Image:
    """Return the raw image (mirror.height, mirror.width, 3) of a recorded panorama (H, W, 3), black elsewhere."""
    columns, rows, seen = mirror_map(rig, mirror)
    image = sampled(panorama, columns, rows)
    image[~seen] = 0
    return image


def tilt_map(rig: CameraRig, roll: float, pitch: float) -> tuple[Map, Map]:
    """Return for every pixel of a tilted camera its column and row, relative to eye level, on the upright cylinder.

    roll [rad]: leaning to the right; pitch [rad]: leaning forward. Rays are turned, cylinder to cylinder.
    """
    rows, columns = np.mgrid[: rig.height, : rig.width].astype(np.float64)
    turn = math.tau / rig.width
    bearing = (columns - rig.forward_column) * (-turn if rig.clockwise else turn)
    ray = np.stack([np.cos(bearing), np.sin(bearing), (rig.horizon_row - rows) / rig.focal])
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    # x ahead, y left, z up: leaning right is a positive turn about x, leaning forward one about y
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    ahead, left, up = np.tensordot(about_y @ about_x, ray, axes=1)
    below = -rig.focal * up / np.hypot(ahead, left)
    return _columns(rig, np.arctan2(left, ahead)), below.astype(np.float32)


def sampled(panorama: Image, columns: Map, rows: Map) -> Image:
    """Return a panorama (H, W, 3) at fractional columns (wrapped round) and rows (held at the edges), bilinearly."""
    ring = np.concatenate([panorama[:, -PAD:], panorama, panorama[:, :PAD]], axis=1)
    wrapped = np.mod(columns, np.float32(panorama.shape[1])) + np.float32(PAD)
    return np.asarray(cv2.remap(ring, wrapped, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), dtype=np.uint8)


def _columns(rig: CameraRig, bearing: NDArray[np.float64]) -> Map:
    """Return the recorded columns of bearings [rad]."""
    step = rig.width / math.tau
    columns = rig.forward_column + bearing * (-step if rig.clockwise else step)
    return np.mod(columns, rig.width).astype(np.float32)
