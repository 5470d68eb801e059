"""Place search: which older places look like the current view, and when one looked most alike."""

from __future__ import annotations

from array import array
from bisect import bisect_left, bisect_right
from collections import deque
from dataclasses import dataclass, field
from statistics import median

import numpy as np
from pydantic import BaseModel, Field

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.panorama import Panorama
from topomap.core.records import PlaceMatch
from topomap.mapping.places.catchment import Catchment, steps_back
from topomap.mapping.places.contrast import Contrast
from topomap.mapping.places.place_index import PlaceIndex
from topomap.vision.image.compare import RotationDifferences, Signature, signature

MEMORY = 300
"""Steps over which the usual difference is taken: 30 m at 0.1 m a step, so that it follows
from a room into a corridor and isn't one view's."""
LAG, LONGEST, LEAST = 2, 12, 0.1
"""Steps to either side over which the difference has its minimum: as many as make 0.1 m at least, of which a robot of
0.1 m a step takes two (the difference rises by 0.3 or more over them in all worlds looked at)."""
SHORTLIST = 8
"""Most similar nodes that are compared in detail, by min-warping: each costs a step as much time again."""
COMPARED = 400
"""Nodes within reach that are compared; of more, the most similar, so that no step grows with the map."""
PAUSE = 0.3
"""[m] Way between proposals: closer ones see the same pair of nodes."""

FAR = 2.5
"""A place left so many catchments ago is another one: by then the view differs from it as from any (at 2 to 3 in grass,
photographs and rooms)."""

AS_LONG_AGO = 0.5
"""A rival was left at least so much of the way ago as the place it is held against. What was seen lately was seen from
as far beside the way and in the same light: 0.3 m beside the first lap of `office-loop`, by camera alone, doors 9 to 15
m behind cost 0.35 to align with and the place itself, of the lap before, 0.55."""

THRESHOLD = 0.95
"""Nothing is proposed above this share of the median difference to other places: true revisits differ by 0.1 to 0.7 of
that in the middle, by world, first visits by 0.9 and more where places differ at all (bench looks' worlds)."""


class RecognitionSettings(BaseModel, frozen=True, extra="forbid"):
    """When a place is proposed as seen before."""

    min_travel: float = Field(8.0, gt=0, description="way since a node before it can be seen again [m]")


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """One step as place search saw it: stamp, raw odometer way [m] and view.

    places: the older ones within reach, likely: the most similar of all older ones, both best first.
    """

    stamp_ns: int
    travel: float
    panorama: Panorama
    places: tuple[PlaceMatch, ...]
    likely: tuple[PlaceMatch, ...]
    difference: dict[int, float]


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """A moment at which the best place within reach looked most alike.

    places: the likeliest ones within reach; rivals: the likeliest ones anywhere that were left as long ago; limit: the
    image difference above which nothing would have been proposed; older: differences to all places left as long ago, or
    to many of them, by node.
    """

    moment: Moment
    places: tuple[PlaceMatch, ...]
    rivals: tuple[PlaceMatch, ...]
    limit: float
    older: dict[int, float] = field(default_factory=dict)


