"""The recorder of a run: every step and the finished map as records of the log."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from logs import records as log
from logs import topics
from logs.recorder import Recorder
from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import Pose2
from topomap.core.records import CalibrationState, Decision, MapChange, MountLean, StepRecord, Travel, Verdict
from topomap.core.robot import Reading, Truth, TruthSource
from topomap.core.run_data import Trust
from topomap.recording import encode


@dataclass(frozen=True)
class MapNow:
    """The map as it stands: nodes (id, pose, snapshot), edges (a, b, kind) with kind "odometry" or "closure"."""

    nodes: tuple[tuple[int, Pose2, bool], ...] = ()
    edges: tuple[tuple[int, int, str], ...] = ()


@dataclass(frozen=True)
class FinalMap:
    """The finished map for the log, N steps.

    stamps_ns (N,); poses (N, 3) the trajectory in the map frame; nodes (id, stamp [ns], pose, snapshot); edges
    (a, b, kind); claimed: the robot said it arrived, None when it wasn't sent anywhere; decisions: the verdicts that
    the last solve, after the last step, changed; trust: what the map makes of its evidence;
    mount: how the camera leans, None where too little was seen;
    fault: what ended the run before its time.
    """

    stamps_ns: IntArray
    poses: FloatArray
    nodes: tuple[tuple[int, int, Pose2, bool], ...]
    edges: tuple[tuple[int, int, str], ...]
    calibration: CalibrationState | None
    graph_hash: str
    steps_per_s: float | None = None
    claimed: bool | None = None
    goal_node: int | None = None
    decisions: tuple[Decision, ...] = ()
    trust: Trust = field(default_factory=Trust)
    mount: MountLean | None = None
    topology_hash: str = ""
    fault: str = ""


class RunRecorder:
    """Writes every step of a run into a log.

    now: returns the map as it is now; truth: asked at each step whose truth isn't given.
    """

    def __init__(self, recorder: Recorder, now: Callable[[], MapNow], truth: TruthSource | None = None) -> None:
        self._recorder = recorder
        self._source = truth
        self._now = now
        self._said: tuple[str, str, bool] = ("", "", False)
        self._calibration: CalibrationState | None = None
        self._start: log.Pose | None = None
        self._map_stale = False
        self._map_age = self._map_size = 0
        self._stamp = 0
        self._sensed: Reading | None = None

    def sensed(self, reading: Reading, truth: Truth | None = None) -> None:
        """Write one reading, before the stack takes it: whatever it leads to, it is on record.

        Raises LogError when the log can't be written, or the reading can't be logged.
        """
        stamp_ns = int(reading.stamp_ns)
        self._recorder.check(stamp_ns)
        self._stamp, self._sensed = stamp_ns, reading
        self._write_reading(reading, truth or (self._source.truth() if self._source else None))

    def observe(self, reading: Reading, record: StepRecord, truth: Truth | None = None) -> None:
        """Write one step, and its reading if that wasn't written; raises LogError when the log can't be written."""
        if self._sensed is not reading:
            self.sensed(reading, truth)
        self._write_poses(record)
        self._write_change(record.change, record.travel)
        self._write_mission(record)
        self._write_timings(record.timings)
        self._write_text(reading, record)
        self._write_map(record.change)

    def say(self, name: str, message: str, error: bool = False) -> None:
        """Write a line for people; raises LogError when the log can't be written."""
        self._say(log.Level.ERROR if error else log.Level.WARNING, name, message)

    def finish(self, final: FinalMap) -> None:
        """Write the finished map and its trajectory; raises LogError when the log can't be written."""
        self._write_decisions(final.decisions)
        # the last solve moved every node: what viewers show last is the finished map
        self._send_map(MapNow(tuple((id, pose, snapshot) for id, _, pose, snapshot in final.nodes), final.edges))
        self._write(topics.FINAL, _final(final))
        if final.steps_per_s is not None:
            self._write(topics.PERFORMANCE, log.Performance(float(final.steps_per_s)))

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        """Attach a file, such as the finished map; raises LogError when the log can't be written."""
        self._recorder.attach(name, media_type, data)

    def close(self) -> None:
        """Close the log; does nothing the second time."""
        self._recorder.close()

    def _write(self, topic: str, record: object) -> None:
        self._recorder.write(self._stamp, topic, record)

    def _write_reading(self, reading: Reading, truth: Truth | None) -> None:
        self._write(topics.PANORAMA, log.Image(reading.encoded))
        if reading.ranges is not None:
            self._write(topics.RANGES, log.Scan(reading.ranges))
            self._write(topics.POINTS, encode.points(reading))
        if truth is not None:
            pose = log.Pose(float(truth.x), float(truth.y), float(truth.heading))
            stored = log.Truth(truth.stamp_ns, pose.x, pose.y, pose.heading, bool(truth.contact))
            self._write(topics.TRUTH, stored)
            self._write(topics.TRUE_POSE, log.FramedPose("world", pose))
            self._start = self._start or pose
        self._write(topics.ODOMETRY, encode.odometry(reading))

    def _write_poses(self, record: StepRecord) -> None:
        where, odom = record.where, record.dead_reckoning
        map_from_odom = where.pose @ odom.inverse()
        pose, dead = encode.pose(where.pose), encode.pose(odom)
        frames: tuple[log.Transform, ...] = (
            log.Transform("map", "odom", encode.pose(map_from_odom)),
            log.Transform("odom", "base_link", dead),
        )
        if self._start is not None:
            # the map frame starts at the first pose: so viewers can lay the truth over the map
            frames = (log.Transform("world", "map", self._start), *frames)
        self._write(topics.ESTIMATED_POSE, log.FramedPose("map", pose))
        self._write(topics.DEAD_RECKONING_POSE, log.FramedPose("map", dead))
        self._write(topics.TRANSFORMS, log.Transforms(frames))
        self._write(topics.BELIEF, log.Belief(dead, pose, where.node, float(where.difference), float(where.lost)))

    def _write_change(self, change: MapChange, travel: Travel) -> None:
        self._write(topics.DIFFERENCE, encode.difference(change, travel))
        for node in change.added:
            self._write(topics.NODE, encode.node(node))
        self._write_decisions(change.decisions)
        if change.calibration not in (None, self._calibration):
            self._calibration = change.calibration
            self._write(topics.CALIBRATION, encode.calibration(change.calibration))

    def _write_decisions(self, decisions: tuple[Decision, ...]) -> None:
        for decision in decisions:
            self._write(topics.CLOSURES, encode.closure(decision))
            self._say(encode.level(decision.verdict), "closure", encode.sentence(decision))

    def _write_mission(self, record: StepRecord) -> None:
        goal, travel, command = record.goal, record.travel, record.command
        mission = log.Mission(
            goal.phase.value, goal.node, travel.phase.value, travel.milestone, travel.legs_left, travel.note
        )
        self._write(topics.MISSION, mission)
        self._write(topics.COMMAND, log.Command(float(command.forward), float(command.turn)))
        if travel.home is not None:
            self._write(topics.HOME_VECTOR, encode.home_vector(travel))

    def _write_timings(self, timings: Mapping[str, float]) -> None:
        if timings:
            self._write(topics.TIMINGS, log.Timings(encode.scores(timings)))

    def _write_text(self, reading: Reading, record: StepRecord) -> None:
        for node in record.change.added:
            self._say(log.Level.INFO, "map", f"node {node.node}: {node.reason}")
        for text in dict.fromkeys((record.change.broken, record.change.mended, record.where.event)):
            if text:
                self._say(log.Level.WARNING, "odometry", text)
        phase, note, contact = self._said
        travel = record.travel
        if travel.phase.value != phase:
            self._say(log.Level.INFO, "travel", f"{phase or 'start'} -> {travel.phase.value}")
        if travel.note and travel.note != note:
            self._say(log.Level.INFO, "travel", travel.note)
        if reading.contact and not contact:
            self._say(log.Level.WARNING, "robot", "contact")
        self._said = travel.phase.value, travel.note, reading.contact

    def _say(self, level: log.Level, name: str, message: str) -> None:
        self._write(topics.TEXT, log.Text(level, name, message))

    def _write_map(self, change: MapChange) -> None:
        closed = any(d.verdict in (Verdict.ACCEPTED, Verdict.WITHDRAWN) for d in change.decisions)
        self._map_stale = self._map_stale or closed or change.solved or bool(change.added)
        self._map_age += 1
        # a map of thousands of nodes at every change would outgrow the panoramas
        if self._map_stale and self._map_age >= self._map_size // 10:
            self._send_map(self._now())

    def _send_map(self, now: MapNow) -> None:
        poses = np.array([pose.array() for _, pose, _ in now.nodes], dtype=np.float64).reshape(-1, 3)
        snapshots = np.array([snapshot for _, _, snapshot in now.nodes], dtype=np.bool_)
        self._write(topics.NODES, log.NodePoses(poses))
        self._write(topics.GRAPH, log.Graph(poses, snapshots, _rows(now, "odometry"), _rows(now, "closure")))
        self._map_stale, self._map_age, self._map_size = False, 0, len(now.nodes)


