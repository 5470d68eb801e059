"""A saved map that a run goes on with: where the robot is put on it, and where its nodes truly are."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from logs.errors import LogError
from logs.replay import ReplayRobot
from topomap.core.errors import DataError
from topomap.core.geometry import Pose2
from topomap.core.run_data import RunData
from topomap.evaluation.summary import write_whole
from topomap.evaluation.trajectory import true_pose
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapfile import from_bytes, load_map, to_bytes
from topomap.mapping.sessions.drive_start import DriveStart
from topomap.mapping.sessions.places import find
from topomap.navigation.localiser import ANYWHERE, Start
from topomap.navigation.mission import MissionSettings, goals_of
from topomap.navigation.wish import Kind
from topomap.recording.true_nodes import ATTACHMENT, Truths, parse_truths, read_truths, truth_file, truths_text

UNKNOWN = "unknown"
MAP = "start.topomap"
"""A log's attachment: the map that its run began with."""


@dataclass(frozen=True)
class SavedMap:
    """A map to go on with, where the robot is put on it, and where its nodes truly are, as far as that is known."""

    map: TopoMap
    start: Start
    truths: Truths = field(default_factory=dict)

    @staticmethod
    def open(path: Path, mission: MissionSettings) -> SavedMap:
        """Return the map of a file for a mission. Raises DataError, and TopomapError for goals that it hasn't."""
        return _checked(load_map(path), mission, read_truths(truth_file(path)))

    @staticmethod
    def of(content: bytes, mission: MissionSettings, truths: bytes | None) -> SavedMap:
        """Return the map that a log's run began with. Raises DataError."""
        topo = from_bytes(content)
        known = parse_truths(truths.decode(), ATTACHMENT) if truths else {}
        return _checked(topo, mission, {topo.names[node]: pose for node, pose in known.items()})

    @property
    def drive_start(self) -> DriveStart:
        """The map as the mapper takes it."""
        if self.start.unknown:
            return DriveStart.somewhere(self.map)
        pose = self.start.pose or (Pose2() if self.start.node is None else self.map.pose(self.start.node))
        return DriveStart.at(self.map, pose)

    def attachments(self) -> Iterable[tuple[str, str, bytes]]:
        """Yield name, type and content of what a log keeps of it."""
        yield MAP, "application/zip", to_bytes(self.map)
        if self.truths:
            known = {node: self.truths[name] for node, name in enumerate(self.map.names) if name in self.truths}
            yield ATTACHMENT, "text/csv", truths_text(known).encode()


def _checked(topo: TopoMap, mission: MissionSettings, truths: Truths) -> SavedMap:
    """Refuse goals that the map hasn't before anything moves."""
    if mission.wish.kind is not Kind.TEACH:
        goals_of(mission.wish, topo)
    start = ANYWHERE if mission.start == UNKNOWN else Start(node=find(topo, mission.start))
    return SavedMap(topo, start, truths)


def begun_with(robot: ReplayRobot, mission: MissionSettings) -> SavedMap | None:
    """Return the map that a log's run went on with, if it did. Raises DataError."""
    try:
        begun = robot.attachment(MAP)
        return SavedMap.of(begun, mission, robot.attachment(ATTACHMENT)) if begun else None
    except LogError as error:
        raise DataError(str(error)) from error


def write_truths(run: RunData, topo: TopoMap, saved: SavedMap | None, map_file: Path) -> None:
    """Write the true poses of a run's nodes beside its map, where they are known: for metrics of later runs on it."""
    if run.truth is None:
        return
    own = dict(saved.truths) if saved else {}
    for node in run.nodes:
        pose = true_pose(run, node.stamp_ns)
        if np.isfinite(pose).all():
            x, y, heading = pose.tolist()
            own[topo.names[node.node]] = x, y, heading
    if own:
        write_whole(truth_file(map_file), truths_text(own))
