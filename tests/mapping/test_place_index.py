"""Searching views by what they look like: as good as comparing all."""

from __future__ import annotations

import numpy as np
import pytest

from topomap.mapping.places.place_index import PlaceIndex
from topomap.vision.image.compare import Signature, normalised, rotation_differences


def view(pixels: np.ndarray) -> Signature:
    small = normalised(pixels.astype(np.float32))
    return Signature(small, np.fft.rfft(small, axis=1).astype(np.complex64))


def pictures(count: int, seed: int = 0) -> np.ndarray:
    """Pictures (count, 10, 90) with more low than high frequencies, as views have."""
    rng = np.random.default_rng(seed)
    spectra = np.fft.rfft(rng.normal(size=(count, 10, 90)), axis=2) / np.maximum(np.arange(46), 1) ** 0.8
    return np.fft.irfft(spectra, 90, axis=2)


@pytest.fixture(scope="module")
def stored() -> tuple[PlaceIndex, np.ndarray]:
    index, base = PlaceIndex(), pictures(1500)
    for picture in base:
        index.add(view(picture))
    return index, base


def test_the_best_of_all_is_found_at_any_rotation(stored: tuple[PlaceIndex, np.ndarray]) -> None:
    index, base = stored
    spectra = np.stack([view(picture).spectrum for picture in base])
    rng = np.random.default_rng(1)
    for wanted in range(0, 1500, 75):
        seen = view(np.roll(base[wanted], rng.integers(90), axis=1) + rng.normal(0, 0.6 * base[wanted].std(), (10, 90)))
        places, found = index.search(seen, 3)
        every = rotation_differences(seen, spectra)
        assert places[0] == np.argmin(every.difference) == wanted
        assert found.difference == pytest.approx(np.sort(every.difference)[:3], abs=1e-5)
        assert found.rotation[0] == pytest.approx(every.rotation[wanted])


def test_only_the_old_ones_are_searched(stored: tuple[PlaceIndex, np.ndarray]) -> None:
    index, base = stored
    places, _ = index.search(view(base[1000]), 5, 800)
    assert (places < 800).all()
    assert index.search(view(base[1000]), 5, 1200)[0][0] == 1000


def test_an_empty_index_finds_nothing() -> None:
    places, found = PlaceIndex().search(view(pictures(1)[0]), 3)
    assert len(places) == len(found.difference) == 0


def test_a_view_taken_for_another_is_compared_as_that_one() -> None:
    """Blank before, so that what is kept of it beside its spectrum would tell."""
    base = pictures(3)
    index, fresh = PlaceIndex(), PlaceIndex()
    for picture in (np.zeros((10, 90)), base[1]):
        index.add(view(picture))
    for picture in base[:2]:
        fresh.add(view(picture))
    index.replace(0, view(base[0]))
    places = np.arange(2)
    assert np.array_equal(
        index.compare(view(base[2]), places).difference, fresh.compare(view(base[2]), places).difference
    )
