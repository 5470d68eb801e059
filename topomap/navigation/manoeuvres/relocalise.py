"""The robot that is lost drives a short way through free space, until what it sees leaves one place."""

from __future__ import annotations

import math

import numpy as np

from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.geometry import TAU, wrap, wrap_all
from topomap.core.panorama import Panorama
from topomap.core.records import Command, Goal, Phase, Travel, Where
from topomap.mapping.mapper import Mapper
from topomap.navigation.manoeuvres.back_off import BackOff
from topomap.navigation.pilot import Pilot
from topomap.navigation.search.search_way import SearchWay
from topomap.vision.image.ground_line import ground_ranges

LOST, FOUND = 0.5, 0.05
"""Probability of being lost from which on the robot looks for itself, and below which it goes on with its journey."""
WAY = 30.0
"""[m] Way after which the search is given up: ten times what half of the searches in `office-loop` take."""
STEPS = 600
"""Steps after which it is given up, wherever the robot is: twice what the way takes at 0.25 m/s."""
SPEED = 0.3
"""[m/s] Limit meanwhile: three quarters of the pilot's, as nobody knows what comes."""
ROOM = 4.0
"""[m] Farther away nothing makes a direction better."""
LED = 0.15
"""Probability of the likeliest pose from which on the robot drives along the map as if it were there."""
NEXT = 0.8, 2.0
"""[m] How far off the place lies that it then drives to: the next one or the one after it."""
BESIDE, ASIDE = 2.0, 0.3
"""[m] Walls nearer than this on both sides are kept to the middle of, by a turn [rad] of at most so much."""
DIRECTIONS = 36
APERTURE = math.radians(15.0)
"""[rad] To either side of a direction that must be free as well: half a metre at two."""


class Relocalise:
    """Takes the wheels while the robot is lost on a journey.

    It never drives blind: it steers by ranges, without them by where the floor ends, backs off from what it touches and
    remembers where that stands.

    A panorama shows all directions at once, so turning on the spot would show nothing new: it drives at once, and turns
    round where the map says that the places where it may be part sooner that way.
    """

    def __init__(self, pilot: Pilot) -> None:
        self._pilot = pilot
        self._began: float | None = None
        self._steps = 0
        self._back_off = BackOff(pilot.body_radius)
        self._forward = False
        self._way = SearchWay()

    def step(
        self, panorama: Panorama, contact: bool, where: Where, goal: Goal, mapper: Mapper, searching: bool = False
    ) -> tuple[Command, Travel] | None:
        """Return the command and what was done, or None where the robot knows where it is.

        searching: it was carried, and has yet to prove what its first view may tell: nobody arrives by that alone.
        """
        going_on = self._began is not None or searching
        if goal.phase is not Phase.TRAVEL or where.lost <= (FOUND if going_on else LOST):
            self._end()
            return None
        track = mapper.track
        if self._began is None:
            self._began = track.travel
        self._steps += 1
        way = track.travel - self._began
        if way > WAY or self._steps > STEPS:
            self._end()
            return Command(), Travel(Phase.FAILED, note=f"lost: gave up after looking around for {way:.0f} m")
        towards, decided = self._way.step(where, mapper)
        note = f"lost ({where.lost:.2f}): {decided or 'looks around'}"
        command = self._drive(panorama, contact, where, mapper, towards)
        self._forward = command.forward > 0
        return command, Travel(Phase.TRAVEL, note=note)

    def _end(self) -> None:
        """Forget the search: the next one, for another goal, has its own time."""
        self._began, self._steps, self._forward = None, 0, False
        self._way.reset()

    def _drive(self, panorama: Panorama, contact: bool, where: Where, mapper: Mapper, towards: float | None) -> Command:
        """Return the command; towards: the bearing [rad] of the way that was chosen, None: as it looks."""
        track = mapper.track
        back = self._back_off.step(contact, track.raw, track.travel, self._forward)
        if back is not None:
            return back
        seen = panorama.ranges if panorama.ranges is not None else ground_ranges(panorama)
        ranges = self._back_off.ranges(seen, track.raw)
        assert ranges is not None
        bearing = towards
        if bearing is None and 1.0 - where.lost > LED:
            bearing = _along_the_map(where, mapper)
        return self._pilot.steer(free_bearing(ranges) if bearing is None else bearing, ranges, SPEED)


def _along_the_map(where: Where, mapper: Mapper) -> float | None:
    """Return the bearing [rad] of a place a little way off the likeliest pose, the one most ahead; None: there is none.

    If the robot is there it sees what it knows; if it isn't, that shows as well.
    """
    nodes = mapper.recognition.nodes()[: mapper.located]
    off = mapper.map.poses[nodes, :2] - np.array([where.pose.x, where.pose.y])
    away = np.hypot(off[:, 0], off[:, 1])
    near = (away >= NEXT[0]) & (away <= NEXT[1])
    if not near.any():
        return None
    bearings = wrap_all(np.arctan2(off[near, 1], off[near, 0]) - where.pose.heading)
    return float(bearings[np.argmin(np.abs(bearings))])


def free_bearing(ranges: Float32Array) -> float:
    """Return the bearing [rad] with the most room, the more so the less it turns the robot; ranges (W,) [m]."""
    directions = wrap_all(np.arange(DIRECTIONS) * TAU / DIRECTIONS)
    room = np.minimum(_room(directions, ranges), ROOM)
    score = room * (0.6 + 0.4 * np.cos(directions))
    return wrap(float(directions[np.argmax(score)]) + _to_the_middle(ranges))


def _to_the_middle(ranges: Float32Array) -> float:
    """Return the turn [rad] that leads to the middle between two walls: where most routes go, and views are known."""
    left, right = _room(np.array([math.pi / 2, -math.pi / 2]), ranges).tolist()
    if max(left, right) > BESIDE:
        return 0.0
    return float(np.clip(0.5 * (left - right), -ASIDE, ASIDE))


def _room(directions: FloatArray, ranges: Float32Array) -> FloatArray:
    """Return (D,) the nearest range within the aperture of each direction; what isn't measured tells nothing."""
    bearings = np.arange(len(ranges)) * TAU / len(ranges)
    aside = np.abs(wrap_all(bearings[None] - directions[:, None])) <= APERTURE
    known = np.where(np.isfinite(ranges), ranges, np.inf)
    nearest: FloatArray = np.where(aside, known[None], np.inf).min(axis=1)
    return nearest
