"""The mapping wing's one entrance: each reading updates the map."""

from __future__ import annotations

from collections.abc import Sequence

from pydantic import BaseModel, Field

from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.recorded import RecordedRig
from topomap.core.records import Candidate, Decision, MapChange, NodeAdded, PlaceMatch
from topomap.core.robot import Reading
from topomap.mapping.closures.closure_tests import ClosureTest
from topomap.mapping.closures.ledger import Ledger
from topomap.mapping.closures.online import Closing, ClosingSettings
from topomap.mapping.graph import Snapshot, TopoMap
from topomap.mapping.odometry.watch import OdometryWatch
from topomap.mapping.optimisation import Optimisation, OptimisationSettings
from topomap.mapping.places.recognition import Recognition, RecognitionSettings
from topomap.mapping.places.snapshots import SnapshotSettings, View, make_rule
from topomap.mapping.places.view_cache import ViewCache
from topomap.mapping.track import Track
from topomap.vision.choice import AlignerChoice
from topomap.vision.contracts import Aligner
from topomap.vision.image.compare import rotation_difference, signature


class MapperSettings(BaseModel, frozen=True, extra="forbid"):
    """All settings of the mapping wing."""

    aligner: AlignerChoice = Field("min-warping", description="the compass that closures are measured by")
    snapshots: SnapshotSettings = Field(default_factory=SnapshotSettings)
    recognition: RecognitionSettings = Field(default_factory=RecognitionSettings)
    closing: ClosingSettings = Field(default_factory=ClosingSettings)
    optimisation: OptimisationSettings = Field(default_factory=OptimisationSettings)


