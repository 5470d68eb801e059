"""The map-server pair: a small YAML file and the image that it names."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from sim2d.errors import WorldError
from sim2d.files import regular
from sim2d.shapes import Point

Values = dict[str, str]
KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode")

MOST_PIXELS = 2**25
"""Cells of a floor plan at most: 280 m square at 5 cm."""


@dataclass(frozen=True, slots=True, eq=False)
class FloorMap:
    """Free cells (rows, columns) uint8 in {0, 1}, row 0 on top; resolution [m per cell]; origin: pose x, y [m], yaw
    [rad] of the lower left corner in the map frame."""

    free: NDArray[np.uint8]
    resolution: float
    origin: tuple[float, float, float]

    def points(self, cells: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return map coordinates (N, 2) [m] of image places (column, row), where whole numbers are cell centres."""
        x = (cells[:, 0] + 0.5) * self.resolution
        y = (len(self.free) - cells[:, 1] - 0.5) * self.resolution
        c, s = math.cos(self.origin[2]), math.sin(self.origin[2])
        return np.stack([self.origin[0] + c * x - s * y, self.origin[1] + s * x + c * y], axis=-1)

    def cell(self, point: Point) -> tuple[int, int]:
        """Return row and column of map coordinates [m]."""
        dx, dy = point[0] - self.origin[0], point[1] - self.origin[1]
        c, s = math.cos(self.origin[2]), math.sin(self.origin[2])
        column, up = (c * dx + s * dy) / self.resolution, (c * dy - s * dx) / self.resolution
        return len(self.free) - 1 - math.floor(up), math.floor(column)


def read_map(path: Path) -> FloorMap:
    """Return the map of a map.yaml (trinary: what is neither free nor occupied counts as a wall).

    Raises WorldError with one line `FILE: KEY = VALUE: what would be right`.
    """
    values = _read(path)
    resolution = _number(path, values, "resolution", None, 1e-3, 10.0)
    negate = _number(path, values, "negate", 0.0, 0.0, 1.0)
    occupied = _number(path, values, "occupied_thresh", 0.65, 0.0, 1.0)
    free = _number(path, values, "free_thresh", 0.196, 0.0, 1.0)
    if free > occupied:
        raise WorldError(f"{path}: free_thresh = {free:g}: it must not lie above occupied_thresh, {occupied:g}")
    if values.get("mode", "trinary") != "trinary":
        raise WorldError(f"{path}: mode = {values['mode']!r}: only trinary maps are read")
    grey = _image(path, values)
    share = grey / 255.0 if negate else 1.0 - grey / 255.0
    return FloorMap(_largest((share < free).astype(np.uint8), path), resolution, _origin(path, values))


def sources(path: Path) -> tuple[Path, ...]:
    """Return a map.yaml and the picture that it names. Raises WorldError."""
    picture = path.parent / _read(path).get("image", "")
    return (path, picture) if picture.is_file() else (path,)


def _read(path: Path) -> Values:
    """Return the keys of a flat YAML file; lists may be written in brackets or as lines that begin with a dash."""
    try:
        lines = regular(path).read_text(encoding="utf8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise WorldError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from error
    values: Values = {}
    last = ""
    for number, line in enumerate(lines, 1):
        text = line.split("#")[0].strip()
        if text in ("", "---"):
            continue
        if text.startswith("-") and last:
            values[last] = f"{values[last]},{text[1:].strip()}".lstrip(",")
            continue
        last, colon, value = (part.strip() for part in text.partition(":"))
        if not colon or last in values:
            raise WorldError(f"{path}: line {number} = {text!r}: write each key once, as in resolution: 0.05")
        if last not in KEYS:
            raise WorldError(f"{path}: {last} = {value!r}: unknown key; known: {', '.join(KEYS)}")
        values[last] = value.strip("'\"")
    return values


def _number(path: Path, values: Values, key: str, default: float | None, low: float, high: float) -> float:
    text = values.get(key)
    if text is None:
        if default is None:
            raise WorldError(f"{path}: {key} = nothing: this must be given")
        return default
    number = _float(text)
    if not low <= number <= high:
        raise WorldError(f"{path}: {key} = {text!r}: a number from {low:g} to {high:g}")
    return number


def _float(text: str) -> float:
    """Return the number of a text, NaN where it is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def _origin(path: Path, values: Values) -> tuple[float, float, float]:
    text = values.get("origin", "0, 0, 0")
    numbers = [_float(part) for part in text.strip("[]").split(",")]
    if len(numbers) != 3 or not all(math.isfinite(number) for number in numbers):
        raise WorldError(f"{path}: origin = {text!r}: three numbers [x, y, yaw]")
    return numbers[0], numbers[1], numbers[2]


def _image(path: Path, values: Values) -> NDArray[np.float64]:
    """Return the grey values (rows, columns) in 0..255."""
    if not values.get("image"):
        raise WorldError(f"{path}: image = nothing: this must be given")
    file = path.parent / values["image"]
    if file.is_file() and (pixels := _pixels(file)) > MOST_PIXELS:
        raise WorldError(f"{path}: image = {values['image']!r}: {pixels} pixels, at most {MOST_PIXELS}")
    image = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE) if file.is_file() else None
    if image is None:
        raise WorldError(f"{path}: image = {values['image']!r}: a PGM or PNG beside it that can be read")
    return np.asarray(image, dtype=np.float64)


def _pixels(file: Path) -> int:
    """Return how many pixels a picture unpacks to, by its PNG header or, of what isn't packed, by its size."""
    with file.open("rb") as opened:
        head = opened.read(24)
    if head[:8] == b"\x89PNG\r\n\x1a\n" and len(head) == 24:
        width, height = struct.unpack(">II", head[16:])
        return int(width * height)
    return file.stat().st_size


def _largest(free: NDArray[np.uint8], path: Path) -> NDArray[np.uint8]:
    """Return the largest joined free area alone."""
    count, labels, sizes, _ = cv2.connectedComponentsWithStats(free, connectivity=4)
    if count < 2:
        raise WorldError(f"{path}: image = {free.shape[1]} x {free.shape[0]} cells: none of them is free")
    return np.asarray(labels == 1 + int(np.argmax(sizes[1:, cv2.CC_STAT_AREA])), dtype=np.uint8)
