"""The place check on a recorded route: some images are the map, the others ask where they were taken."""

from __future__ import annotations

import csv
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from topomap.bench.pool import Workers
from topomap.core.arrays import FloatArray
from topomap.core.encoded import decode
from topomap.core.errors import DataError
from topomap.core.files import regular
from topomap.core.geometry import TAU, wrap
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision.compass import ALIGNERS
from topomap.vision.contracts import Aligner

IMAGES, PATH = "training.csv", "training_path_scaled.csv"


@dataclass(frozen=True, slots=True, eq=False)
class PhotoRoute:
    """Images along a route: files and the positions (N, 2) [m] they were taken at."""

    files: tuple[Path, ...]
    positions: FloatArray

    def panorama(self, index: int) -> Panorama:
        """Return an image, forward in the centre column and clockwise as recorded. Raises DataError."""
        image = decode(regular(self.files[index]).read_bytes())
        rig = Rig(image.shape[1], image.shape[0], (image.shape[0] - 1) / 2, image.shape[1] / TAU, 0.0)
        return Panorama(np.roll(image[:, ::-1], image.shape[1] // 2 + 1, axis=1), None, rig)


@dataclass(frozen=True, slots=True)
class PlaceScore:
    """What one aligner found: place error, the error of the nearest map image (the best that could be), compass error
    after known rolls [degrees]: median and mean; ms: median of a pair.
    """

    aligner: str
    queries: int
    place_error_m: float
    floor_m: float
    compass_median_deg: float
    compass_mean_deg: float
    ms: float
    unfit: str | None = None


@dataclass(frozen=True, slots=True)
class PlaceTask:
    """Ask one aligner for every query: the map image with the least residual, and the roll of its neighbour."""

    folder: Path
    name: str
    aligner: Aligner
    spacing: int
    stride: int

    @property
    def key(self) -> str:
        """All that decides the result."""
        return f"places {self.folder} {_state(self.folder)} {self.name} {self.aligner!r} {self.spacing} {self.stride}"

    def perform(self) -> PlaceScore:
        """Return the score; an aligner that needs what photographs lack is unfit."""
        route, views = _route(self.folder)
        nodes = list(range(0, len(views), self.spacing))
        queries = [i for i in range(len(views)) if i % self.spacing][:: self.stride]
        rng = np.random.default_rng(0)
        errors, floors, rolls, ms = [], [], [], []
        try:
            for query in queries:
                gaps = np.hypot(*(route.positions[nodes] - route.positions[query]).T)
                columns = int(rng.integers(views[query].rig.width))
                turned = _fresh(views[query].rolled(-columns))  # as seen by a robot turned that far to the left
                start = time.perf_counter()
                residuals = [self.aligner.align(turned, views[node]).residual for node in nodes]
                ms.append(1e3 * (time.perf_counter() - start) / len(nodes))
                errors.append(float(gaps[int(np.argmin(residuals))]))
                floors.append(float(gaps.min()))
                found = self.aligner.align(turned, views[query - 1]).rotation
                rolls.append(abs(math.degrees(wrap(found - columns * TAU / turned.rig.width))))
        except DataError as error:
            return PlaceScore(self.name, 0, math.nan, math.nan, math.nan, math.nan, math.nan, str(error))
        return PlaceScore(
            self.name, len(queries), float(np.median(errors)), float(np.median(floors)), float(np.median(rolls)),
            float(np.mean(rolls)), float(np.median(ms)),
        )  # fmt: skip


def read_route(folder: Path) -> PhotoRoute:
    """Read the images of a folder and where they were taken, by time. Raises DataError that names file and line."""
    rows = _rows(folder / IMAGES, header=True)
    stamps, files = [], []
    for line, row in rows:
        file = folder / Path(row[1]).name
        if not file.is_file():
            raise DataError(f"{folder / IMAGES}:{line}: there is no image {file.name!r}")
        stamps.append(_number(folder / IMAGES, line, row[0]))
        files.append(file)
    path = np.array([[_number(folder / PATH, line, word) for word in row[:3]] for line, row in _rows(folder / PATH)])
    if len(files) < 2 or len(path) < 2:
        raise DataError(f"{folder}: a route needs at least two images and two positions")
    at = [np.interp(np.array(stamps) * 1e3, path[:, 0], path[:, k]) / 100.0 for k in (1, 2)]
    return PhotoRoute(tuple(files), np.column_stack(at))


def place_scores(
    folder: Path, spacing: int, stride: int, workers: Workers, advance: Callable[[], None]
) -> list[PlaceScore]:
    """Return the score of every aligner that looks at images, best place first. Raises DataError."""
    read_route(folder)
    asked = [PlaceTask(folder.resolve(), name, ALIGNERS[name], spacing, stride) for name in names()]
    scores = workers.run(asked, advance)
    return sorted(scores, key=lambda s: (s.unfit is not None, s.place_error_m, s.compass_mean_deg))


def names() -> Sequence[str]:
    """Return the aligners that take part: a given heading says nothing."""
    return [name for name in ALIGNERS if name != "given"]


def _fresh(view: Panorama) -> Panorama:
    return Panorama(view.image, view.ranges, view.rig)


@lru_cache(maxsize=1)
def _route(folder: Path) -> tuple[PhotoRoute, list[Panorama]]:
    route = read_route(folder)
    return route, [route.panorama(i) for i in range(len(route.files))]


def _state(folder: Path) -> str:
    return " ".join(f"{name}:{(folder / name).stat().st_mtime_ns}" for name in (IMAGES, PATH))


def _rows(path: Path, header: bool = False) -> list[tuple[int, list[str]]]:
    try:
        lines = list(csv.reader(regular(path).read_text(encoding="utf8").splitlines(), skipinitialspace=True))
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: can't be read: {error}") from error
    rows = [(number, row) for number, row in enumerate(lines, start=1) if row][1 if header else 0 :]
    needed = 2 if header else 3
    for number, row in rows:
        if len(row) < needed:
            raise DataError(f"{path}:{number}: needs {needed} fields, has {len(row)}")
    return rows


def _number(path: Path, line: int, word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        raise DataError(f"{path}:{line}: {word!r} is no number") from None
    if not math.isfinite(value):
        raise DataError(f"{path}:{line}: {word!r} isn't finite")
    return value
