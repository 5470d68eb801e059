"""The mapping wing's one entrance: each reading updates the map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pydantic import BaseModel, Field

from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.recorded import RecordedRig
from topomap.core.records import Candidate, Decision, MapChange, NodeAdded, PlaceMatch, Verdict
from topomap.core.robot import Reading
from topomap.core.view_size import parse_view
from topomap.mapping.closures.closure_tests import ClosureTest
from topomap.mapping.closures.ledger import Ledger
from topomap.mapping.closures.online import Closing, ClosingSettings
from topomap.mapping.graph import Snapshot, TopoMap
from topomap.mapping.optimisation import Optimisation, OptimisationSettings
from topomap.mapping.places.recognition import Recognition, RecognitionSettings
from topomap.mapping.places.small_view import small_view, snapshot_of
from topomap.mapping.places.snapshots import SnapshotSettings, View, make_rule
from topomap.mapping.places.view_cache import ViewCache
from topomap.mapping.sessions.drive_start import DriveStart
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

    def __init__(
        self,
        settings: MapperSettings,
        aligner: Aligner,
        tests: Sequence[ClosureTest] = (),
        resumed: DriveStart | None = None,
    ) -> None:
        """tests: of closures, a user's own, asked before odometry is; resumed: a map to go on with, and where."""
        self.map = resumed.map if resumed else TopoMap()
        if self.map.view == "full":
            self.map.view = settings.snapshots.view
        self._size = parse_view(self.map.view)
        self.view_cache = ViewCache(self.map)
        self.ledger = Ledger()
        self.track = Track(self.map)
        self.optimisation = Optimisation(settings.optimisation, aligner, self.map)
        self._settings = settings.snapshots
        self._rule = make_rule(settings.snapshots)
        self._recognition = Recognition(settings.recognition)
        self._closing = Closing(
            settings.closing, aligner, self.track, self.view_cache, self.ledger, self.optimisation, tests
        )
        self._previous: Panorama | None = None
        self._last_snapshot = -1
        self._kept_at = 0.0
        self._resumed = resumed
        self.first = 0
        self.explores = False  # the robot shows itself the way: snapshots are kept though nobody drives it
        if resumed:
            self._recall()

    def _recall(self) -> None:
        """Make what the loaded map holds findable and believed."""
        self.optimisation.resume()
        for node in self.map.chain:
            if self.map.nodes[node].snapshot is not None:
                self._recognition.recall(node, self.map.nodes[node].travel, self.view_cache.panorama(node))

    def seen(self, panorama: Panorama) -> Panorama:
        """Return a view as the map keeps views: what place search, compass and homing compare."""
        return panorama if self._size is None else small_view(panorama, self._size)

    def update(self, reading: Reading, panorama: Panorama) -> MapChange:
        """Take one reading: extend the track, keep or not, search, test closures, solve; return what changed.

        panorama: its view as `seen` returns it.
        """
        self._move(reading)
        difference = self._difference(panorama)
        added = self._keep(reading, panorama, difference)
        place, decisions = self._recognise(reading.stamp_ns, panorama)
        self._join(decisions)
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
        )

    def _move(self, reading: Reading) -> None:
        """Extend the track; the first reading on a loaded map begins another drive."""
        if self._resumed and self._previous is None:
            start = self._resumed
            self.track.begin_drive(reading.stamp_ns, start.pose, start.covariance, self._recognition.far)
        else:
            self.track.advance(reading.stamp_ns, reading.motion)

    def testify(self, candidate: Candidate, agrees: bool, reason: str) -> None:
        """Take what an active check saw of a pending closure; its verdict comes with the next step."""
        self._closing.testify(candidate, agrees, reason)

    def finish(self, stamp_ns: int) -> None:
        """End the map at the last reading, so that every step lies on it, and correct it a last time."""
        self.track.node_at(stamp_ns)
        self.optimisation.solve(stamp_ns, self.ledger)

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

    def _keep(self, reading: Reading, panorama: Panorama, difference: float) -> tuple[NodeAdded, ...]:
        """Store a snapshot where the rule asks for one while being taught; on a journey, now and then a pose node."""
        shown = reading.driven or self.explores
        reason = self._reason(panorama, difference, shown)
        if not reason:
            return ()
        self._kept_at = self.track.travel
        taught = shown or not self.map.nodes
        snapshot = self._snapshot(reading, panorama) if taught else None
        node = self.track.node_at(reading.stamp_ns, snapshot)
        if self._previous is None:
            self.first = node
        if taught:
            self._remember(node, panorama)
        return (NodeAdded(node, reading.stamp_ns, self.map.pose(node), taught, reason),)

    def _snapshot(self, reading: Reading, panorama: Panorama) -> Snapshot:
        if self._size is not None and reading.rig.width > self._size.columns:
            return snapshot_of(panorama)
        return Snapshot(reading.encoded, reading.ranges, RecordedRig.of(reading.rig))

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
        self._recognition.add(node, self.track.travel, panorama)
        if self._last_snapshot >= 0:
            self.optimisation.sequential.compare(self._last_snapshot, node, self.view_cache)
        self._last_snapshot = node

    def _recognise(self, stamp_ns: int, panorama: Panorama) -> tuple[PlaceMatch | None, tuple[Decision, ...]]:
        """Look among the older places and judge what is proposed."""
        travel = self.track.travel
        reachable = self._closing.within_reach(self._recognition.old_nodes(travel))
        place = self._recognition.update(stamp_ns, travel, panorama, reachable)
        return place, self._closing.judge(stamp_ns, self._recognition.proposal())

    def _join(self, decisions: tuple[Decision, ...]) -> None:
        """Hang a drive that could begin anywhere where its first closures say."""
        if not self._resumed or not self._resumed.anywhere:
            return
        for decision in decisions:
            closure = decision.candidate
            if decision.verdict is Verdict.ACCEPTED and closure.query is not None and closure.match < self.first:
                there = self.map.pose(closure.match) @ closure.relative
                self.hang(there @ self.map.pose(closure.query).inverse() @ self.map.pose(self.first))
                return

    def hang(self, pose: Pose2) -> None:
        """Let this drive have begun at a pose, and be no longer one that could begin anywhere; needs a loaded map."""
        assert self._resumed
        self._resumed = replace(self._resumed, anywhere=False)
        self.map.hang(self.first, pose)
        self.track.restart()

    def _correct(self, stamp_ns: int) -> tuple[bool, list[Decision]]:
        solved, reviewed = self.optimisation.update(stamp_ns, self.ledger)
        if solved:
            self.track.restart()
        return solved, reviewed
