"""A world whose views say outright where they were taken, and methods that read it: what the bench must get right."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.core.geometry import TAU, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, HomeVector
from topomap.core.rig import Rig
from topomap.vision.arena import Arena, Recipe
from topomap.vision.homing import Needs

RIG = Rig(width=360, height=2, horizon_row=0.5, focal=360 / TAU)
SCALE, MIDDLE = 20.0, 120.0


class TellingViews:
    """Red tells x, green tells y (5 cm steps); one blue column points along the world's +x."""

    def view(self, x: float, y: float, heading: float) -> Panorama:
        image = np.zeros((RIG.height, RIG.width, 3), np.uint8)
        image[..., 0], image[..., 1] = round(x * SCALE + MIDDLE), round(y * SCALE + MIDDLE)
        image[:, round(RIG.column(-heading)) % RIG.width, 2] = 255
        return Panorama(image, np.full(RIG.width, 9.0, np.float32), RIG)


def told(view: Panorama) -> tuple[float, float, float]:
    """x, y, heading of a telling view."""
    marker = int(view.image[0, :, 2].argmax())
    x, y = (float(view.image[0, 0, k]) - MIDDLE for k in (0, 1))
    return x / SCALE, y / SCALE, wrap(-marker * TAU / RIG.width)


@dataclass(frozen=True)
class Knowing:
    """Answers exactly, turned by `bias` [rad]; says nothing right of `silent_beyond` [m]. Wants aligned views."""

    bias: float = 0.0
    silent_beyond: float = math.inf
    compass: bool = True
    ranges: bool = False
    claims_homing: bool = True

    @property
    def needs(self) -> Needs:
        return Needs(compass=self.compass, ranges=self.ranges)

    def describe(self, panorama: Panorama) -> tuple[float, float, float]:
        return told(panorama)

    def home(self, current: tuple[float, float, float], goal: tuple[float, float, float]) -> HomeVector:
        if current[0] > self.silent_beyond:
            return HomeVector(0.0, None, 0.0)
        way = math.atan2(goal[1] - current[1], goal[0] - current[0])
        return HomeVector(wrap(way - current[2] + self.bias))


@dataclass(frozen=True)
class KnowingCompass:
    """Reads the rotation, off by `bias` [rad]."""

    bias: float = 0.0

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        return Alignment(wrap(told(current)[2] - told(goal)[2] + self.bias), 0.0)


def telling_arena(name: str, seed: int, options: tuple[str, ...]) -> Arena:
    """A 7 x 5 grid of 0.5 m around the origin."""
    x, y = np.meshgrid(np.arange(-3, 4) * 0.5, np.arange(-2, 3) * 0.5)
    positions = np.column_stack([x.ravel(), y.ravel()])
    return Arena(name, TellingViews(), positions, 0.5, "grid" not in options, (0.0, 0.0))


def telling_recipe(seed: int = 0, options: tuple[str, ...] = ()) -> Recipe:
    return Recipe("telling", seed, telling_arena, options)
