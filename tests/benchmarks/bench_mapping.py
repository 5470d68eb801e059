"""Place search over 10,000 and 100,000 views of a campus, beside comparing all of them."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable

import numpy as np

from sim2d import worlds
from sim2d.config import CameraConfig
from sim2d.path import of_route
from sim2d.sensors.camera import Camera
from sim2d.streams import stream
from topomap.core.panorama import Panorama
from topomap.mapping.places.place_index import PlaceIndex
from topomap.vision.image.compare import Signature, normalised, signature

Row = dict[str, str | float | None]
STORED, QUERIES, SPACING = 10_000, 40, 0.5  # views along the route, every so many metres [m]


def rows() -> list[Row]:
    """Return a row a size; recall: how often the best of all is found; bytes a view: of the index itself."""
    seen = _drive()
    rng = np.random.default_rng(0)
    index = PlaceIndex()
    for view in seen[:STORED]:
        index.add(view)
    asked = [_alike(seen[k], rng) for k in rng.choice(STORED, QUERIES, replace=False)]
    out = [_row(index, asked)]
    for _ in range(9):
        for view in seen[:STORED]:
            index.add(_alike(view, rng))
    return [*out, _row(index, asked)]


def _drive() -> list[Signature]:
    """Views along campus's route, headings along it."""
    world, camera = worlds.load("campus"), Camera(CameraConfig(), stream(0, "bench"))
    path = of_route(world.spec.route)
    seen = []
    for k in range(STORED):
        (x, y), (ahead_x, ahead_y) = path.at(SPACING * k), path.at(SPACING * k + 0.1)
        image = camera.view(world, x, y, math.atan2(ahead_y - y, ahead_x - x))
        seen.append(signature(Panorama.from_recorded(image, camera.rig)))
    return seen


def _alike(view: Signature, rng: np.random.Generator) -> Signature:
    """The view from about there: turned, and changed by as much as half a metre does."""
    change = np.fft.rfft(rng.normal(size=view.pixels.shape), axis=1) / np.maximum(np.arange(view.spectrum.shape[1]), 1)
    change = np.fft.irfft(change, view.pixels.shape[1], axis=1)
    turned = np.roll(view.pixels, int(rng.integers(view.pixels.shape[1])), axis=1)
    pixels = normalised((turned + 0.5 * change / change.std()).astype(np.float32))
    return Signature(pixels, np.fft.rfft(pixels, axis=1).astype(np.complex64))


def _row(index: PlaceIndex, asked: list[Signature]) -> Row:
    everything = np.arange(len(index))
    found = [int(index.search(view, 8)[0][0]) for view in asked]
    best = [int(np.argmin(index.compare(view, everything).difference)) for view in asked[:15]]
    hits = sum(a == b for a, b in zip(found, best, strict=False))
    ms = [_ms(lambda v=view: index.search(v, 8)) for view in asked]
    all_ms = statistics.median(_ms(lambda v=view: index.compare(v, everything)) for view in asked[:5])
    size = f"8 of {len(index)} x 90x10, recall {hits}/{len(best)}, {index.nbytes / len(index) / 1e3:.1f} kB a view"
    median = statistics.median(ms)
    return {
        "name": f"place search {len(index)}",
        "ms": median,
        "size": f"{size}, worst {max(ms):.1f} ms",
        "peer": "comparing all",
        "peer_ms": all_ms,
        "ratio": all_ms / median,
    }


def _ms(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return 1e3 * (time.perf_counter() - start)
