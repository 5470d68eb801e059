"""Where the robot believes it is, how sure it is, and where else it may be."""

from __future__ import annotations

import math

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Hypothesis, MapChange, Motion, Where
from topomap.mapping.mapper import Mapper
from topomap.navigation.localiser.belief import Belief
from topomap.navigation.localiser.mixture import Mixture
from topomap.navigation.localiser.start import HERE, Start
from topomap.vision.image.compare import rotation_difference, signature

TRACKED = np.diag(np.square([0.3, 0.3, math.radians(5.0)]))
"""Covariance of a pose on a map that was just driven: its drift since the last closure."""
DOUBT = 1e-3
"""Probability that a belief that begins at a known place is wrong."""
TURN_SEEN, TURN_DIFFERS = math.radians(2.0), math.radians(8.0)
"""[rad] Error of a turn between two views, and from where on the odometry's is wrong: undisturbed they are at most
2.5 degrees apart in `office-loop`, `room-corridor` and `hall`, 5 where people pass."""
SLIP = (0.03, 0.02, 0.05)
"""Share of the way forward, of it to the side, and of the turn, that wheels misread on top of what they report."""
REST = (0.003, 0.003, 0.005)
"""[m], [m], [rad] Least error of a step."""
SURE = 0.02
"""Probability of being lost below which a robot that was lost takes itself as found ..."""
STRETCHES = 3
"""... after so many stretches held against the map."""
ASTRAY, ASTRAY_TURN = 1.0, math.radians(20.0)
"""[m], [rad] Belief and track this far apart tell two places: what a false closure is."""
TOLD = 5
"""Rivals that are told."""


class Localiser:
    """While the robot is taught and nothing speaks against it, it is where its track ends; otherwise a belief says.

    The belief holds what is seen against the whole map. Where it and the track part, the track is mended.
    """

    def __init__(self, start: Start = HERE) -> None:
        """start: where the belief begins; on a fresh map there is but one place."""
        self._start = start
        self._belief: Belief | None = None
        self._previous: Panorama | None = None
        self._lost = False

    def update(self, panorama: Panorama, mapper: Mapper, change: MapChange, driven: bool) -> Where:
        """Return the belief of this step; driven: somebody else has the wheels, and the map grows."""
        turn = self._seen_turn(panorama)
        self._previous = panorama
        nodes = mapper.recognition.nodes()
        if change.broken:
            self._begin_lost(mapper)
        elif self._belief is None:
            self._belief = self._begun(mapper, driven)
        if self._belief is None:
            return Where(change.pose, _nearest(change.pose, mapper, nodes), change.difference, 0.0)
        where = self._believe(self._belief, panorama, mapper, turn)
        event = change.broken or self._mend(where, mapper, driven)
        return _with_event(where, event)

    def _begun(self, mapper: Mapper, driven: bool) -> Belief | None:
        """Return a fresh belief where one is needed: on a map to be travelled, or where the start isn't the track."""
        start, self._start = self._start, HERE
        if start.unknown:
            self._lost = True
            return Belief(Mixture.unknown(), mapper.map)
        if start.pose is None and start.node is None and driven:
            return None
        pose = start.pose or (mapper.map.pose(start.node) if start.node is not None else mapper.track.pose)
        return Belief(Mixture.at(pose.array(), TRACKED, DOUBT), mapper.map)

    def _begin_lost(self, mapper: Mapper) -> None:
        self._lost = True
        self._belief = Belief(Mixture.unknown(), mapper.map)

    def _believe(self, belief: Belief, panorama: Panorama, mapper: Mapper, turn: float) -> Where:
        first = mapper.located
        nodes = mapper.recognition.nodes()[:first]
        belief.follow(mapper.map, nodes)
        belief.move(*_motion(mapper.track.motion, turn))
        belief.see(panorama, mapper, first)
        hypotheses = belief.hypotheses(nodes, mapper.map)
        if not hypotheses:
            return Where(mapper.track.pose, _nearest(mapper.track.pose, mapper, nodes), math.nan, 1.0)
        best = hypotheses[0]
        return Where(best.pose, best.node, belief.likeness, belief.lost, _rivals(hypotheses))

    def _mend(self, where: Where, mapper: Mapper, driven: bool) -> str:
        """Bring the map's track to where the robot is, once that is sure; return what was done."""
        belief = self._belief
        assert belief is not None
        sure = where.lost < SURE and belief.stretches >= STRETCHES
        if not sure:
            return ""
        off = mapper.track.pose.to(where.pose)
        apart = math.hypot(off.x, off.y) > ASTRAY or abs(off.heading) > ASTRAY_TURN
        found = self._lost
        self._lost = False
        if found or apart:
            mapper.relocate(where.pose)
        if driven:
            self._belief = None
        if found:
            return f"found itself near node {where.node}"
        return (
            f"the odometry was {math.hypot(off.x, off.y):.1f} m off: set right near node {where.node}" if apart else ""
        )

    def _seen_turn(self, panorama: Panorama) -> float:
        """Return the turn between the last two views [rad], NaN for the first."""
        if self._previous is None:
            return math.nan
        return rotation_difference(signature(panorama), signature(self._previous))[1]


def _motion(read: Motion, seen: float) -> tuple[Motion, FloatArray]:
    """Return the motion to move by and its covariance (3, 3): the turn as seen where the odometry's contradicts it."""
    way = abs(read.forward) + abs(read.left)
    slip = np.array([SLIP[0] * way, SLIP[1] * way, SLIP[2] * read.turn])
    noise = read.covariance + np.diag(np.square(slip) + np.square(REST))
    if not abs(wrap(seen - read.turn)) > TURN_DIFFERS:
        return read, noise
    noise[2, :], noise[:, 2] = 0.0, 0.0
    noise[2, 2] = TURN_SEEN**2
    return Motion(read.forward, read.left, seen, read.covariance, read.dt), noise


def _rivals(hypotheses: tuple[Hypothesis, ...]) -> tuple[Hypothesis, ...]:
    return tuple(h for h in hypotheses[1 : 1 + TOLD] if h.weight > 1e-3)


def _nearest(pose: Pose2, mapper: Mapper, nodes: IntArray) -> int | None:
    """Return the node nearest to a pose: a snapshot, where there is one."""
    if not len(nodes):
        return None
    away = np.hypot(*(mapper.map.poses[nodes, :2] - np.array([pose.x, pose.y])).T)
    return int(nodes[np.argmin(away)])


def _with_event(where: Where, event: str) -> Where:
    return Where(where.pose, where.node, where.difference, where.lost, where.rivals, event)