def _rows(now: MapNow, kind: str) -> IntArray:
    """Return (M, 2) the rows of the nodes that edges of a kind join."""
    place = {id: row for row, (id, _, _) in enumerate(now.nodes)}
    pairs = [(place[a], place[b]) for a, b, own in now.edges if own == kind]
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def _final(final: FinalMap) -> log.Final:
    stamps: list[int] = np.asarray(final.stamps_ns).tolist()
    mount = final.mount
    return log.Final(
        stamps_ns=tuple(stamps),
        poses=encode.row(final.poses),
        nodes=tuple(encode.final_node(*node) for node in final.nodes),
        edges=tuple(log.Edge(int(a), int(b), kind) for a, b, kind in final.edges),
        calibration=None if final.calibration is None else encode.calibration(final.calibration),
        graph_hash=final.graph_hash,
        claimed=final.claimed,
        goal_node=final.goal_node,
        kept=final.trust.kept or None,
        way_noise=final.trust.way_noise,
        turn_noise=final.trust.turn_noise,
        roll=None if mount is None else float(mount.roll),
        pitch=None if mount is None else float(mount.pitch),
        lean_sigma=None if mount is None else float(mount.sigma),
        sway=None if mount is None else float(mount.sway),
        taken_out=None if mount is None else bool(mount.taken_out),
        topology_hash=final.topology_hash,
        fault=final.fault or None,
    )
