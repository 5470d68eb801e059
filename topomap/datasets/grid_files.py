"""The files of a grid of panoramas: a folder of images whose places are in their names or in a CSV file.

What the images are is said in `grid.toml` beside them (or any file given); its keys are the fields of `GridSpec`. For
the Bielefeld/Vardy databases, whose raw omnidirectional images are named by column and row of the grid:

    pattern = "{x}_{y}.png"      # grid column and row
    unit_m = 0.3                 # metres per column
    horizon_row = 49.5
    unwrap = "mirror.toml"       # the mirror's rig, as `topomap rig fit IMAGE --out mirror.toml` writes it; leave it
                                 # out for images that are panoramas already
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, Field, ValidationError

from topomap.core.errors import DataError
from topomap.core.files import read_toml, regular
from topomap.core.geometry import wrap

SPEC_NAME = "grid.toml"
NUMBER = r"[-+]?\d+(?:\.\d+)?"


class GridSpec(BaseModel, frozen=True, extra="forbid"):
    """What the images of a folder are: exactly one of `pattern` and `csv` says where each was taken."""

    pattern: str | None = Field(None, description="file name with {x} and {y}, may be {heading}, as in cv_{x}_{y}.png")
    csv: str | None = Field(None, description="CSV file with one line an image")
    x: str = Field("x", description="CSV column of x")
    y: str = Field("y", description="CSV column of y")
    heading: str | None = Field(None, description="CSV column of the heading [degrees]; none: all look one way")
    file: str = Field("file", description="CSV column of the file name")
    unit_m: float = Field(1.0, gt=0, description="metres per unit of x and y")
    convention: Literal["ccw-from-x", "cw-from-y"] = Field("ccw-from-x", description="how headings are counted")
    heading_deg: float = Field(0.0, description="heading of all images where none is given [degrees]")
    forward_column: int | None = Field(None, ge=0, description="column along the heading; none: the middle one")
    clockwise: bool = Field(True, description="columns run clockwise, as people read a panorama")
    horizon_row: float | None = Field(None, description="row of eye level; none: the middle of the image")
    camera_height: float = Field(0.0, ge=0, description="height of the camera [m]; 0: unknown")
    unwrap: str | None = Field(None, description="rig file of the mirror, for raw omnidirectional images")


ANTWORLD = GridSpec(
    csv="grid.csv", x="X [mm]", y="Y [mm]", heading="Heading [degrees]", file="Filename", unit_m=0.001,
    convention="cw-from-y", horizon_row=119.5,
)  # fmt: skip
"""What efkag's AntWorld data sets are; they are known by the header of their CSV file. Eye level is far below the
middle row: with row 74.5 min-warping is off by 51 deg within 0.5 m, with 119.5 by 25.
"""
ANTWORLD_HEADER = "X [mm],Y [mm],Z [mm],Heading [degrees],Filename"


@dataclass(frozen=True, slots=True)
class Shot:
    """An image file and where it was taken: x, y [m], heading [rad, counter-clockwise from +x]."""

    path: Path
    x: float
    y: float
    heading: float


def shots_of(folder: Path, spec: GridSpec) -> list[Shot]:
    """Return the images of a folder, each with its place. Raises DataError that names file and line."""
    shots = list(_from_csv(folder, spec) if spec.csv else _from_names(folder, spec))
    _check(folder, shots)
    return shots


def spec_of(folder: Path, spec_file: Path | None = None) -> GridSpec:
    """Return what a folder's images are, by a spec file or else by its own. Raises DataError."""
    path = spec_file or folder / SPEC_NAME
    if not path.exists() and spec_file is None:
        return known_spec(folder)
    try:
        spec = GridSpec.model_validate(read_toml(path))
    except ValidationError as error:
        first = error.errors()[0]
        raise DataError(f"{path}: {'.'.join(map(str, first['loc']))}: {first['msg']}") from error
    except (OSError, ValueError, RecursionError) as error:
        raise DataError(f"{path}: can't be read: {error}") from error
    if (spec.pattern is None) == (spec.csv is None):
        raise DataError(f"{path}: say either pattern or csv")
    return spec


