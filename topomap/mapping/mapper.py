"""The mapping wing's one entrance: each reading updates the map."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydantic import BaseModel, Field

from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import Candidate, Decision, MapChange, MountLean, NodeAdded, PlaceMatch
from topomap.core.robot import Reading
from topomap.mapping.closures.closure_tests import ClosureTest
from topomap.mapping.closures.ledger import Ledger
from topomap.mapping.closures.online import Closing, ClosingSettings
from topomap.mapping.closures.robot_tests import RobotTests
from topomap.mapping.graph import TopoMap
from topomap.mapping.odometry.watch import OdometryWatch
from topomap.mapping.optimisation import Optimisation
from topomap.mapping.places.drive_views import DriveViews
from topomap.mapping.places.recognition import Recognition, RecognitionSettings
from topomap.mapping.places.snapshots import SnapshotSettings, View, make_rule
from topomap.mapping.sessions.drive_start import DriveStart
from topomap.mapping.solve_due import OptimisationSettings
from topomap.mapping.track import Track
from topomap.mapping.turned_end import turned_end
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
        tests: Sequence[ClosureTest] | RobotTests = (),
        resumed: DriveStart | None = None,
    ) -> None:
        """tests: of closures, a user's own, asked before odometry is; resumed: a map to go on with, and where."""
        self.map = resumed.map if resumed else TopoMap()
        if self.map.view == "full":
            self.map.view = settings.snapshots.view
        self._views = DriveViews(self.map)
        self.view_cache = self._views.cache
        self.ledger = Ledger()
        self.track = Track(self.map)
        self.optimisation = Optimisation(settings.optimisation, aligner, self.map)
        self._settings = settings.snapshots
        self._rule = make_rule(settings.snapshots)
        self.recognition = Recognition(settings.recognition)
        self._closing = Closing(
            settings.closing, aligner, self.track, self.view_cache, self.ledger, self.optimisation, tests,
            self.recognition.catchment, self.recognition.contrast,
        )  # fmt: skip
        self._watch = OdometryWatch()
        self._previous: Panorama | None = None
        self._last_snapshot = -1
        self._kept_at = 0.0
        self._stamp_ns = 0
        self._gap: int | None = None  # the node behind a gap in the odometry, while nobody knows where it lies
        self._before_gap = 0
        self.lost = False  # whoever localises says so: nothing is claimed to be seen again by one who is lost
        self.explores = False  # the robot shows itself the way: snapshots are kept though nobody drives it
        self.first: int | None = None  # the node that this drive began with
        self._resumed = resumed
        if resumed:
            self._recall()

    def _recall(self) -> None:
        """Make what the loaded map holds findable and believed."""
        self.optimisation.resume()
        for node in self.map.chain:
            if self.map.nodes[node].snapshot is not None:
                self.recognition.recall(node, self.map.nodes[node].travel, self.view_cache.panorama(node))

    def seen(self, panorama: Panorama, turn: float) -> Panorama:
        """Return a view as the map keeps views, upright and whole: what place search, compass and homing compare.

        turn: since the last one, by the odometry [rad]. To be asked once for each reading, before `update`.
        """
        seen = self._views.see(panorama, turn)
        if self._views.restated:
            self._restate()
        return seen

    @property
    def mount(self) -> MountLean | None:
        """How the camera leans, None where too few views have shown it."""
        return self._views.mount

    @property
    def restated_camera(self) -> str:
        """What was newly found of the camera by the last view, in plain words, "" for nothing."""
        return self._views.said

    def _restate(self) -> None:
        """Take what was seen in this drive for what it is, now that the camera is known better."""
        for node, view in self._views.restate():
            self.recognition.restate(node, view)
        if self._previous is not None:
            self._previous = self._views.before()
            self._watch.restate(self._previous)

    def update(self, reading: Reading, panorama: Panorama) -> MapChange:
        """Take one reading: extend the track, keep or not, search, test closures, solve; return what changed.

        panorama: its view as `seen` returns it.
        """
        if not (self._resumed and self.first is None):
            self.track.check(reading.stamp_ns, reading.motion)
        broken = self._watch.judge(panorama, reading.motion, self.map.calibration) if self.map.nodes else ""
        self._stamp_ns = reading.stamp_ns
        self._move(reading, bool(broken) or self._watch.doubted)
        if broken:
            self._part()
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
            self._watch.said,
        )

    @property
    def _believes(self) -> bool:
        """Whether the robot knows where it is, so that it can claim to see places again."""
        return not self.lost and self._gap is None

    @property
    def doubted(self) -> bool:
        """Whether wheels and views contradict one another now."""
        return self._watch.doubted

    @property
    def handled(self) -> bool:
        """Whether the view turned in this step as no wheel did: somebody turned the robot, or more."""
        return self._watch.turned

    @property
    def catchment(self) -> float:
        """The way over which views are alike here [m], 0 while it isn't known."""
        return self.recognition.catchment.length

    @property
    def located(self) -> int:
        """How many snapshots, of the first ones, lie where the map has them: those before a gap that is open."""
        return len(self.recognition) if self._gap is None else self._before_gap

    @property
    def left_behind(self) -> int:
        """How many snapshots, of the first ones, were left far enough back on the way to be seen again."""
        return len(self.recognition.old_nodes(self.track.travel))

    def relocate(self, pose: Pose2, since: int | None = None) -> None:
        """Let the robot be at `pose` in the map frame: what lies behind an open gap is moved there, else a gap opens.

        since: the last node known to lie right; what was claimed to be seen again behind it is taken back. Whoever
        calls is sure; the map keeps it as a gap, over which closures then have to agree.
        """
        gap = self._gap if self._gap is not None else self._after(since)
        if gap == self.map.chain[0]:
            return
        behind = self.map.chain[self.map.chain.index(gap) :]
        self._closing.withdraw(self._stamp_ns, set(behind))
        self.optimisation.abandon()  # it would put back what is moved here
        self.map.place(gap, pose @ self.track.pose.to(self.map.pose(gap)))
        self.track.restart()
        self._closing.forget(self._stamp_ns)
        self._gap = None

    def _move(self, reading: Reading, broken: bool) -> None:
        """Extend the track; the first reading on a loaded map begins another drive."""
        if self._resumed and self.first is None:
            start = self._resumed
            self.track.begin_drive(reading.stamp_ns, start.pose, start.covariance, self.recognition.far)
        else:
            self.track.advance(reading.stamp_ns, reading.motion, broken, self._watch.seen)

    def _after(self, since: int | None) -> int:
        """Return the node behind `since` on the chain; where there is none, one that is made here."""
        chain = self.map.chain
        if since is None or since == chain[-1]:
            return self.track.node_at(self._stamp_ns)
        return chain[chain.index(since) + 1]

    def testify(self, candidate: Candidate, agrees: bool, reason: str) -> None:
        """Take what an active check saw of a pending closure; its verdict comes with the next step."""
        self._closing.testify(candidate, agrees, reason)

    def finish(self, stamp_ns: int) -> None:
        """End the map at the last reading, so that every step lies on it; judge what the last views showed, and correct
        the map a last time.
        """
        self.track.node_at(stamp_ns)
        while self._believes and (proposal := self.recognition.proposal(ended=True)) is not None:
            self._closing.judge(stamp_ns, proposal)
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

    def _part(self) -> None:
        """Begin anew behind a gap: what comes isn't compared with what was before it."""
        self._previous, self._last_snapshot = None, -1
        if self._gap is None:
            self._before_gap = len(self.recognition)
        self._closing.forget(self._stamp_ns)

    def _keep(self, reading: Reading, panorama: Panorama, difference: float, broken: str) -> tuple[NodeAdded, ...]:
        """Store a snapshot where the rule asks for one while being taught; on a journey, now and then a pose node."""
        shown = reading.driven or self.explores
        reason = broken or self._reason(panorama, difference, shown)
        if not reason:
            return ()
        self._kept_at = self.track.travel
        taught = shown or not self.map.nodes
        snapshot = self._views.snapshot(reading, panorama) if taught else None
        node = self.track.node_at(reading.stamp_ns, snapshot)
        if self.first is None:
            self.first = node
            if self._resumed and self._resumed.anywhere:
                self._gap, self._before_gap = node, len(self.recognition)
        if broken:
            self._gap = node
        if snapshot is not None:
            self._views.keep(node, snapshot, reading, panorama)
            self._turn(node)
            self._learn_contrast(panorama)
            self.recognition.add(node, self.track.travel, panorama)
        return (NodeAdded(node, reading.stamp_ns, self.map.pose(node), taught, reason),)

    def _reason(self, panorama: Panorama, difference: float, driven: bool) -> str | None:
        if self._previous is None:
            return "start"
        travelled = self.track.travel - self._kept_at
        if not driven:
            return "on the way" if travelled >= self._settings.max_travel else None
        to_previous = rotation_difference(signature(panorama), signature(self._previous))[0]
        return self._rule.judge(View(difference, to_previous, travelled))

    def _learn_contrast(self, panorama: Panorama) -> None:
        """Learn how clearly one of other places can win, from those that odometry excludes, while it is known."""
        nodes = self.recognition.nodes()
        if self.lost or self._gap is not None or not len(nodes):
            return
        apart = self._closing.apart
        far = np.ones(len(self.map.nodes), bool)
        far[self._closing.within_reach(nodes)] = False
        away = np.hypot(*(self.map.poses[nodes, :2] - self.track.pose.array()[:2]).T)
        elsewhere = nodes[far[nodes] & (away > apart)]
        self.recognition.learn_contrast(panorama, elsewhere, self.map.poses[elsewhere, :2], apart)

    def _turn(self, node: int) -> None:
        """Let a new snapshot lie where its turn from the one before says, as it is measured."""
        before, self._last_snapshot = self._last_snapshot, node
        if before < 0:
            return
        # what isn't kept of a view helps while it is at hand
        turn = self.optimisation.sequential.compare(before, node, self._views.whole)
        if turn is not None:
            self.map.shift(*turned_end(self.map, turn, self.optimisation.covariance))
            self.track.restart()

    def _recognise(self, stamp_ns: int, panorama: Panorama) -> tuple[PlaceMatch | None, tuple[Decision, ...]]:
        """Look among the older places and judge what is proposed."""
        travel = self.track.travel
        reachable = self._closing.within_reach(self.recognition.old_nodes(travel))
        place = self.recognition.update(stamp_ns, travel, panorama, reachable)
        if not self._believes:
            self.recognition.pass_over()
            return place, self._closing.judge(stamp_ns, None)
        proposal = self.recognition.proposal()
        if proposal is None:
            self._closing.prepare(self.recognition.imminent(), self.recognition.awaited())
        return place, self._closing.judge(stamp_ns, proposal)

    def _correct(self, stamp_ns: int) -> tuple[bool, list[Decision]]:
        solved, reviewed = self.optimisation.update(stamp_ns, self.ledger)
        if solved:
            self.track.restart()
        return solved, reviewed
