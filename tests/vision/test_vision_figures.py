"""What each stage of seeing makes of two views, by figures: the same as before."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from answers import FAR, GOAL, NEAR, seen
from kept import as_before
from stages import numbers, of_one, of_two

from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.vision.compass import ALIGNERS
from topomap.vision.homing import METHODS, POLICIES, REFERENCE_METHODS
from topomap.vision.tilt.lean import Lean


def view(of: str) -> Panorama:
    return seen("min-warping", {"goal": GOAL, "near": NEAR, "far": FAR}[of])


@pytest.mark.parametrize("said", ["goal", "far"])
def test_a_view_tells_the_same_as_before(said: str) -> None:
    as_before(f"seen {said}", {name: list(numbers(made())) for name, made in of_one(view(said))})


@pytest.mark.parametrize("said", ["near", "far"])
def test_two_views_tell_the_same_as_before(said: str) -> None:
    as_before(f"compared {said}", {name: list(numbers(made())) for name, made in of_two(view("goal"), view(said))})


def test_what_methods_keep_of_a_view_is_as_before() -> None:
    kept = {name: METHODS[name].describe(seen(name, FAR)) for name in METHODS}
    as_before("described", {name: list(numbers(one)) for name, one in kept.items()})


def test_what_aligners_find_by_little_is_as_before() -> None:
    """A view a few centimetres off and turned by part of a column, held against both sides of a prior."""
    goal, close = view("goal"), dataclasses.replace(view("goal"), image=np.roll(view("near").image, 3, axis=1))
    asked = [(close, None), (close, 0.02), (close.rolled(9), -0.1), (view("far").rolled(-5), 0.05)]
    found = {name: [one.align(current, goal, prior) for current, prior in asked] for name, one in ALIGNERS.items()}
    as_before("aligned by little", {name: list(numbers(list(one))) for name, one in found.items()})


def test_where_methods_come_from_is_as_before() -> None:
    listed = {**METHODS, **REFERENCE_METHODS, **POLICIES, **{f"compass {name}": one for name, one in ALIGNERS.items()}}
    as_before("origins", {name: [one.origin.row, one.origin.source] for name, one in listed.items()})


def test_a_rolled_view_is_kept_as_the_view_of_a_turned_robot() -> None:
    method = METHODS["dtw-unifying-2d"]
    turn = TAU / 4
    rolled, described = method.describe(view("far")).rolled(turn), method.describe(view("far").rotated(turn))
    assert rolled.picture is not None
    assert np.abs(rolled.picture.picture.astype(float) - described.picture.picture).mean() < 2.0
    assert np.abs(rolled.fine - described.fine).mean() < 0.05


def test_of_records_tuples_and_arrays_all_numbers_are_told() -> None:
    assert list(numbers((1, [2.5, Lean(0.5, 0.25)], np.arange(3.0)))) == pytest.approx(
        [1.0, 2.5, 0.5, 0.25, 0.0, 1.0, 2.0, 3.0, 1.0, math.sqrt(2 / 3), math.log(5 / 3)]
    )
