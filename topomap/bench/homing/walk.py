"""Iterated homing: following home vectors until home is reached or hope is lost."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import BaseModel, Field

from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU, Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.vision.aligned_homing import AlignedHoming
from topomap.vision.arena import Point
from topomap.vision.compass import GivenHeading
from topomap.vision.contracts import Aligner, HomingPolicy, ViewSource

SLIDES = (0.0, 40.0, 80.0, 110.0, -40.0, -80.0, -110.0)
"""Detours [degrees] that are tried in turn when something stands in the way; mirrored while it slides to the right."""


class WalkSettings(BaseModel, frozen=True, extra="forbid"):
    """How a robot that only follows home vectors is moved."""

    step: float = Field(0.12, gt=0, le=1, description="length of a step [m]")
    reach: float = Field(0.2, gt=0, le=2, description="home counts as reached within this distance [m]")
    longest: float = Field(2.5, ge=1, le=20, description="longest path, as a multiple of the direct one")
    longest_policy: float = Field(10.0, ge=1, le=100, description="the same for policies, which move to look")
    coast: int = Field(5, ge=0, le=100, description="steps that it keeps its direction without an answer")
    clearance: float = Field(0.2, ge=0, le=1, description="what must stay free ahead after a step [m]")


@dataclass(frozen=True, slots=True, eq=False)
class Walk:
    """A path (K, 2) [m] that followed home vectors; reached: it came to home."""

    path: FloatArray
    reached: bool

    @property
    def length(self) -> float:
        """Length of the path [m]."""
        return float(np.hypot(*np.diff(self.path, axis=0).T).sum())

    def ratio(self, home: Point, reach: float) -> float:
        """Return the path's length over the direct way to within `reach` [m] of home."""
        direct = math.dist(self.path[0], home) - reach
        return max(self.length / direct, 1.0) if direct > 0 else 1.0


Steer = Callable[[Pose2], tuple[float, Panorama]]
"""From a pose to the direction of home in the world [rad, NaN: no answer] and what was seen there."""


def walk(steer: Steer, start: Pose2, home: Point, turning: bool, settings: WalkSettings) -> Walk:
    """Walk from a start pose by asking `steer` anew at every step.

    turning: the robot looks where it goes; otherwise it keeps its heading. It slides along what the ranges say is in
    the way, keeps its direction for `coast` steps without an answer, and gives up where nothing is free.
    """
    pose, path = start, [(start.x, start.y)]
    direct, last, silent, side = math.dist(path[0], home), math.nan, 0, 1.0
    for _ in range(math.ceil(settings.longest * direct / settings.step) + 2):
        if math.dist(path[-1], home) <= settings.reach:
            return Walk(np.array(path), True)
        direction, seen = steer(pose)
        silent = 0 if math.isfinite(direction) else silent + 1
        if silent:
            direction = last if silent <= settings.coast else math.nan
        last = direction
        free = _free_direction(seen, pose, direction, settings, side)
        if free is None:
            break
        side = math.copysign(1.0, wrap(free - direction)) if free != direction else side
        heading = free if turning else pose.heading
        pose = Pose2(pose.x + settings.step * math.cos(free), pose.y + settings.step * math.sin(free), heading)
        path.append((pose.x, pose.y))
    return Walk(np.array(path), math.dist(path[-1], home) <= settings.reach)


@dataclass(frozen=True, slots=True)
class Eyes:
    """Views on the way, with what the compass says of them against the goal's; aligner None: they are aligned."""

    source: ViewSource
    goal: Panorama
    aligner: Aligner | None

    def look(self, pose: Pose2) -> tuple[Panorama, float]:
        """Return the view at a pose and its rotation [rad]."""
        seen = self.source.view(pose.x, pose.y, pose.heading)
        return seen, self.aligner.align(seen, self.goal).rotation if self.aligner else 0.0


