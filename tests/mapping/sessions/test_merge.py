"""Two maps of one ground are joined all along it, though most of its places look like others."""

from __future__ import annotations

import math

import numpy as np
from maps import RIG, increments

from topomap.core.encoded import encode
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, HomeVector
from topomap.mapping.closures.relative_pose import RelativePoseSettings
from topomap.mapping.graph import Node, Snapshot, TopoMap
from topomap.mapping.sessions.cross_claims import CrossClaims
from topomap.mapping.sessions.merge import Merged, merge
from topomap.vision.image.compare import rotation_difference, signature

PLACES = 30
ONE = (3, 11, 19, 27)
"""Places that look like no other one; all others look like two more."""


class Costs:
    """An aligner whose cost is how much the images differ."""

    def align(self, current: Panorama, goal: Panorama, guess: float | None = None) -> Alignment:
        difference, rotation = rotation_difference(signature(current), signature(goal))
        return Alignment(rotation=rotation, residual=0.1 + 0.4 * difference, home=HomeVector(0.0, None, 0.0))


def view(place: int, noise: int) -> Snapshot:
    look = 100 + place if place in ONE else place % (PLACES // 3)
    image = np.random.default_rng(look).integers(40, 216, (RIG.height, RIG.width, 1)).repeat(3, axis=2)
    image = image + np.random.default_rng(1000 + noise).integers(-20, 21, image.shape)
    return Snapshot(encode(image.astype(np.uint8)), None, RIG)


def lap(drive: int) -> TopoMap:
    """A circle of a place each 0.5 m, as odometry without errors has it."""
    topo = TopoMap()
    for k in range(PLACES):
        way = increments(5 * (k - 1), 5, math.tau / PLACES / 5) if k else None
        topo.add(Node(5 * k * 250_000_000, 0.5 * k, view(k, 100 * drive + k)), way)
    return topo


def merged() -> Merged:
    claims = CrossClaims(Costs(), RelativePoseSettings())
    return merge(lap(0), lap(1), claims, lambda _share, _what: None)


def test_places_that_look_like_others_are_joined_as_well_once_the_maps_are() -> None:
    alone = CrossClaims(Costs(), RelativePoseSettings()).between(lap(0), lap(1), lambda _: None)
    assert sum(seen.i == seen.j for seen in alone) < 0.7 * PLACES, "by their looks most can be others"
    both = merged()
    assert both.across >= PLACES - 2
    assert all(c.j - c.i == PLACES for c in both.map.closures), "each with itself"
    apart = np.hypot(*(both.map.poses[PLACES:, :2] - both.map.poses[:PLACES, :2]).T)
    assert apart.max() < 0.1
