"""Round rooms with pillars, made in code: the views of simulated experiments and the arenas around them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from topomap.bench.pool import digest_files
from topomap.core.arrays import FloatArray, Image
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import Plan
from topomap.core.rig import Rig
from topomap.vision.arena import Arena, Recipe
from topomap.vision.contracts import ViewSource

RIG = Rig()


@dataclass(frozen=True, slots=True)
class Pillar:
    """An upright pillar: centre x, y and radius [m], colour (r, g, b)."""

    x: float
    y: float
    radius: float
    colour: tuple[int, int, int]


class Room:
    """A ViewSource: pillars inside a round wall about the origin, both as high as the view.

    wall: its radius [m]; paint (N, 3) uint8: the wall's colours along its angle from the world's x axis.
    """

    def __init__(self, pillars: Sequence[Pillar], wall: float, paint: Image) -> None:
        self.pillars = tuple(pillars)
        self.wall = wall
        self.paint = paint

    def view(self, x: float, y: float, heading: float) -> Panorama:
        """Return the panorama with ranges at a pose [m, rad] inside the wall."""
        angles = heading + np.arange(RIG.width) * TAU / RIG.width
        towards = np.stack([np.cos(angles), np.sin(angles)])
        ranges = _inside(np.array([x, y]), towards, self.wall)
        at = np.array([[x], [y]]) + ranges * towards
        places = np.arctan2(at[1], at[0]) % TAU * (len(self.paint) / TAU)
        colours = self.paint[places.astype(np.intp) % len(self.paint)].copy()
        for pillar in self.pillars:
            distance = _outside(np.array([pillar.x - x, pillar.y - y]), towards, pillar.radius)
            seen = distance < ranges
            colours[seen], ranges[seen] = pillar.colour, distance[seen]
        image = np.broadcast_to(colours, (RIG.height, RIG.width, 3)).copy()
        return Panorama(image, ranges.astype(np.float32), RIG)

    def plan(self) -> Plan:
        """Return wall and pillars as a plan."""
        angles = np.linspace(0.0, TAU, 181)
        ring = self.wall * np.column_stack([np.cos(angles), np.sin(angles)])
        return Plan((ring,), tuple((p.x, p.y, p.radius) for p in self.pillars))


def plain(colour: tuple[int, int, int]) -> Image:
    """Return the paint (1, 3) of a wall of one colour."""
    return np.array([colour], np.uint8)


def painted(rng: np.random.Generator, patches: int = 40) -> Image:
    """Return the paint (720, 3) of a wall in so many patches of random colour and unequal width."""
    edges = np.sort(rng.uniform(0.0, 720.0, patches))
    colours = rng.integers(60, 230, (patches, 3)).astype(np.uint8)
    return np.asarray(colours[np.searchsorted(edges, np.arange(720)) % patches], np.uint8)


def square_grid(room: Room, half: float, spacing: float, clearance: float = 0.15) -> FloatArray:
    """Return the positions (N, 2) [m] of a square grid about the origin that stand clear of pillars and wall."""
    steps = np.arange(-round(half / spacing), round(half / spacing) + 1) * spacing
    x, y = np.meshgrid(steps, steps)
    positions = np.column_stack([x.ravel(), y.ravel()])
    free = np.hypot(*positions.T) < room.wall - clearance
    for pillar in room.pillars:
        free &= np.hypot(positions[:, 0] - pillar.x, positions[:, 1] - pillar.y) > pillar.radius + clearance
    return np.asarray(positions[free], np.float64)


def room_arena(name: str, room: Room, half: float, spacing: float, goals: ViewSource | None = None) -> Arena:
    """Return the arena of a room with home at the origin; half, spacing [m]: its grid."""
    return Arena(name, room, square_grid(room, half, spacing), spacing, True, (0.0, 0.0), room.plan(), goals)


def room_recipe(name: str, seed: int, make: Callable[[str, int, tuple[str, ...]], Arena]) -> Recipe:
    """Return a room's recipe whose kept results are void when the code of the studies changes."""
    return Recipe(name, seed, make, identity=digest_files(Path(__file__).parent, ("*.py",)))


def _inside(at: FloatArray, towards: FloatArray, radius: float) -> FloatArray:
    """Return the distances (W,) from a point within a circle about the origin to it, along directions (2, W)."""
    along = at @ towards
    return np.asarray(-along + np.sqrt(along**2 + radius**2 - at @ at), np.float64)


def _outside(centre: FloatArray, towards: FloatArray, radius: float) -> FloatArray:
    """Return the distances (W,) to a circle at `centre` (2,) along directions (2, W), infinite beside it."""
    along = centre @ towards
    across = centre[0] * towards[1] - centre[1] * towards[0]
    depth = radius**2 - across**2
    hit = (depth > 0.0) & (along > 0.0)
    return np.where(hit, along - np.sqrt(np.maximum(depth, 0.0)), np.inf)
