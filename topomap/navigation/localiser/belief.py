"""The belief on a map: hypotheses that move with the odometry and live or die by what is seen."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import Pose2, between, compose, wrap_all
from topomap.core.panorama import Panorama
from topomap.core.records import Hypothesis, Motion
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapper import Mapper
from topomap.navigation.localiser.fix import fix
from topomap.navigation.localiser.hidden import measured_in_part, seen_in_part
from topomap.navigation.localiser.mixture import Mixture
from topomap.navigation.localiser.set_down import set_down
from topomap.navigation.localiser.tint import unlike
from topomap.navigation.localiser.views import Found, Seen, Usual, look, usual
from topomap.navigation.localiser.weighing import by_first_view, by_stretch, with_places
from topomap.vision.image.surroundings import surroundings

LOOK = 0.16
"""[m] Way between looks: as far as the points apart from which a view is predicted."""
STRETCH = 1.0
"""[m] Way whose looks count once: snapshots are at most 1 m apart, and over it the place itself was the most alike of
120 in 21 of 24 tries in `office-loop`."""
REACH = 1.0
"""[m] A place farther than this from a hypothesis isn't expected to be seen from it."""
SEARCHED, ASIDE = 160, 8
"""Places, of those most alike, where the robot may be as well: while it is lost, and while it isn't."""
BY_VIEW = np.diag(np.square([0.5, 0.5, math.radians(8.0)]))
"""Covariance of a pose by the likeness of its neighbours, seen five times a metre by errors that hang together."""
ALIKE = 0.5
"""Likeness up to which a view corrects a pose: 97 of 100 views at the place are below, in three worlds. What is above
tells no more than that it isn't like the place, or that something hides it: one look at 1.1 would outweigh a metre."""
TELLING = 0.2
"""Likeness by which the nearer of two neighbours wins: their difference halfway to the next one."""
COLOURED, WEIGHTY = 12, 0.01
"""Hypotheses whose colours are looked at, the likeliest: the view of each may have to be decoded, for 2 ms; and the
weight they have at least."""
BEGUN, GONE = 0.05, 0.5
"""Probability of being lost below which a belief begins at a known place, and from which on one is proven no more."""
LED = 0.2
"""Weight from which on a hypothesis is worth a fix by ranges."""


@dataclass(frozen=True, slots=True, eq=False)
class Nearby:
    """The places near each of n hypotheses: which (n, 3), as numbers of snapshots, and whether they are near (n, 3)."""

    places: IntArray
    near: BoolArray


