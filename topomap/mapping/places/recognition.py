"""Place search: which older places look like the current view, and when one looked most alike."""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections import deque
from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from topomap.core.arrays import IntArray
from topomap.core.panorama import Panorama
from topomap.core.records import PlaceMatch
from topomap.mapping.places.place_index import PlaceIndex
from topomap.vision.image.compare import RotationDifferences, Signature, signature

MEMORY = 300
"""Steps over which the usual difference is taken: 30 m at 0.1 m a step, so that it follows
from a room into a corridor and isn't one view's."""
LAG = 2
"""Steps to either side over which the difference has its minimum: 0.4 m in all, over which the difference
rises by 0.3 or more in all worlds looked at."""
SHORTLIST = 8
"""Most similar nodes that are compared in detail, by min-warping: each costs a step as much time again."""
COMPARED = 400
"""Nodes within reach that are compared; of more, the most similar, so that no step grows with the map."""
PAUSE = 0.3
"""[m] Way between proposals: closer ones see the same pair of nodes."""

THRESHOLD = 0.95
"""Nothing is proposed above this share of the median difference to other places: true revisits differ by 0.1 to 0.7 of
that in the middle, by world, first visits by 0.9 and more where places differ at all (bench looks' worlds)."""


class RecognitionSettings(BaseModel, frozen=True, extra="forbid"):
    """When a place is proposed as seen before."""

    min_travel: float = Field(8.0, gt=0, description="way since a node before it can be seen again [m]")


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """One step as place search saw it: stamp, raw odometer way [m] and view.

    places: the older ones within reach, rivals: the most similar of all older ones, both best first.
    """

    stamp_ns: int
    travel: float
    panorama: Panorama
    places: tuple[PlaceMatch, ...]
    rivals: tuple[PlaceMatch, ...]
    difference: dict[int, float]


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """A moment at which the best place within reach looked most alike.

    places: the likeliest ones within reach; rivals: the likeliest ones anywhere; limit: the image difference above
    which nothing would have been proposed.
    """

    moment: Moment
    places: tuple[PlaceMatch, ...]
    rivals: tuple[PlaceMatch, ...]
    limit: float


class Recognition:
    """Compares every view with the older snapshots at all rotations, and proposes at local minima.

    index: the views of all snapshots so far.
    """

    def __init__(self, settings: RecognitionSettings) -> None:
        self._s = settings
        self.index = PlaceIndex()
        self._nodes = array("q")
        self._travel: list[float] = []
        self._recent: deque[Moment] = deque(maxlen=2 * LAG + 1)
        self._usual: deque[float] = deque(maxlen=MEMORY)
        self._last_proposal = -np.inf

    def __len__(self) -> int:
        """Return the number of snapshots."""
        return len(self._nodes)

    def add(self, node: int, travel: float, panorama: Panorama) -> None:
        """Make a snapshot node findable; `travel` is the raw odometer way at it [m]."""
        self.index.add(signature(panorama))
        self._nodes.append(node)
        self._travel.append(travel)

    def recall(self, node: int, travel: float, panorama: Panorama) -> None:
        """Make a node of a loaded map findable, and learn from it how different other places look."""
        self._learn(signature(panorama), travel)
        self.add(node, travel, panorama)

    def old_nodes(self, travel: float) -> IntArray:
        """Return the snapshot nodes that lie far enough back on the way to be seen again."""
        return np.array(self._nodes[: self._old(travel)])

    def nodes(self) -> IntArray:
        """Return all snapshot nodes, in the order of `index`."""
        return np.array(self._nodes)

    def update(self, stamp_ns: int, travel: float, panorama: Panorama, reachable: IntArray) -> PlaceMatch | None:
        """Take this step's view and the nodes at which odometry allows it to be taken.

        Returns the older node most like the view, wherever it lies; None where there is none.
        """
        view = signature(panorama)
        self._learn(view, travel)
        matches, rivals = self._search(view, travel, reachable)
        differences = {match.node: match.difference for match in matches}
        self._recent.append(Moment(stamp_ns, travel, panorama, matches, rivals, differences))
        return rivals[0] if rivals else None

    def _search(
        self, view: Signature, travel: float, reachable: IntArray
    ) -> tuple[tuple[PlaceMatch, ...], tuple[PlaceMatch, ...]]:
        """Return the reachable places, of too many those that look most alike, and the likeliest ones anywhere."""
        old = self._old(travel)
        if len(reachable) > COMPARED:
            likely = self._matches(*self.index.search(view, COMPARED, old))
            within = set(reachable.tolist())
            return tuple(match for match in likely if match.node in within), likely[:SHORTLIST]
        places = np.searchsorted(np.array(self._nodes), reachable)
        rivals = self._matches(*self.index.search(view, SHORTLIST, old))
        return self._matches(places, self.index.compare(view, places)), rivals

    @property
    def far(self) -> float:
        """The way after which a place can be seen again [m]."""
        return self._s.min_travel

    @property
    def limit(self) -> float:
        """The image difference above which nothing is proposed: a share of that to other places; 0 at first."""
        return THRESHOLD * float(np.median(self._usual)) if self._usual else 0.0

    def _learn(self, view: Signature, travel: float) -> None:
        """Learn how different other places look, from nodes that were left too recently to be seen again."""
        first, last = self._old(travel), self._old(travel + self._s.min_travel / 2)
        if last > first:
            differences = self.index.compare(view, np.arange(first, last)).difference
            self._usual.append(float(np.median(differences)))

    def _matches(self, places: IntArray, found: RotationDifferences) -> tuple[PlaceMatch, ...]:
        return tuple(
            PlaceMatch(self._nodes[places[i]], float(found.difference[i]), float(found.rotation[i]))
            for i in np.argsort(found.difference, kind="stable").tolist()
        )

    def proposal(self) -> Proposal | None:
        """Return the moment `lag` steps ago if the view was then most like a place within reach, once a pass."""
        if len(self._recent) < 2 * LAG + 1:
            return None
        moment = self._recent[LAG]
        if not moment.places or moment.travel - self._last_proposal < PAUSE:
            return None
        best = moment.places[0]
        if best.difference > self.limit or not self._is_minimum(best.node):
            return None
        self._last_proposal = moment.travel
        return Proposal(moment, moment.places[:SHORTLIST], moment.rivals, self.limit)

    def _is_minimum(self, node: int) -> bool:
        curve = [moment.difference.get(node, np.inf) for moment in self._recent]
        return int(np.argmin(curve)) == LAG

    def _old(self, travel: float) -> int:
        # the snapshots are in travel order: a head of them is old enough
        return bisect_right(self._travel, travel - self._s.min_travel)