def known_spec(place: Path) -> GridSpec:
    """Return the spec of a folder, or of a CSV file in it, in a known format without a spec of its own."""
    path = place if place.is_file() else place / str(ANTWORLD.csv)
    if path.is_file() and path.read_text(encoding="utf8", errors="replace").startswith(ANTWORLD_HEADER):
        return ANTWORLD.model_copy(update={"csv": path.name})
    if place.is_file():
        raise DataError(f"{place}: its first line isn't {ANTWORLD_HEADER}; name its folder, with a {SPEC_NAME}")
    raise DataError(f"{place}: there is no {SPEC_NAME} that says what its images are (see topomap.datasets)")


def _from_csv(folder: Path, spec: GridSpec) -> Iterator[Shot]:
    path = folder / str(spec.csv)
    try:
        lines = regular(path).read_text(encoding="utf8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: can't be read: {error}") from error
    reader = csv.DictReader(lines, skipinitialspace=True)
    columns = [spec.x, spec.y, spec.file, *([spec.heading] if spec.heading else [])]
    for name in columns:
        if name not in (reader.fieldnames or []):
            raise DataError(f"{path}:1: there is no column {name!r}; there are {', '.join(reader.fieldnames or [])}")
    for row in reader:
        where = f"{path}:{reader.line_num}"
        file = folder / (row[spec.file] or "")
        if not file.is_file():
            raise DataError(f"{where}: there is no image {row[spec.file]!r}")
        turn = _number(where, spec.heading, row[spec.heading]) if spec.heading else spec.heading_deg
        x, y = (_number(where, name, row[name]) * spec.unit_m for name in (spec.x, spec.y))
        yield Shot(file, x, y, _heading(turn, spec))


def _from_names(folder: Path, spec: GridSpec) -> Iterator[Shot]:
    escaped = re.escape(str(spec.pattern))
    named = re.sub(r"\\{(x|y|heading)\\}", lambda field: f"(?P<{field[1]}>{NUMBER})", escaped)
    try:
        pattern = re.compile(named)
    except re.error as error:
        raise DataError(f"{folder / SPEC_NAME}: pattern {spec.pattern!r}: {error}") from error
    if not {"x", "y"} <= pattern.groupindex.keys():
        raise DataError(f"{folder / SPEC_NAME}: pattern {spec.pattern!r} needs {{x}} and {{y}}")
    for path in sorted(folder.iterdir()):
        match = pattern.fullmatch(path.name)
        if match is None:
            continue
        found = match.groupdict()
        turn = float(found.get("heading") or spec.heading_deg)
        yield Shot(path, float(found["x"]) * spec.unit_m, float(found["y"]) * spec.unit_m, _heading(turn, spec))


def _check(folder: Path, shots: list[Shot]) -> None:
    if len(shots) < 2:
        raise DataError(f"{folder}: {len(shots)} images are named as its spec says; a grid needs at least two")
    taken: dict[tuple[float, float], Shot] = {}
    for shot in shots:
        other = taken.setdefault((round(shot.x, 6), round(shot.y, 6)), shot)
        if other is not shot:
            raise DataError(f"{shot.path}: stands at the place of {other.path.name}")


def _number(where: str, field: str, word: str | None) -> float:
    try:
        value = float(word or "")
    except ValueError:
        raise DataError(f"{where}: {field}: {word!r} is no number") from None
    if not math.isfinite(value):
        raise DataError(f"{where}: {field}: {word!r} isn't finite")
    return value


def _heading(degrees: float, spec: GridSpec) -> float:
    return wrap(math.radians(degrees if spec.convention == "ccw-from-x" else 90.0 - degrees))