class Mapper:
    """Surveys the route, keeps snapshots, recognises places, closes loops and applies solutions."""

    def __init__(self, settings: MapperSettings, aligner: Aligner, tests: Sequence[ClosureTest] = ()) -> None:
        """tests: of closures, a user's own, asked before odometry is."""
        self.map = TopoMap()
        self.view_cache = ViewCache(self.map)
        self.ledger = Ledger()
        self.track = Track(self.map)
        self.optimisation = Optimisation(settings.optimisation, aligner, self.map)
        self._settings = settings.snapshots
        self._rule = make_rule(settings.snapshots)
        self.recognition = Recognition(settings.recognition)
        self._closing = Closing(
            settings.closing, aligner, self.track, self.view_cache, self.ledger, self.optimisation, tests
        )
        self._watch = OdometryWatch()
        self._previous: Panorama | None = None
        self._last_snapshot = -1
        self._kept_at = 0.0
        self._stamp_ns = 0
        self._gap: int | None = None  # the node behind a gap in the odometry, while nobody knows where it lies
        self._before_gap = 0
        self.lost = False  # whoever localises says so: nothing is claimed to be seen again by one who is lost

    def update(self, reading: Reading, panorama: Panorama) -> MapChange:
        """Take one reading: extend the track, keep or not, search, test closures, solve; return what changed."""
        broken = self._watch.judge(panorama, reading.motion) if self.map.nodes else ""
        self._stamp_ns = reading.stamp_ns
        self.track.advance(reading.stamp_ns, reading.motion, bool(broken) or self._watch.doubted)
        if broken:
            self._part(broken)
        difference = self._difference(panorama)
        added = self._keep(reading, panorama, difference, broken)
        place, decisions = self._recognise(reading.stamp_ns, panorama)
        solved, reviewed = self._correct(reading.stamp_ns)
        self._previous = panorama
        return MapChange(
            self.track.pose,
            difference,
            self._settings.threshold,
            place,
            added,
            (*decisions, *reviewed),
            solved,
            self.optimisation.state if solved else None,
            broken,
        )

    @property
    def located(self) -> int:
        """How many snapshots, of the first ones, lie where the map has them: those before a gap that is open."""
        return len(self.recognition) if self._gap is None else self._before_gap

    def relocate(self, pose: Pose2) -> None:
        """Let the robot be at `pose` in the map frame: what lies behind an open gap is moved there, else a gap opens.

        Whoever calls is sure; the map keeps it as a gap, over which closures then have to agree.
        """
        gap = self.track.node_at(self._stamp_ns) if self._gap is None else self._gap
        if gap == self.map.chain[0]:
            return
        there = self.track.pose.to(self.map.pose(gap))
        self.map.place(gap, pose @ there)
        self.track.restart()
        self._closing.forget(self._stamp_ns)
        self._gap = None

    def testify(self, candidate: Candidate, agrees: bool, reason: str) -> None:
        """Take what an active check saw of a pending closure; its verdict comes with the next step."""
        self._closing.testify(candidate, agrees, reason)

    def finish(self, stamp_ns: int) -> None:
        """End the map at the last reading, so that every step lies on it, and correct it a last time."""
        self.track.node_at(stamp_ns)
        self.optimisation.finish(stamp_ns, self.ledger)

    def graph_hash(self) -> str:
        """Return the hash over nodes, edges, verdicts and poses."""
        verdicts = [(d.candidate.query_ns, d.candidate.match, d.verdict.value, d.reason) for d in self.ledger.decisions]
        return self.map.hash(verdicts)

    def topology_hash(self) -> str:
        """Return the hash over nodes, edges and verdicts alone, which no machine's rounding changes."""
        verdicts = [(d.candidate.query_ns, d.candidate.match, d.verdict.value) for d in self.ledger.decisions]
        return self.map.topology_hash(verdicts)

    def _difference(self, panorama: Panorama) -> float:
        if self._last_snapshot < 0:
            return float("nan")
        last = self.view_cache.panorama(self._last_snapshot)
        return rotation_difference(signature(panorama), signature(last))[0]

    def _part(self, reason: str) -> None:
        """Begin anew behind a gap: what comes isn't compared with what was before it."""
        self._previous, self._last_snapshot = None, -1
        if self._gap is None:
            self._before_gap = len(self.recognition)
        self._closing.forget(self._stamp_ns)

    def _keep(self, reading: Reading, panorama: Panorama, difference: float, broken: str) -> tuple[NodeAdded, ...]:
        """Store a snapshot where the rule asks for one while being taught; on a journey, now and then a pose node."""
        reason = broken or self._reason(panorama, difference, reading.driven)
        if not reason:
            return ()
        self._kept_at = self.track.travel
        taught = reading.driven or not self.map.nodes
        snapshot = Snapshot(reading.encoded, reading.ranges, RecordedRig.of(reading.rig)) if taught else None
        node = self.track.node_at(reading.stamp_ns, snapshot)
        if broken:
            self._gap = node
        if taught:
            self._remember(node, panorama)
        return (NodeAdded(node, reading.stamp_ns, self.map.pose(node), taught, reason),)

    def _reason(self, panorama: Panorama, difference: float, driven: bool) -> str | None:
        if self._previous is None:
            return "start"
        travelled = self.track.travel - self._kept_at
        if not driven:
            return "on the way" if travelled >= self._settings.max_travel else None
        to_previous = rotation_difference(signature(panorama), signature(self._previous))[0]
        return self._rule.judge(View(difference, to_previous, travelled))

    def _remember(self, node: int, panorama: Panorama) -> None:
        self.view_cache.put(node, panorama)
        self.recognition.add(node, self.track.travel, panorama)
        if self._last_snapshot >= 0:
            self.optimisation.sequential.compare(self._last_snapshot, node, self.view_cache)
        self._last_snapshot = node

    def _recognise(self, stamp_ns: int, panorama: Panorama) -> tuple[PlaceMatch | None, tuple[Decision, ...]]:
        """Look among the older places and judge what is proposed."""
        travel = self.track.travel
        reachable = self._closing.within_reach(self.recognition.old_nodes(travel))
        place = self.recognition.update(stamp_ns, travel, panorama, reachable)
        if self.lost or self._gap is not None:
            return place, self._closing.judge(stamp_ns, None)
        return place, self._closing.judge(stamp_ns, self.recognition.proposal())

    def _correct(self, stamp_ns: int) -> tuple[bool, list[Decision]]:
        solved, reviewed = self.optimisation.update(stamp_ns, self.ledger)
        if solved:
            self.track.restart()
        return solved, reviewed