class Recognition:
    """Compares every view with the older snapshots at all rotations, and proposes at local minima.

    index: the views of all snapshots so far; catchment: how fast views change along the drive;
    contrast: how clearly one of other places wins.
    """

    def __init__(self, settings: RecognitionSettings) -> None:
        self._s = settings
        self.index = PlaceIndex()
        self.catchment = Catchment()
        self.contrast = Contrast()
        self._nodes = array("q")
        self._travel: list[float] = []
        self._recent: deque[Moment] = deque(maxlen=2 * LONGEST + 1)
        self._count = self._examined = 0  # moments
        self._usual: deque[float] = deque(maxlen=MEMORY)
        self._last_proposal = -np.inf

    def __len__(self) -> int:
        """Return the number of snapshots."""
        return len(self._nodes)

    def add(self, node: int, travel: float, panorama: Panorama) -> None:
        """Make a snapshot node findable; `travel` is the raw odometer way at it [m]."""
        view = signature(panorama)
        self._learn_change(view, travel, steps_back(travel - self._travel[0]) if self._travel else [])
        self.index.add(view)
        self._nodes.append(node)
        self._travel.append(travel)

    def restate(self, node: int, panorama: Panorama) -> None:
        """Take a snapshot's view for another one: what was found by the earlier one isn't examined any more."""
        self.index.replace(self._nodes.index(node), signature(panorama))
        self.pass_over()

    def recall(self, node: int, travel: float, panorama: Panorama) -> None:
        """Make a node of a loaded map findable, and learn from it how different other places look."""
        self._learn(signature(panorama), travel)
        self.add(node, travel, panorama)

    def learn_contrast(self, panorama: Panorama, elsewhere: IntArray, positions: FloatArray, apart: float) -> None:
        """Learn from a view and nodes (n,) at positions (n, 2) [m] where it surely wasn't taken."""
        some = slice(None, None, max(1, -(-len(elsewhere) // COMPARED)))
        places = np.searchsorted(np.array(self._nodes), elsewhere[some])
        differences = self.index.compare(signature(panorama), places).difference
        self.contrast.learn(differences, positions[some], apart)

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
        if self._travel:
            self._learn_change(view, travel, [travel - self._travel[-1]])
        matches, likely = self._search(view, travel, reachable)
        differences = {match.node: match.difference for match in matches}
        self._count += 1
        self._recent.append(Moment(stamp_ns, travel, panorama, matches, likely, differences))
        return likely[0] if likely else None

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

    def _rivals(self, moment: Moment) -> tuple[PlaceMatch, ...]:
        """Return the likeliest places anywhere, of those that were left as long ago as the moment's best place."""
        count = self._as_long_ago(moment)
        if all(match.node <= self._nodes[count - 1] for match in moment.likely):
            return moment.likely
        return self._matches(*self.index.search(signature(moment.panorama), SHORTLIST, count))

    def _as_long_ago(self, moment: Moment) -> int:
        """Return how many places, of the first ones, were left about as long ago as the best within reach, one at
        least.
        """
        left = self._travel[bisect_left(self._nodes, moment.places[0].node)]
        longest = moment.travel - AS_LONG_AGO * (moment.travel - left)
        return min(self._old(moment.travel), bisect_right(self._travel, longest))

    @property
    def far(self) -> float:
        """The way after which a place can be seen again [m]: longer where the view changes slowly."""
        return max(self._s.min_travel, FAR * self.catchment.length)

    @property
    def limit(self) -> float:
        """The image difference above which nothing is proposed: a share of that to other places; 0 at first."""
        return THRESHOLD * median(self._usual) if self._usual else 0.0

    def _learn(self, view: Signature, travel: float) -> None:
        """Learn how different other places look, from nodes that were left too recently to be seen again."""
        first, last = self._old(travel), self._old(travel + self.far / 2)
        if last > first:
            differences = self.index.compare(view, np.arange(first, last)).difference
            self._usual.append(float(np.median(differences)))

    def _learn_change(self, view: Signature, travel: float, back: list[float]) -> None:
        """Learn how unlike the snapshots are that were taken some ways back [m]."""
        places = sorted({bisect_right(self._travel, travel - way + 1e-9) - 1 for way in back} - {-1})
        for place, difference in zip(places, self.index.compare(view, np.array(places, int)).difference, strict=True):
            self.catchment.learn(travel - self._travel[place], float(difference))

    def _matches(self, places: IntArray, found: RotationDifferences) -> tuple[PlaceMatch, ...]:
        return tuple(
            PlaceMatch(self._nodes[places[i]], float(found.difference[i]), float(found.rotation[i]))
            for i in np.argsort(found.difference, kind="stable").tolist()
        )

    def pass_over(self) -> None:
        """Leave all moments so far unexamined for good: the robot didn't know where it was."""
        self._examined = self._count

    def proposal(self, ended: bool = False) -> Proposal | None:
        """Return a moment some steps ago if the view was then most like a place within reach, once a pass.

        ended: no step comes after the last one, so that the last moments are told by what was before them.
        """
        while (place := self._next_known(ended)) is not None:
            self._examined += 1
            if self._is_proposed(place):
                moment = self._recent[place]
                self._last_proposal = moment.travel
                return Proposal(
                    moment, moment.places[:SHORTLIST], self._rivals(moment), self.limit, self._older(moment)
                )
        return None

    def imminent(self) -> Moment | None:
        """Return the moment that is proposed next unless a view comes that is more like its place; None for none."""
        place = len(self._recent) - (self._count - self._examined)
        after = len(self._recent) - 1 - place
        return self._recent[place] if after >= LAG - 1 and self._is_proposed(place) else None

    def awaited(self) -> list[int]:
        """Return the nodes that a proposal of the last moment would name, the likeliest first; none if it can't be."""
        last = self._recent[-1] if self._recent else None
        if last is None or not last.places or last.places[0].difference > self.limit:
            return []
        return [match.node for match in (*last.places[:SHORTLIST], *last.likely)]

    def _next_known(self, ended: bool) -> int | None:
        """Return where in `_recent` the first moment stands that wasn't examined, None until enough came after it."""
        place = len(self._recent) - (self._count - self._examined)
        after = len(self._recent) - 1 - place
        if ended:
            return place if after >= 0 else None
        if after < LAG:
            return None
        gone = self._recent[-1].travel - self._recent[place].travel
        return place if gone >= LEAST or after >= LONGEST else None

    def _is_proposed(self, place: int) -> bool:
        moment = self._recent[place]
        if not moment.places or moment.travel - self._last_proposal < PAUSE:
            return False
        best = moment.places[0]
        return best.difference <= self.limit and self._is_minimum(best.node, place)

    def _is_minimum(self, node: int, place: int) -> bool:
        """Return whether a node was the most alike at a moment, of all moments that came since and as many before."""
        first = place - min(LAG, place)
        while first > 0 and place - first < LONGEST and self._travelled(first, place) < LEAST:
            first -= 1
        curve = [moment.difference.get(node, np.inf) for moment in list(self._recent)[first:]]
        return int(np.argmin(curve)) == place - first

    def _travelled(self, first: int, last: int) -> float:
        return self._recent[last].travel - self._recent[first].travel

    def _older(self, moment: Moment) -> dict[int, float]:
        """Return the differences of a moment's view to older places, by node: to all, or to so many evenly."""
        old = self._as_long_ago(moment)
        places = np.arange(0, old, max(1, -(-old // COMPARED)))
        found = self.index.compare(signature(moment.panorama), places).difference
        return dict(zip(np.array(self._nodes)[places].tolist(), found.tolist(), strict=True)) | moment.difference

    def _old(self, travel: float) -> int:
        # the snapshots are in travel order: a head of them is old enough
        return bisect_right(self._travel, travel - self.far)
