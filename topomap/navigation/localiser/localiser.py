"""Where the robot believes it is, how sure it is, and where else it may be."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import Hypothesis, MapChange, Motion, Verdict, Where
from topomap.mapping.closures.appearance import apart
from topomap.mapping.closures.sight import SLOW
from topomap.mapping.mapper import Mapper
from topomap.navigation.localiser.belief import REACH, Belief
from topomap.navigation.localiser.mixture import Mixture
from topomap.navigation.localiser.start import HERE, Start

TRACKED = np.diag(np.square([0.3, 0.3, math.radians(5.0)]))
"""Covariance of a pose on a map that was just driven: its drift since the last closure."""
DOUBT = 1e-3
"""Probability that a belief that begins at a known place is wrong."""
SHAKEN = 0.8
"""Probability that a break, as it is noticed, left the robot where it doesn't know: somebody may but have hidden the
view, or the wheels have stood still while the belief followed by what was seen."""
HANDLED = 0.5
"""Probability that who turned the robot on the spot also took it to a place that looks the same: of ten robots set down
anywhere in `office-loop`, one stood before another door of the same look."""
SLIP = (0.03, 0.02, 0.05)
"""Share of the way forward, of it to the side, and of the turn, that wheels misread on top of what they report."""
REST = (0.003, 0.003, 0.005)
"""[m], [m], [rad] Least error of a step."""
UNTOLD = np.diag(np.square([0.1, 0.1, math.radians(5.0)]))
"""Covariance of a step whose odometry is doubted: a step at 0.4 m/s is 0.1 m."""
SURE = 0.02
"""Probability of being lost below which a robot that was lost takes itself as found ..."""
STRETCHES = 3
"""... after so many stretches held against the map."""
ASTRAY, ASTRAY_TURN = 1.0, math.radians(20.0)
"""[m], [rad] Belief and track this far apart tell two places: what a false closure is; where views change slowly, as
far apart as they tell places. Within it they show the same, and a belief is no surer of where than odometry is."""
DOUBTFUL = 0.1
"""Probability of being lost up to which belief and track are taken to agree."""
UNPROVEN = 0.051
"""The least that is told of a robot that was lost before enough stretches have spoken: just too much for a journey to
go on. After two, neighbours a metre off in `hall` were told apart wrongly."""
TOLD = 5
"""Rivals that are told."""


class Localiser:
    """While the robot is taught and nothing speaks against it, it is where its track ends; otherwise a belief says.

    The belief holds what is seen against the whole map. Where it and the track part, the track is mended. While the
    robot is taught it watches on known ground alone: new ground may look like any place. And then it holds the view
    against earlier passes alone: what this one stored was seen from as far beside the way and in the same light, so
    that along a corridor another door of this pass is more alike than the place itself as an earlier one saw it.
    """

    def __init__(self, start: Start = HERE) -> None:
        """start: where the belief begins; on a fresh map there is but one place."""
        self._start = start
        self._belief: Belief | None = None
        self._lost = start.unknown  # from a break on, until the belief is sure again
        self._unproven = False  # the same, and after it was turned by no wheel
        self._right: int | None = None  # the last node of the track that the belief agreed with
        self._earlier: int | None = None  # snapshots, of the first ones, made before this pass over known ground

    @property
    def searching(self) -> bool:
        """Whether the robot was carried and hasn't found itself yet."""
        return self._lost

    @property
    def unproven(self) -> bool:
        """Whether it was carried or turned, and what it sees hasn't proved yet where it is."""
        return self._unproven

    def update(self, panorama: Panorama, mapper: Mapper, change: MapChange, driven: bool) -> Where:
        """Return the belief of this step; driven: somebody else has the wheels, and the map grows."""
        if change.broken:
            self._lost, self._belief = True, self._shaken(mapper)
        elif driven and not self._lost and not self._on_known_ground(mapper):
            self._belief, self._earlier = None, len(mapper.recognition)
        elif self._belief is None:
            self._belief = self._begun(mapper, change, driven)
        if self._belief is not None and mapper.handled and not change.broken:
            self._belief.shake(HANDLED)
            self._unproven = True
        tracked = Where(change.pose, _nearest(change.pose, mapper, mapper.recognition.nodes()), change.difference, 0.0)
        if self._belief is None:
            return tracked
        watching = driven and not self._lost
        where = self._believe(self._belief, panorama, mapper, self._first(mapper, driven))
        event = change.broken or self._mend(where, mapper, driven)
        proven = self._belief.stretches >= STRETCHES and where.lost < SURE
        self._belief.proven |= proven
        self._unproven = self._lost or (self._unproven and not proven)
        if not watching:
            return replace(where, lost=max(where.lost, UNPROVEN if self._unproven else 0.0), event=event)
        return replace(tracked, lost=self._doubt(self._belief, mapper), rivals=where.rivals, event=event)

    def _shaken(self, mapper: Mapper) -> Belief:
        """Return the belief behind a break: the robot may be anywhere, or, rarely, where it was in spite of it."""
        before = (
            self._belief.mixture if self._belief is not None else Mixture.at(mapper.track.pose.array(), TRACKED, DOUBT)
        )
        return Belief(before.shaken(SHAKEN), mapper.map)

    def _begun(self, mapper: Mapper, change: MapChange, driven: bool) -> Belief | None:
        """Return a fresh belief where one is needed: on a journey, where the start isn't the track, on known ground."""
        start, self._start = self._start, HERE
        if start.unknown:
            self._earlier = mapper.located
            return Belief(Mixture.unknown(), mapper.map)
        given = start.pose or (mapper.map.pose(start.node) if start.node is not None else None)
        if given is None and driven and not any(d.verdict is Verdict.ACCEPTED for d in change.decisions):
            return None
        if driven:
            self._earlier = min(self._first(mapper, driven), _pass_began(mapper))
        self._right = mapper.map.chain[-1]
        return Belief(Mixture.at((given or mapper.track.pose).array(), TRACKED, DOUBT), mapper.map)

    def _first(self, mapper: Mapper, driven: bool) -> int:
        """Return how many snapshots, of the first ones, the view is held against."""
        if not driven:
            return mapper.located
        earlier = len(mapper.recognition) if self._earlier is None else self._earlier
        return min(earlier, mapper.located if self._lost else mapper.left_behind)

    def _on_known_ground(self, mapper: Mapper) -> bool:
        """Return whether the track has the robot near a place of an earlier pass, left long enough ago."""
        return _near_one(mapper.track.pose, mapper, mapper.recognition.nodes()[: self._first(mapper, driven=True)])

    def _believe(self, belief: Belief, panorama: Panorama, mapper: Mapper, first: int) -> Where:
        nodes = mapper.recognition.nodes()[:first]
        belief.follow(mapper.map, nodes)
        belief.move(mapper.track.motion, _noise(mapper.track.motion, mapper.doubted))
        belief.see(panorama, mapper, first)
        hypotheses = belief.hypotheses(nodes, mapper.map, 1 + TOLD) if len(nodes) else ()
        if not hypotheses:
            return Where(mapper.track.pose, _nearest(mapper.track.pose, mapper, nodes), math.nan, 1.0)
        best = hypotheses[0]
        return Where(best.pose, best.node, belief.likeness, belief.lost, _rivals(hypotheses))

    def _mend(self, where: Where, mapper: Mapper, driven: bool) -> str:
        """Bring the map's track to where the robot is, once that is sure; return what was done."""
        belief = self._belief
        assert belief is not None
        off = mapper.track.pose.to(where.pose)
        alike = _alike(mapper)
        astray = math.hypot(off.x, off.y) > max(ASTRAY, alike) or (abs(off.heading) > ASTRAY_TURN and not alike)
        if not astray and where.lost < DOUBTFUL:
            self._right = mapper.map.chain[-1]
        if where.lost >= SURE or belief.stretches < STRETCHES:
            return ""
        found, self._lost = self._lost, False
        if not found and not astray:
            return ""
        mapper.relocate(where.pose, None if found else self._right)
        self._right = mapper.map.chain[-1]
        if found:
            return f"found itself near node {where.node}"
        return f"the odometry was {math.hypot(off.x, off.y):.1f} m off: set right near node {where.node}"

    def _doubt(self, belief: Belief, mapper: Mapper) -> float:
        """Return the probability that the robot isn't where its track ends."""
        near = belief.mixture.near(mapper.track.pose.array()[None], _alike(mapper))[0]
        return max(0.0, 1.0 - float(np.exp(belief.mixture.weights[near]).sum()))


