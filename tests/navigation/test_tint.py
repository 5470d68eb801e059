"""Colour tells two places of the same grey apart, in whatever light, and says nothing where there is none."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from topomap.core.arrays import Image
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapper import Mapper
from topomap.navigation.localiser.belief import Belief
from topomap.navigation.localiser.mixture import Mixture
from topomap.navigation.localiser.tint import unlike
from topomap.navigation.localiser.views import Found

GREY, BLUE, RED = (110, 110, 110), (50, 102, 190), (200, 51, 51)
"""Two doors of the same grey level, 97."""
HERE = (0.0, 0.0)


def view(door: tuple[int, int, int], first: int = 100, light: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Panorama:
    """A grey wall with a door 60 degrees wide from a column on; light: by which each channel is multiplied."""
    image: Image = np.full((100, 720, 3), GREY, np.uint8)
    image[20:80, first : first + 120] = door
    image[:10] = 200
    return Panorama(np.clip(image * np.array(light), 0, 255).astype(np.uint8), np.full(720, 2.0, np.float32), Rig())


def test_two_doors_of_one_grey_are_told_by_their_colour() -> None:
    assert unlike(view(BLUE), view(BLUE), 0.0, HERE) == pytest.approx(0.0, abs=1e-6)
    assert unlike(view(BLUE), view(RED), 0.0, HERE) > 0.5


def test_darker_or_warmer_light_is_no_other_colour() -> None:
    for light in ((0.6, 0.6, 0.6), (1.1, 1.0, 0.9)):
        assert unlike(view(BLUE, light=light), view(BLUE), 0.0, HERE) < 0.05


def test_the_robots_turn_is_taken_out() -> None:
    turned = np.pi / 2  # what it saw to the left lies ahead
    assert unlike(view(BLUE, first=20), view(BLUE, first=200), turned, HERE) < 0.02
    assert unlike(view(BLUE, first=20), view(BLUE, first=200), -turned, HERE) > 0.3


def test_the_view_is_predicted_from_where_the_place_is() -> None:
    # a wall of doors 2 m all around, seen 0.3 m further ahead: what is on the left falls behind
    ahead = view(BLUE, first=128)
    assert unlike(view(BLUE, first=112), ahead, 0.0, (0.3, 0.0)) < unlike(view(BLUE, first=112), ahead, 0.0, HERE)


def test_a_camera_without_colour_says_nothing() -> None:
    assert unlike(view(GREY), view(RED), 0.0, HERE) == 0.0
    assert unlike(view(RED), view(GREY), 0.0, HERE) == 0.0


def test_only_likely_places_are_looked_at_and_the_others_pass_for_as_alike() -> None:
    views = {0: view(RED), 1: view(BLUE), 2: view(RED)}
    mapper = cast(Mapper, SimpleNamespace(view_cache=SimpleNamespace(panorama=views.__getitem__)))
    start = Mixture.at(np.zeros(3), np.eye(3), 0.5)
    mixture = start.joined_by(np.array([[5.0, 0, 0], [9.0, 0, 0]]), np.eye(3), np.log([0.5, 1e-4])).normalised()
    belief = Belief(mixture, TopoMap())
    found = Found(np.full(3, 0.1), np.zeros(3), np.zeros((3, 2)))
    squares = belief._tints(view(BLUE), mapper, np.arange(3), np.arange(3), found)
    assert squares[0] > 0.2
    assert squares[1] == pytest.approx(0.0, abs=1e-6)
    assert squares[2] == squares[1]


def test_a_look_less_alike_in_colour_counts_to_the_looks_sum_alone() -> None:
    start = Mixture.at(np.zeros(3), np.eye(3), 0.5).looked(np.array([0]), np.array([0.04]))
    assert start.tinted(np.array([0]), np.array([0.2])).seen[0].tolist() == pytest.approx([0.24, 1.0, 0.04])
