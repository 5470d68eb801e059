"""Panoramas on a grid, and the arena that a bench makes of them."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

from topomap.core.arrays import FloatArray, Image
from topomap.core.encoded import decode
from topomap.core.errors import DataError
from topomap.core.files import regular
from topomap.core.geometry import wrap
from topomap.core.panorama import Panorama
from topomap.core.recorded import RecordedRig
from topomap.datasets.grid_files import SPEC_NAME, GridSpec, Shot, known_spec, shots_of, spec_of
from topomap.datasets.mirror_file import Unwrapper, read_mirror
from topomap.vision.arena import Arena, Recipe, central


class ImageGrid:
    """Images on a grid as a ViewSource: there are views at its positions only, turned by whole columns."""

    def __init__(self, name: str, shots: list[Shot], spec: GridSpec, unwrap: Unwrapper | None = None) -> None:
        self.name = name
        self.shots = shots
        self.positions: FloatArray = np.array([[shot.x, shot.y] for shot in shots])
        self.spacing = _spacing(self.positions)
        self._spec = spec
        self._unwrap = unwrap

    def view(self, x: float, y: float, heading: float) -> Panorama:
        """Return the view at a position [m] of the grid, turned to a heading [rad]. Raises DataError elsewhere."""
        distance = np.hypot(*(self.positions - (x, y)).T)
        nearest = int(distance.argmin())
        if distance[nearest] > 0.25 * self.spacing:
            raise DataError(f"{self.name} has no image at {x:g},{y:g} m")
        shot = self.shots[nearest]
        # a robot turned left of how the image was taken sees it rolled to the right
        return self._panorama(shot).rotated(wrap(shot.heading - heading))

    def _panorama(self, shot: Shot) -> Panorama:
        try:
            image = decode(regular(shot.path).read_bytes())
        except (OSError, DataError) as error:
            raise DataError(f"{shot.path}: can't be read as an image: {error}") from error
        if self._unwrap is not None:
            return self._unwrap.panorama(image)
        return Panorama.from_recorded(image, _rig(image, self._spec))


def load_grid(place: Path, spec_file: Path | None = None) -> ImageGrid:
    """Read a folder of panoramas on a grid, or a CSV file in a known format beside its panoramas.

    Raises DataError that names file and line.
    """
    folder = place.parent if place.is_file() else place
    if not folder.is_dir():
        raise DataError(f"{place}: no such folder or file")
    spec = known_spec(place) if place.is_file() else spec_of(folder, spec_file)
    shots = shots_of(folder, spec)
    unwrap = None
    if spec.unwrap:
        mirror = read_mirror((spec_file or folder / SPEC_NAME).parent / spec.unwrap)
        unwrap = Unwrapper(mirror, spec.horizon_row, spec.camera_height)
    return ImageGrid(folder.resolve().name, shots, spec, unwrap)


def grid_recipe(place: Path, seed: int = 0) -> Recipe:
    """Return the recipe of the arena of an image grid, a folder or CSV file. Raises DataError."""
    grid = load_grid(place)
    states = [(shot, shot.path.stat().st_size, shot.path.stat().st_mtime_ns) for shot in grid.shots]
    identity = hashlib.sha256(repr((states, grid._spec)).encode()).hexdigest()
    return Recipe(grid.name, seed, grid_arena, (str(place.resolve()),), identity)


def grid_arena(name: str, seed: int, options: tuple[str, ...]) -> Arena:
    """Return the arena of an image grid; options: its folder or CSV file. Raises DataError."""
    grid = load_grid(Path(options[0]))
    return Arena(name, grid, grid.positions, grid.spacing, False, central(grid.positions))


def _spacing(positions: FloatArray) -> float:
    """Return the median distance from a position to its nearest neighbour [m]."""
    gaps = np.hypot(*np.moveaxis(positions[:, None] - positions[None], -1, 0))
    np.fill_diagonal(gaps, np.inf)
    return float(np.median(gaps.min(axis=1)))


def _rig(image: Image, spec: GridSpec) -> RecordedRig:
    height, width = image.shape[:2]
    return RecordedRig.cylinder(
        width, height, spec.camera_height, spec.horizon_row, spec.forward_column, spec.clockwise
    )