def _alike(mapper: Mapper) -> float:
    """Return how far from one another two places are that the views don't tell apart here [m]; 0 where they do."""
    catchment = mapper.catchment
    return apart(catchment) if catchment >= SLOW else 0.0


def _noise(motion: Motion, doubted: bool) -> FloatArray:
    """Return the covariance (3, 3) of a corrected motion; doubted: wheels and views contradict one another."""
    if doubted:
        return UNTOLD
    way = abs(motion.forward) + abs(motion.left)
    slip = np.array([SLIP[0] * way, SLIP[1] * way, SLIP[2] * motion.turn])
    return motion.covariance + np.diag(np.square(slip) + np.square(REST))


def _pass_began(mapper: Mapper) -> int:
    """Return how many snapshots were made before the pass over known ground that the track is on.

    The track may have been off for a while before a closure set it right: so it is told by where the snapshots lie now.
    """
    nodes = mapper.recognition.nodes().tolist()
    while nodes:
        older = mapper.recognition.old_nodes(mapper.map.nodes[nodes[-1]].travel)
        if not _near_one(mapper.map.pose(nodes[-1]), mapper, older):
            break
        nodes.pop()
    return len(nodes)


def _near_one(pose: Pose2, mapper: Mapper, nodes: IntArray) -> bool:
    """Return whether a pose lies within reach of one of some nodes (n,)."""
    away = np.hypot(mapper.map.poses[nodes, 0] - pose.x, mapper.map.poses[nodes, 1] - pose.y)
    return bool(len(nodes)) and float(away.min()) <= REACH


def _rivals(hypotheses: tuple[Hypothesis, ...]) -> tuple[Hypothesis, ...]:
    return tuple(h for h in hypotheses[1:] if h.weight > 1e-3)


def _nearest(pose: Pose2, mapper: Mapper, nodes: IntArray) -> int | None:
    """Return the node nearest to a pose: a snapshot, where there is one."""
    if not len(nodes):
        return None
    away = np.hypot(*(mapper.map.poses[nodes, :2] - np.array([pose.x, pose.y])).T)
    return int(nodes[np.argmin(away)])