class Belief:
    """Hypotheses over the first places of a map.

    first: how many of the map's snapshots are known to lie where the map has them; proven: it began at a known place,
    or whole views have proved it since the robot may have been anywhere.
    """

    def __init__(self, mixture: Mixture, topo: TopoMap) -> None:
        self.mixture = mixture
        self._poses = topo.poses.copy()
        self._since_look, self._since_weighed = math.inf, 0.0
        self._fresh = True
        self._usual: Usual | None = None
        self.stretches = 0
        self.likeness = math.nan
        self.proven = self.lost < BEGUN

    def follow(self, topo: TopoMap, nodes: IntArray) -> None:
        """Carry the hypotheses along when the map was moved."""
        count = len(self._poses)
        if len(self.mixture) and not np.array_equal(self._poses, topo.poses[:count]):
            known = nodes[nodes < count]
            away = np.hypot(*(self.mixture.poses[:, None, :2] - self._poses[None, known, :2]).transpose(2, 0, 1))
            nearest = known[np.argmin(away, axis=1)]
            self.mixture = self.mixture.carried(nearest, self._poses, topo.poses)
        if count != len(topo.poses) or not np.array_equal(self._poses, topo.poses):
            self._poses = topo.poses.copy()

    def move(self, motion: Motion, noise: FloatArray) -> None:
        """Move all hypotheses by a corrected motion with its covariance (3, 3)."""
        self.mixture = self.mixture.moved(motion, noise)
        way = math.hypot(motion.forward, motion.left)
        self._since_look += way
        self._since_weighed += way

    def shake(self, doubt: float) -> None:
        """Let the robot be anywhere with a probability of `doubt`, and look around at once."""
        self.mixture, self._fresh, self._since_look = self.mixture.shaken(doubt), True, math.inf
        self.stretches, self.proven = 0, False

    def see(self, panorama: Panorama, mapper: Mapper, first: int) -> None:
        """Hold the hypotheses against the view, where it can have changed since the last look."""
        if self._since_look < LOOK or not first:
            return
        self._since_look = 0.0
        nodes = mapper.recognition.nodes()[:first]
        nearby = self._nearby(mapper.map.poses[nodes])
        due, fresh, self._fresh = self._since_weighed >= STRETCH, self._fresh, False
        count = 0 if not (due or fresh) else SEARCHED if self.lost > 0.05 else ASIDE
        view = surroundings(panorama)
        if due or fresh or self._usual is None:
            self._usual = usual(view, mapper.recognition, first)
        seen = look(view, mapper.recognition, nearby.places[nearby.near], count, first, self._usual)
        told, places, found = self._compare(seen, nearby, mapper.map.poses[nodes])
        self.mixture = self.mixture.tinted(told, self._tints(panorama, mapper, told, nodes[places], found))
        if due or fresh:
            self._since_weighed = 0.0
            self.stretches += not fresh
            weighed = by_first_view(self.mixture, seen) if fresh else self._by_stretch(panorama, mapper, nodes, seen)
            join = set_down if fresh and count >= SEARCHED else with_places
            self.mixture = join(weighed, seen, mapper.map.poses[nodes]).pruned()
        self._fix(panorama, mapper, nodes)

    def _by_stretch(self, panorama: Panorama, mapper: Mapper, nodes: IntArray, seen: Seen) -> Mixture:
        """Weigh by the last stretch; where the likeliest place is unlike the view, ask what isn't hidden of it.

        That keeps a belief that whole views have proved; it finds nobody: before other doors of the same look a part is
        as alike more often.
        """
        self.proven &= self.lost < GONE
        if not self.proven or not self.likeness >= ALIKE:
            return by_stretch(self.mixture, seen)
        hidden = seen_in_part(panorama, self.mixture, mapper, nodes)
        weighed = by_stretch(self.mixture, seen, hidden)
        return measured_in_part(panorama, weighed, mapper, nodes) if hidden else weighed

    @property
    def lost(self) -> float:
        """The probability that the robot isn't at the likeliest hypothesis."""
        return 1.0 - float(np.exp(self.mixture.weights.max())) if len(self.mixture) else 1.0

    def hypotheses(self, nodes: IntArray, topo: TopoMap, count: int) -> tuple[Hypothesis, ...]:
        """Return the `count` likeliest hypotheses, best first, each with the snapshot node nearest to it."""
        found = []
        for k in np.argsort(-self.mixture.weights, kind="stable")[:count].tolist():
            away = np.hypot(*(topo.poses[nodes, :2] - self.mixture.poses[k, :2]).T)
            node = int(nodes[np.argmin(away)])
            found.append(Hypothesis(node, Pose2.of(self.mixture.poses[k]), float(np.exp(self.mixture.weights[k]))))
        return tuple(found)

    def _nearby(self, places: FloatArray) -> Nearby:
        away = np.hypot(*(self.mixture.poses[:, None, :2] - places[None, :, :2]).transpose(2, 0, 1))
        count = min(3, len(places))
        nearest = (
            np.argpartition(away, count - 1, axis=1)[:, :count]
            if count < len(places)
            else (np.tile(np.arange(len(places)), (len(away), 1)))
        )
        return Nearby(nearest, np.take_along_axis(away, nearest, axis=1) <= REACH)

    def _compare(self, seen: Seen, nearby: Nearby, places: FloatArray) -> tuple[IntArray, IntArray, Found]:
        """Take each hypothesis's likeness to the places near it, and correct its pose by them.

        Return which hypotheses (k,) have one, the most alike place of each (k,), and how it was found.
        """
        n, k = nearby.places.shape
        if not n:
            return np.zeros(0, np.int64), np.zeros(0, np.int64), Found(np.zeros(0), np.zeros(0), np.zeros((0, 2)))
        expected = wrap_all(self.mixture.poses[:, None, 2] - places[nearby.places, 2])
        likeness, poses = np.full((n, k), np.inf), np.zeros((n, k, 3))
        found = seen.at(nearby.places[nearby.near], expected[nearby.near])
        likeness[nearby.near] = found.likeness
        which = np.zeros((n, k), np.int64)
        which[nearby.near] = np.arange(len(found.likeness))
        poses[nearby.near] = found.poses(places[nearby.places[nearby.near]])
        least = likeness.min(axis=1)
        self.likeness = float(least[np.argmax(self.mixture.weights)])
        told = np.flatnonzero(np.isfinite(least))
        self.mixture = self.mixture.looked(told, np.square(least[told]), ALIKE**2)
        alike = np.flatnonzero(least < ALIKE)
        rows = likeness[alike]
        share = np.exp(-0.5 * (np.square(rows) - np.square(rows.min(axis=1))[:, None]) / TELLING**2)
        share /= share.sum(axis=1, keepdims=True)
        there = (share[:, :, None] * poses[alike, :, :2]).sum(axis=1)
        heading = poses[alike, rows.argmin(axis=1), 2]
        measured = np.column_stack([there, heading])
        self.mixture = self.mixture.measured(alike, measured, np.broadcast_to(BY_VIEW, (len(alike), 3, 3)))
        best = likeness[told].argmin(axis=1)
        rows = which[told, best]
        return told, nearby.places[told, best], Found(found.likeness[rows], found.rotations[rows], found.points[rows])

    def _tints(self, panorama: Panorama, mapper: Mapper, told: IntArray, nodes: IntArray, found: Found) -> FloatArray:
        """Return how unlike in colour (k,) hypotheses (k,) are to their places' nodes (k,); the unlikely ones pass for
        as alike as any.
        """
        weights = self.mixture.weights[told]
        led = np.argsort(-weights, kind="stable")[:COLOURED]
        led = led[weights[led] > math.log(WEIGHTY)]
        squares = np.zeros(len(told))
        if len(led) > 1:
            squares[led] = [
                unlike(panorama, mapper.view_cache.panorama(int(nodes[k])), float(found.rotations[k]), _point(found, k))
                for k in led.tolist()
            ]
            squares = np.minimum(squares, ALIKE**2)
            squares[np.setdiff1d(np.arange(len(told)), led)] = squares[led].min()
        return squares

    def _fix(self, panorama: Panorama, mapper: Mapper, nodes: IntArray) -> None:
        """Measure the likeliest hypothesis's pose against the place nearest to it."""
        if not len(self.mixture):
            return
        k = int(np.argmax(self.mixture.weights))
        pose = self.mixture.poses[k]
        away = np.hypot(*(mapper.map.poses[nodes, :2] - pose[:2]).T)
        node = int(nodes[np.argmin(away)])
        if self.mixture.weights[k] < math.log(LED) or float(away.min()) > REACH or not self.likeness < ALIKE:
            return
        place = mapper.map.poses[node]
        found = fix(panorama, mapper.view_cache.panorama(node), Pose2.of(between(place, pose)))
        if found is None:
            return
        c, s = math.cos(place[2]), math.sin(place[2])
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        measured = compose(place, found.relative)
        covariance = turn @ found.covariance @ turn.T
        self.mixture = self.mixture.measured(np.array([k]), measured[None], covariance[None])


def _point(found: Found, k: int) -> tuple[float, float]:
    x, y = found.points[k].tolist()
    return x, y
