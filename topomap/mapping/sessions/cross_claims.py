"""Places of one map that another holds as well: by place search, detailed comparison and measured relative pose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import PlaceMatch
from topomap.mapping.closures.appearance import Look
from topomap.mapping.closures.looks import WITH_RIVALS, log_ratio
from topomap.mapping.closures.relative_pose import RelativePoseEstimator, RelativePoseSettings
from topomap.mapping.closures.sight_tests import MOST_COST, TIMES_USUAL
from topomap.mapping.graph import TopoMap
from topomap.mapping.places.place_index import PlaceIndex
from topomap.mapping.places.view_cache import ViewCache
from topomap.vision.contracts import Aligner
from topomap.vision.image.compare import signature

SHORTLIST = 8
"""Most similar places that are compared in detail, as on a drive."""
ELSEWHERE = 1.5
"""[m] A node this far from the winner is another place."""
FARTHEST = 0.8
"""[m] Places measured to lie farther apart are two."""


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """Node j of the second map was taken where node i of the first was: `i_from_j` with covariance (3, 3).

    looks: log of how much likelier the views are so than if it was elsewhere; cost: of their alignment.
    """

    i: int
    j: int
    relative: Pose2
    covariance: FloatArray
    looks: float
    cost: float


class CrossClaims:
    """Looks for each view of one map in another."""

    def __init__(self, aligner: Aligner, offset: RelativePoseSettings) -> None:
        self._aligner = aligner
        self._offset = RelativePoseEstimator(offset)

    def between(self, first: TopoMap, second: TopoMap, told: Callable[[float], None]) -> list[Seen]:
        """Return where views of the second map are likelier in the first than not; told: the share done."""
        index, nodes = PlaceIndex(), _with_view(first)
        here, there = ViewCache(first), ViewCache(second)
        for node in nodes:
            index.add(signature(here.panorama(node)))
        found = []
        asked = _with_view(second)
        for k, node in enumerate(asked):
            told(k / len(asked))
            view = there.panorama(node)
            places, differences = index.search(signature(view), SHORTLIST)
            rows = zip(places.tolist(), differences.difference.tolist(), differences.rotation.tolist(), strict=True)
            looks = [self._look(PlaceMatch(nodes[k], d, r), view, here) for k, d, r in rows]
            seen = self._judge(first, here, view, node, sorted(looks, key=_cost))
            found += [] if seen is None else [seen]
        return found

    def near(self, joined: TopoMap, count: int, standing: list[Seen], told: Callable[[float], None]) -> list[Seen]:
        """Return where views of the second map were taken beside those of the first, now that both lie in one frame.

        Places that look the same elsewhere are no rivals any more: as on a drive, only what is in reach is compared.
        count: nodes of the first map, those of the second come after them; standing: what joined them, which tells what
        a place seen in both usually costs; told: the share done.
        """
        most = min(MOST_COST, TIMES_USUAL * float(np.median([seen.cost for seen in standing])))
        looks = {seen.j: seen.looks for seen in standing}
        index, views = PlaceIndex(), ViewCache(joined)
        nodes = np.array([node for node in _with_view(joined) if node < count])
        for node in nodes.tolist():
            index.add(signature(views.panorama(node)))
        found = []
        asked = [node for node in _with_view(joined) if node >= count]
        for k, node in enumerate(asked):
            told(k / len(asked))
            away = np.hypot(*(joined.poses[nodes, :2] - joined.poses[node, :2]).T)
            within = np.flatnonzero(away <= FARTHEST)
            if len(within):
                found += self._beside(views, node, nodes, within, index, most)
        return [replace(seen, looks=looks.get(seen.j, 0.0)) for seen in found]

    def _beside(
        self, views: ViewCache, node: int, nodes: IntArray, within: IntArray, index: PlaceIndex, most: float
    ) -> list[Seen]:
        """Return the place within reach that a view is most like, none where it isn't like enough."""
        view = views.panorama(node)
        found = index.compare(signature(view), within)
        likely = np.argsort(found.difference, kind="stable")[:SHORTLIST].tolist()
        matches = [
            PlaceMatch(int(nodes[within[k]]), float(found.difference[k]), float(found.rotation[k])) for k in likely
        ]
        best = min((self._look(match, view, views) for match in matches), key=_cost)
        offset = self._offset.measure(best, views.panorama(best.match.node), view)
        if _cost(best) > most or np.hypot(offset.relative.x, offset.relative.y) > FARTHEST:
            return []
        return [Seen(best.match.node, node, offset.relative, offset.covariance, 0.0, _cost(best))]

    def _look(self, match: PlaceMatch, view: Panorama, here: ViewCache) -> Look:
        return Look(match, self._aligner.align(view, here.panorama(match.node), match.rotation))

    def _judge(self, first: TopoMap, here: ViewCache, view: Panorama, node: int, looks: list[Look]) -> Seen | None:
        if not looks:
            return None
        best = looks[0].match.node
        others = [_cost(look) for look in looks if first.length(look.match.node, best) > ELSEWHERE]
        if not others:
            return None  # nothing tells what a likeness is worth here
        weight = log_ratio(WITH_RIVALS, _cost(looks[0]), others[0], float(np.median(others)))
        if weight <= 0.0:
            return None
        offset = self._offset.measure(looks[0], here.panorama(best), view)
        if np.hypot(offset.relative.x, offset.relative.y) > FARTHEST:
            return None
        return Seen(best, node, offset.relative, offset.covariance, weight, _cost(looks[0]))


def _cost(look: Look) -> float:
    return look.alignment.residual


def _with_view(topo: TopoMap) -> list[int]:
    return [node for node in topo.chain if topo.nodes[node].snapshot is not None]
