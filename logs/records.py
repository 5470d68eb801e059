"""The records of a log. Metres, radians, integer nanoseconds; frames are named where they differ.

The records from `Odometry` on are stored as protobuf `topomap.<name>`, field numbers in the order given here:
append new fields at the end so that older logs still read. The first group is stored as Foxglove schemas.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

NAN = float("nan")


@dataclass(frozen=True, slots=True)
class Pose:
    """A pose of one frame in another: x, y [m], heading [rad, counter-clockwise]."""

    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0


# Stored as Foxglove schemas, for any viewer.


@dataclass(frozen=True, slots=True)
class Image:
    """An encoded image, JPEG or PNG, as the camera gave it."""

    encoded: bytes


@dataclass(frozen=True, slots=True)
class Scan:
    """Ranges (W,) float32 [m], entry j along 2 pi j/W from the nose, counter-clockwise; NaN: not measured."""

    ranges: NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Points:
    """Points (N, 2) float32 [m] in the robot's frame."""

    points: NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class FramedPose:
    """A pose in a named frame."""

    frame: str
    pose: Pose


@dataclass(frozen=True, slots=True)
class Transform:
    """`parent_from_child`."""

    parent: str
    child: str
    pose: Pose


@dataclass(frozen=True, slots=True)
class Transforms:
    """The frames' tree at one stamp."""

    transforms: tuple[Transform, ...]


@dataclass(frozen=True, slots=True)
class NodePoses:
    """The map's nodes (in the order of their ids), poses (N, 3) in the map frame."""

    poses: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Graph:
    """The map to look at: poses (N, 3) in the map frame, snapshots (N,), links and closures (M, 2) rows."""

    poses: NDArray[np.float64]
    snapshots: NDArray[np.bool_]
    links: NDArray[np.int64]
    closures: NDArray[np.int64]


class Level(IntEnum):
    """The levels of a text message, numbered as Foxglove does."""

    DEBUG = 1
    INFO = 2
    WARNING = 3
    ERROR = 4


@dataclass(frozen=True, slots=True)
class Text:
    """A line for people, from a named part of the program."""

    level: Level
    name: str
    message: str


# Stored as protobuf topomap.*.


@dataclass(frozen=True, slots=True)
class Odometry:
    """The increment since the previous reading, covariance (3, 3) row by row, dt [s]; closes a reading.

    scanned: the reading had ranges (they stand on their own topic).
    """

    forward: float
    left: float
    turn: float
    covariance: tuple[float, ...]
    dt: float
    contact: bool
    driven: bool
    scanned: bool


@dataclass(frozen=True, slots=True)
class Truth:
    """The true pose in the world's frame at a stamp, and whether the body touches something."""

    stamp_ns: int
    x: float
    y: float
    heading: float
    contact: bool


@dataclass(frozen=True, slots=True)
class Belief:
    """Where the robot believed it was: by raw odometry, on the map, at which node; lost: a probability."""

    dead_reckoning: Pose
    pose: Pose
    node: int | None
    difference: float
    lost: float


@dataclass(frozen=True, slots=True)
class ImageDifference:
    """Image differences: to the last snapshot, to the best older node, to the milestone."""

    snapshot: float
    threshold: float
    place: float = NAN
    place_node: int | None = None
    place_rotation: float = NAN
    homing: float = NAN


@dataclass(frozen=True, slots=True)
class HomeVector:
    """Where the milestone lies: bearing [rad] in the robot's frame, distance [m], confidence in [0, 1]."""

    milestone: int | None
    bearing: float
    distance: float | None
    confidence: float


@dataclass(frozen=True, slots=True)
class Command:
    """What the wheels were told: forward [m/s], turn [rad/s]."""

    forward: float
    turn: float


@dataclass(frozen=True, slots=True)
class Mission:
    """What was wanted and what the traveller did about it."""

    phase: str
    goal: int | None
    travel: str
    milestone: int | None
    legs_left: int
    note: str


@dataclass(frozen=True, slots=True)
class Node:
    """A node that was added, its pose in the map frame then."""

    node: int
    stamp_ns: int
    pose: Pose
    snapshot: bool
    reason: str


@dataclass(frozen=True, slots=True)
class Score:
    """What one test measured."""

    name: str
    value: float


@dataclass(frozen=True, slots=True)
class Closure:
    """A verdict on a closure candidate: relative is `match_from_query`, covariance its (3, 3) row by row."""

    stamp_ns: int
    verdict: str
    reason: str
    query_ns: int
    query: int | None
    match: int
    match_ns: int
    relative: Pose
    covariance: tuple[float, ...]
    similarity: float
    scores: tuple[Score, ...]


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value with its standard deviation; observed is False while the data doesn't show it."""

    value: float
    sigma: float
    observed: bool


@dataclass(frozen=True, slots=True)
class Calibration:
    """The odometry's systematic errors as believed."""

    rotation_scale: Estimate
    distance_scale: Estimate
    curvature: Estimate


@dataclass(frozen=True, slots=True)
class Timings:
    """Milliseconds by stage; the only records, with `Performance`, that differ between two equal runs."""

    stages: tuple[Score, ...]


@dataclass(frozen=True, slots=True)
class Performance:
    """How fast the run went."""

    steps_per_s: float


@dataclass(frozen=True, slots=True)
class Edge:
    """An edge of the finished map between two node ids."""

    a: int
    b: int
    kind: str


@dataclass(frozen=True, slots=True)
class Final:
    """The finished map: trajectory (N stamps, N * 3 values row by row, map frame), nodes, edges, identity.

    kept: which of several maps this is, and why; way_noise, turn_noise: what the odometry's declared variances were
    taken times, None where nothing told; roll, pitch, lean_sigma, sway: how the camera's mount leans to the right and
    forward, the error of both, and the body's sway besides [rad], taken_out: whether views were taken upright, all None
    where too little was seen;
    fault: what ended the run before its time, None where nothing did.
    """

    stamps_ns: tuple[int, ...]
    poses: tuple[float, ...]
    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...]
    calibration: Calibration | None
    graph_hash: str
    claimed: bool | None
    goal_node: int | None
    topology_hash: str | None = None
    fault: str | None = None
    kept: str | None = None
    way_noise: float | None = None
    turn_noise: float | None = None
    roll: float | None = None
    pitch: float | None = None
    lean_sigma: float | None = None
    sway: float | None = None
    taken_out: bool | None = None
