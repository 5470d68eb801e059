"""The table of a drive: stamps, image files, odometry and, where it is known, the truth."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.errors import DataError
from topomap.core.files import regular
from topomap.core.geometry import between, wrap_all

NAME = "drive.csv"
INCREMENTS = ("forward_m", "turn_rad")
SUMMED = ("odom_x_m", "odom_y_m", "odom_heading_rad")
SIGMAS = ("forward_sigma_m", "left_sigma_m", "turn_sigma_rad")
POSES = ("x_m", "y_m", "heading_rad")
SECOND = 1_000_000_000  # [ns]
FORWARD_NOISE, TURN_NOISE = 0.04, math.radians(1.0)
"""[m and rad per square-root metre] What an odometer that tells no errors is taken for at first: twice the simulator's.
"""
HALF_TRACK = 0.15  # [m] what wheels roll per radian of turning on the spot, in a robot of 0.3 m


@dataclass(frozen=True, slots=True, eq=False)
class DriveTable:
    """A drive of N readings.

    stamps_ns (N,); images (N,): files; deltas (N, 3): forward [m], left [m], turn [rad] since the reading before (the
    first: none), as the odometer read them; covariances (N, 3, 3) of these; truth (N, 3): x, y [m], heading [rad, NaN
    where only positions are known], or None; odometry: where the increments come from, in words.
    """

    stamps_ns: IntArray
    images: tuple[Path, ...]
    deltas: FloatArray
    covariances: FloatArray
    truth: FloatArray | None
    odometry: str

    def __len__(self) -> int:
        return len(self.stamps_ns)


def read_table(path: Path) -> DriveTable:
    """Read a drive's table. Raises DataError that names file, line, column and value."""
    lines, columns = _columns(path)
    stamps = np.round(_numbers(path, lines, columns, ("stamp_s",))[:, 0] * SECOND).astype(np.int64)
    late = np.flatnonzero(np.diff(stamps) <= 0)
    if len(late):
        value = columns["stamp_s"][late[0] + 1]
        raise DataError(f"{path}:{lines[late[0] + 1]}: stamp_s: {value!r} isn't later than the line before")
    deltas, odometry = _deltas(path, lines, columns)
    truth = None
    if odometry != POSED and "x_m" in columns and "y_m" in columns:
        truth = _poses(path, lines, columns)
    return DriveTable(stamps, _images(path, lines, columns), deltas, _covariances(path, lines, columns, deltas),
                      truth, odometry)  # fmt: skip


def driven_covariances(deltas: FloatArray, forward_noise: float, turn_noise: float) -> FloatArray:
    """Return the covariances (N, 3, 3) of increments (N, 3) whose errors grow with the root of the way.

    forward_noise [m per square-root m], turn_noise [rad per square-root m]; floors keep a standstill invertible.
    """
    way = np.abs(deltas[:, 0]) + np.abs(deltas[:, 1]) + HALF_TRACK * np.abs(deltas[:, 2])
    forward = np.maximum(forward_noise * np.sqrt(way), 1e-4)
    covariances = np.zeros((len(deltas), 3, 3))
    covariances[:, 0, 0] = forward**2
    covariances[:, 1, 1] = np.maximum(0.25 * forward, 1e-4) ** 2
    covariances[:, 2, 2] = np.maximum(turn_noise * np.sqrt(way), 1e-5) ** 2
    return covariances


POSED = "increments of x_m, y_m, heading_rad"


def increments(poses: FloatArray) -> FloatArray:
    """Return the arcs (N, 3) between poses (N, 3): forward and left along the heading in the middle of the turn."""
    steps = between(poses[:-1], poses[1:])
    half = wrap_all(steps[:, 2]) / 2
    c, s = np.cos(half), np.sin(half)
    forward, left = c * steps[:, 0] + s * steps[:, 1], c * steps[:, 1] - s * steps[:, 0]
    return np.vstack([np.zeros((1, 3)), np.column_stack([forward, left, 2 * half])])


def _columns(path: Path) -> tuple[list[int], dict[str, list[str]]]:
    """Return the line of each reading and the words of each column."""
    try:
        reader = csv.DictReader(regular(path).read_text(encoding="utf8").splitlines(), skipinitialspace=True)
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: can't be read: {getattr(error, 'strerror', None) or error}") from error
    names = [name.strip() for name in reader.fieldnames or []]
    reader.fieldnames = names
    for name in ("stamp_s", "image"):
        if name not in names:
            raise DataError(f"{path}:1: there is no column {name!r}; there are {', '.join(names) or 'none'}")
    rows = [(reader.line_num, row) for row in reader]
    if len(rows) < 2:
        raise DataError(f"{path}: holds {len(rows)} readings; a drive needs at least 2")
    return [line for line, _ in rows], {name: [row[name] or "" for _, row in rows] for name in names}


def _numbers(path: Path, lines: list[int], columns: dict[str, list[str]], names: tuple[str, ...]) -> FloatArray:
    values = np.empty((len(lines), len(names)))
    for k, name in enumerate(names):
        for row, (line, word) in enumerate(zip(lines, columns[name], strict=True)):
            try:
                values[row, k] = float(word)
            except ValueError:
                values[row, k] = np.nan
            if not math.isfinite(values[row, k]):
                raise DataError(f"{path}:{line}: {name}: {word!r} is no finite number")
    return values


def _deltas(path: Path, lines: list[int], columns: dict[str, list[str]]) -> tuple[FloatArray, str]:
    """Return the increments (N, 3) and where they come from."""
    if all(name in columns for name in INCREMENTS):
        names = ("forward_m", "left_m", "turn_rad") if "left_m" in columns else INCREMENTS
        values = _numbers(path, lines, columns, names)
        left = values[:, 1] if len(names) == 3 else np.zeros(len(values))
        deltas = np.column_stack([values[:, 0], left, values[:, -1]])
        deltas[0] = 0.0
        return deltas, f"increments {', '.join(names)}"
    if all(name in columns for name in SUMMED):
        return increments(_numbers(path, lines, columns, SUMMED)), f"increments of {', '.join(SUMMED)}"
    if all(name in columns for name in POSES):
        return increments(_numbers(path, lines, columns, POSES)), POSED
    wanted = " or ".join(", ".join(names) for names in (INCREMENTS, SUMMED, POSES))
    raise DataError(f"{path}:1: there is no odometry: give the columns {wanted}")


def _poses(path: Path, lines: list[int], columns: dict[str, list[str]]) -> FloatArray:
    if "heading_rad" in columns:
        return _numbers(path, lines, columns, POSES)
    places = _numbers(path, lines, columns, POSES[:2])
    return np.column_stack([places, np.full(len(places), np.nan)])


def _covariances(path: Path, lines: list[int], columns: dict[str, list[str]], deltas: FloatArray) -> FloatArray:
    if not all(name in columns for name in SIGMAS):
        return driven_covariances(deltas, FORWARD_NOISE, TURN_NOISE)
    sigmas = _numbers(path, lines, columns, SIGMAS)
    return np.asarray(np.einsum("ni,ij->nij", sigmas**2, np.eye(3)))


def _images(path: Path, lines: list[int], columns: dict[str, list[str]]) -> tuple[Path, ...]:
    files = [path.parent / word for word in columns["image"]]
    for line, word, file in zip(lines, columns["image"], files, strict=True):
        if not word or not file.is_file():
            raise DataError(f"{path}:{line}: image: there is no file {word!r}")
    return tuple(files)