def policy_walk(policy: HomingPolicy[Any], eyes: Eyes, start: Pose2, home: Point, settings: WalkSettings) -> Walk:
    """Walk as a policy says, each move as long as it wants, for up to `longest_policy` times the direct way."""
    pose, path, state = start, [(start.x, start.y)], policy.start(eyes.goal)
    homing = AlignedHoming(eyes.aligner or GivenHeading(), policy)
    left = settings.longest_policy * math.dist(path[0], home)
    while left > 0 and math.dist(path[-1], home) > settings.reach:
        seen, rotation = eyes.look(pose)
        state, move = homing.move(state, seen, rotation)
        if move.confidence <= 0.0 or not move.distance:
            break
        wanted = wrap(move.bearing + pose.heading)
        free = _free_direction(seen, pose, wanted, settings.model_copy(update={"step": move.distance}))
        if free is None:
            break
        pose = Pose2(pose.x + move.distance * math.cos(free), pose.y + move.distance * math.sin(free), pose.heading)
        path.append((pose.x, pose.y))
        left -= move.distance
    return Walk(np.array(path), math.dist(path[-1], home) <= settings.reach)


def _free_direction(
    seen: Panorama, pose: Pose2, wanted: float, settings: WalkSettings, side: float = 1.0
) -> float | None:
    if not math.isfinite(wanted):
        return None
    if seen.ranges is None:
        return wanted
    for slide in SLIDES:
        direction = wrap(wanted + side * math.radians(slide)) if slide else wanted
        if _clear(seen.ranges.astype(np.float64), direction - pose.heading, settings.step + settings.clearance):
            return direction
    return None


def _clear(ranges: FloatArray, bearing: float, distance: float, half: float = math.radians(12.0)) -> bool:
    count = len(ranges)
    middle, reach = round(bearing * count / TAU), max(round(half * count / TAU), 1)
    ahead = ranges[np.arange(middle - reach, middle + reach + 1) % count]
    return not bool(np.any(ahead < distance))  # NaN: nothing was measured, nothing is near


def catchment(positions: FloatArray, directions: FloatArray, home: Point, spacing: float) -> list[Walk]:
    """Return for each start (N, 2) [m] the walk through the vector field, directions (N,) [rad], over the grid.

    A step is half a spacing along the vector of the nearest grid position; home is reached within 0.75 spacings. A
    walk ends where the vector is missing (NaN), where it leaves the grid, or when it is 4 times as long as it need be.
    """
    here = positions.copy()
    paths = [here.copy()]
    target = np.asarray(home)
    limit = math.ceil(8 * float(np.hypot(*(positions - target).T).max()) / spacing) + 8
    alive = np.hypot(*(here - target).T) > 0.75 * spacing
    while alive.any() and len(paths) <= limit:
        offsets = positions[None, :, :] - here[alive][:, None, :]
        distance = np.hypot(offsets[..., 0], offsets[..., 1])
        nearest = distance.argmin(axis=1)
        direction = directions[nearest]
        step = 0.5 * spacing * np.column_stack([np.cos(direction), np.sin(direction)])
        moved = np.where(np.isfinite(step), here[alive] + step, here[alive])
        off = distance.min(axis=1) > spacing
        here = here.copy()
        here[alive] = np.where(off[:, None], here[alive], moved)
        stuck = off | ~np.isfinite(direction)
        paths.append(here)
        gone = np.zeros(len(here), bool)
        gone[np.flatnonzero(alive)[stuck]] = True
        alive = alive & ~gone & (np.hypot(*(here - target).T) > 0.75 * spacing)
    whole = np.stack(paths, axis=1)
    return [_trimmed(path, target, spacing) for path in whole]


def _trimmed(path: FloatArray, home: FloatArray, spacing: float) -> Walk:
    moving = np.flatnonzero(np.any(np.diff(path, axis=0) != 0, axis=1))
    end = int(moving[-1]) + 2 if len(moving) else 1
    return Walk(path[:end], bool(np.hypot(*(path[end - 1] - home)) <= 0.75 * spacing))
