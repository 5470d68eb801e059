"""The belief on a map: hypotheses that move with the odometry and live or die by what is seen."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import Pose2, between, compose, wrap_all
from topomap.core.panorama import Panorama
from topomap.core.records import Hypothesis, Motion
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapper import Mapper
from topomap.navigation.localiser.fix import fix
from topomap.navigation.localiser.likeness import log_ratio
from topomap.navigation.localiser.mixture import Mixture
from topomap.navigation.localiser.views import Seen, look
from topomap.vision.image.compare import signature

LOOK = 0.08
"""[m] Way between looks: passed within 5 cm, a place of `office-loop` looks more like itself than any of its 260
look-alikes in more than half of all cases; a decimetre beside it ten of them look more like it."""
STRETCH = 1.0
"""[m] Way whose best view counts once: snapshots are at most 1 m apart, so that every hypothesis passes one."""
APART, APART_SHARE = 0.02, 0.25
"""By how much the squared likeness of a place that is passed varies, at least and as a share of the least one."""
ASIDE_LEAST, ASIDE_SHARE = 0.05, 0.75
"""By how much more it may differ for being passed a hand's breadth further aside, which isn't a matter of the place: in
`office-loop` the squared likeness is 0.02 passed 5 cm aside, 0.12 at 15 cm and 0.37 at 30 cm; a poster on the wall adds
0.13. Two corridors alike must not be told apart by how well the driver kept to the middle of each."""
HARDEST = 5.0
"""What one stretch can say against a hypothesis [nats]: the errors of neighbouring views hang together."""
REACH = 1.0
"""[m] A place farther than this from a hypothesis isn't expected to be seen from it."""
SEARCHED, ASIDE = 160, 8
"""Places, of those most alike, where the robot may be as well: while it is lost, and while it isn't."""
ESCAPE = 1e-3
"""Probability to be carried away unnoticed within a stretch: once in 800 m."""
AT_BIRTH = 1.5
"""What the first view can say [nats]: it is taken up to half a metre from the place, where others look more like it."""
BORN = np.diag(np.square([0.35, 0.35, math.radians(8.0)]))
"""Covariance of a place found by its view: it is told from its neighbour half a metre off, and to two columns."""
BY_VIEW = np.diag(np.square([0.5, 0.5, math.radians(8.0)]))
"""Covariance of a pose by the likeness of its neighbours, seen five times a metre by errors that hang together."""
ALIKE = 0.6
"""Likeness up to which a view corrects a pose: nine of ten views at the place are below."""
TELLING = 0.2
"""Likeness by which the nearer of two neighbours wins: their difference halfway to the next one."""
LED = 0.2
"""Weight from which on a hypothesis is worth a fix by ranges."""


@dataclass(frozen=True, slots=True, eq=False)
class Nearby:
    """The places near each of n hypotheses: which (n, 3), as numbers of snapshots, and whether they are near (n, 3)."""

    places: IntArray
    near: BoolArray


class Belief:
    """Hypotheses over the first places of a map.

    first: how many of the map's snapshots are known to lie where the map has them.
    """

    def __init__(self, mixture: Mixture, topo: TopoMap) -> None:
        self.mixture = mixture
        self._poses = topo.poses.copy()
        self._since_look, self._since_weighed = math.inf, 0.0
        self._fresh = True
        self.stretches = 0
        self.likeness = math.nan

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

    def see(self, panorama: Panorama, mapper: Mapper, first: int) -> None:
        """Hold the hypotheses against the view, where it can have changed since the last look."""
        if self._since_look < LOOK or not first:
            return
        self._since_look = 0.0
        nodes = mapper.recognition.nodes()[:first]
        nearby = self._nearby(mapper.map.poses[nodes])
        due, fresh, self._fresh = self._since_weighed >= STRETCH, self._fresh, False
        count = 0 if not (due or fresh) else SEARCHED if self.lost > 0.05 else ASIDE
        seen = look(signature(panorama), mapper.recognition, nearby.places[nearby.near], count, first)
        self._compare(seen, nearby, mapper.map.poses[nodes])
        if due:
            self._since_weighed = 0.0
            self._weigh(seen)
        if due or fresh:
            self._add(seen, mapper.map.poses[nodes])
            self.mixture = self.mixture.pruned()
        self._fix(panorama, mapper, nodes)

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

    def _compare(self, seen: Seen, nearby: Nearby, places: FloatArray) -> None:
        """Take each hypothesis's likeness to the places near it, and correct its pose by them."""
        n, k = nearby.places.shape
        if not n:
            return
        expected = wrap_all(self.mixture.poses[:, None, 2] - places[nearby.places, 2])
        likeness, rotation = np.full((n, k), np.inf), np.zeros((n, k))
        likeness[nearby.near], rotation[nearby.near] = seen.at(nearby.places[nearby.near], expected[nearby.near])
        least = likeness.min(axis=1)
        self.mixture = replace(self.mixture, best=np.minimum(self.mixture.best, least))
        self.likeness = float(least[np.argmax(self.mixture.weights)])
        alike = np.flatnonzero(least < ALIKE)
        rows = likeness[alike]
        share = np.exp(-0.5 * (np.square(rows) - np.square(rows.min(axis=1))[:, None]) / TELLING**2)
        share /= share.sum(axis=1, keepdims=True)
        there = (share[:, :, None] * places[nearby.places[alike], :2]).sum(axis=1)
        best = rows.argmin(axis=1)
        heading = places[nearby.places[alike, best], 2] + rotation[alike, best]
        poses = np.column_stack([there, wrap_all(heading)])
        self.mixture = self.mixture.measured(alike, poses, np.broadcast_to(BY_VIEW, (len(alike), 3, 3)))

    def _weigh(self, seen: Seen) -> None:
        """Weigh each hypothesis by its best view on the last stretch."""
        best = self.mixture.best
        told = np.isfinite(best)
        ratios = np.zeros(len(best))
        if told.any():
            # all have passed their places as far aside as the robot drives: only what is left tells them apart
            least = best[told].min()
            more = np.square(best[told]) - least**2 - (ASIDE_LEAST + ASIDE_SHARE * least**2)
            behind = np.maximum(more, 0.0) / (APART + APART_SHARE * least**2)
            ratios[told] = log_ratio(np.array([least]), seen.others) - np.minimum(behind, HARDEST)
        self.mixture = replace(self.mixture.weighed(ratios, ESCAPE), best=np.full(len(best), np.inf))
        self.stretches += 1

    def _add(self, seen: Seen, places: FloatArray) -> None:
        """Add the places that look like the view: each, any way round, was as likely as any other before."""
        where, likeness, rotation = seen.minima()
        poses = np.column_stack([places[where, :2], wrap_all(places[where, 2] + rotation)])
        fresh = ~self.mixture.near(poses).any(axis=1) & (likeness < 1.0)
        ratio = np.clip(log_ratio(likeness, seen.others), -AT_BIRTH, AT_BIRTH)
        weights = self.mixture.elsewhere - math.log(2 * len(places)) + ratio
        self.mixture = self.mixture.joined_by(
            poses[fresh], BORN, weights[fresh], np.full(int(fresh.sum()), np.inf)
        ).normalised()

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
