"""Signatures: the scale of their difference, and all rotations of a bank at once."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import Room

from topomap.core.arrays import Image
from topomap.core.errors import ShapeError
from topomap.core.geometry import TAU, wrap
from topomap.core.panorama import Panorama
from topomap.vision.image.compare import (
    ARRIVAL,
    PLACE,
    SignatureSpec,
    mean_abs,
    rms,
    rotation_difference,
    rotation_within,
    signature,
    squared_differences,
)


def noise(seed: int) -> Panorama:
    return Panorama(np.random.default_rng(seed).integers(0, 256, (100, 720, 3), dtype=np.uint8))


@cache
def place(seed: int = 1, heading: float = 0.0) -> Panorama:
    return Room(seed).view(3.0, 2.5, heading)


def test_the_scale_is_nought_for_the_same_and_root_two_for_unrelated_views() -> None:
    assert rms(signature(place()), signature(place())) == 0.0
    assert rms(signature(noise(1)), signature(noise(2))) == pytest.approx(math.sqrt(2), abs=0.1)
    assert mean_abs(signature(noise(1)), signature(noise(2))) == pytest.approx(2 / math.sqrt(math.pi), abs=0.1)


def test_the_difference_grows_with_distance_and_forgives_gain() -> None:
    room, here = Room(), signature(place())
    found = [rms(signature(room.view(3.0 + d, 2.5)), here) for d in (0.1, 0.3, 0.6)]
    assert 0 < found[0] < found[1] < found[2] < 1.2
    dimmed: Image = (place().image * 0.7).astype(np.uint8)
    assert rms(signature(Panorama(dimmed)), here) < 0.03


@pytest.mark.parametrize("spec", [PLACE, ARRIVAL, SignatureSpec(colour=True), SignatureSpec(columns=75)])
def test_fourier_agrees_with_rolling(spec: SignatureSpec) -> None:
    a, b = signature(place(1), spec), signature(place(2), spec)
    fast = squared_differences(a, b.spectrum[np.newaxis])[0]
    slow = [np.mean((b.pixels - np.roll(a.pixels, k, axis=1)) ** 2) for k in range(a.pixels.shape[1])]
    np.testing.assert_allclose(fast, slow, atol=2e-5)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 719))
def test_rotation_is_found_with_its_sign(columns: int) -> None:
    turn = columns * TAU / 720
    difference, rotation = rotation_difference(signature(place().rolled(-columns)), signature(place()))
    assert abs(wrap(rotation - turn)) < math.radians(0.7)
    assert difference < 0.15


def test_blank_views_compare_without_fuss_and_recipes_dont_mix() -> None:
    blank = signature(Panorama(np.full((100, 720, 3), 90, np.uint8)))
    assert rms(blank, blank) == 0.0
    assert rotation_difference(blank, signature(place()))[0] == pytest.approx(1.0, abs=1e-3)
    with pytest.raises(ShapeError):
        rms(blank, signature(place(), ARRIVAL))
    with pytest.raises(ShapeError):
        rotation_difference(blank, signature(place(), ARRIVAL))


@pytest.mark.parametrize("turn", [0.0, 0.35, -0.35, 3.0, -3.1])
def test_within_a_reach_that_holds_it_the_rotation_is_that_over_the_full_turn(turn: float) -> None:
    here, there = signature(place(1, turn)), signature(place(1))
    difference, rotation = rotation_difference(here, there)
    near, found = rotation_within(here, there, turn + 0.2, 0.4)
    assert near == pytest.approx(difference, abs=1e-3)
    assert wrap(found - rotation) == pytest.approx(0.0, abs=1e-6)


def test_what_lies_beyond_the_reach_isnt_found() -> None:
    here, there = signature(place(1, 2.0)), signature(place(1))
    for middle, reach in ((0.0, 0.5), (-1.0, 0.3), (3.0, 0.4), (0.01, 0.005)):
        difference, rotation = rotation_within(here, there, middle, reach)
        assert abs(wrap(rotation - middle)) <= reach + 0.5 * TAU / 90
        assert difference > 0.5
    with pytest.raises(ShapeError, match="signatures differ in shape"):
        rotation_within(here, signature(place(1), ARRIVAL), 0.0, 1.0)
