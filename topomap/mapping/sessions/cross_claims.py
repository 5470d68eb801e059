"""Places of one map that another holds as well: by place search, detailed comparison and measured relative pose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from topomap.core.arrays import FloatArray
from topomap.core.geometry import Pose2
from topomap.core.records import PlaceMatch
from topomap.mapping.closures.appearance import AppearanceSettings, AppearanceTest
from topomap.mapping.closures.relative_pose import RelativePoseEstimator, RelativePoseSettings
from topomap.mapping.graph import TopoMap
from topomap.mapping.places.place_index import PlaceIndex
from topomap.mapping.places.view_cache import ViewCache
from topomap.vision.contracts import Aligner
from topomap.vision.image.compare import signature

SHORTLIST = 8
"""Most similar places that are compared in detail, as on a drive."""


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """Node j of the second map was taken where node i of the first was: `i_from_j` with covariance (3, 3), and the
    alignment's cost and its share of the best rival's.
    """

    i: int
    j: int
    relative: Pose2
    covariance: FloatArray
    cost: float
    ratio: float


class CrossClaims:
    """Looks for each view of one map in another."""

    def __init__(self, aligner: Aligner, appearance: AppearanceSettings, offset: RelativePoseSettings) -> None:
        self._appearance = AppearanceTest(appearance, aligner)
        self._offset = RelativePoseEstimator(offset)

    def between(self, first: TopoMap, second: TopoMap, told: Callable[[float], None]) -> list[Seen]:
        """Return where views of the second map win clearly among all places of the first; told: the share done."""
        index, nodes = PlaceIndex(), _with_view(first)
        here, there = ViewCache(first), ViewCache(second)
        for node in nodes:
            index.add(signature(here.panorama(node)))
        found = []
        asked = _with_view(second)
        for k, node in enumerate(asked):
            told(k / len(asked))
            places, differences = index.search(signature(there.panorama(node)), SHORTLIST)
            rows = zip(places.tolist(), differences.difference.tolist(), differences.rotation.tolist(), strict=True)
            matches = [PlaceMatch(nodes[place], difference, rotation) for place, difference, rotation in rows]
            seen = self._judge(first, here, there, node, matches)
            if seen is not None:
                found.append(seen)
        return found

    def _judge(
        self, first: TopoMap, here: ViewCache, there: ViewCache, node: int, matches: list[PlaceMatch]
    ) -> Seen | None:
        if not matches:
            return None
        view = there.panorama(node)
        outcome = self._appearance.judge(view, matches, (), here.panorama, first.length)
        if outcome.objection:
            return None
        match = outcome.winner.match.node
        offset = self._offset.measure(outcome.winner, here.panorama(match), view)
        cost = outcome.winner.alignment.residual
        return Seen(match, node, offset.relative, offset.covariance, cost, outcome.ratio)


def _with_view(topo: TopoMap) -> list[int]:
    return [node for node in topo.chain if topo.nodes[node].snapshot is not None]
