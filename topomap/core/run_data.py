"""A run as arrays: what the summary, the figures and the report are made of, whatever log or data set it came from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from topomap.core.arrays import BoolArray, FloatArray, Image, IntArray
from topomap.core.records import CalibrationState, Decision, MountLean, Plan


@dataclass(frozen=True)
class TrueCalibration:
    """The odometer's true systematic errors (None: not known), in the convention of `topomap.core.records`."""

    rotation_scale: float | None = None
    distance_scale: float | None = None
    curvature: float | None = None


@dataclass(frozen=True)
class Trust:
    """What a map makes of its evidence.

    kept: which of several maps it is, and why, in words ("" where none was chosen); way_noise, turn_noise: what the
    odometry's declared variances were taken times (None: nothing told).
    """

    kept: str = ""
    way_noise: float | None = None
    turn_noise: float | None = None


@dataclass(frozen=True)
class NodeData:
    """A node of the final map: pose (3,) in the map frame; image (H, W, 3) RGB with the nose in the centre column
    (as recorded), or None for a pose node or where images weren't kept."""

    node: int
    stamp_ns: int
    pose: FloatArray
    snapshot: bool
    image: Image | None = None


@dataclass(frozen=True)
class Leg:
    """One goal that the robot was sent to: its node, the first and the last step [index] with it, whether the robot
    then said that it arrived (None: the log ends before), and the milestones on the way, in their order."""

    goal: int
    first: int
    last: int
    claimed: bool | None
    milestones: tuple[int, ...] = ()


@dataclass(frozen=True)
class RunData:
    """One run, N steps; poses (N, 3) are x, y [m], heading [rad], each in its own frame.

    truth: (N, 3), heading NaN where the data set has none, or None where nothing is known; dead_reckoning: raw
    odometry integrated; online: the estimate at the step; final: the finished map's trajectory at the same
    stamps; driven (N,): a driver had the wheels; contact (N,); difference (N,): to the last snapshot; place_difference
    (N,): to the best older node, NaN where there was none; homing_difference (N,): to the milestone;
    threshold: for a new snapshot; decisions: every verdict in time order (a candidate may get several);
    first_closure: panoramas (as recorded) some steps before and at the first accepted closure, and of its match;
    stage_ms: milliseconds (N,) by stage of the step, NaN where none was logged;
    trust: what the finished map makes of its evidence; mount: how the camera leans, None where too little was seen;
    earlier: true poses (3,) of nodes that the run's map had before it, by stamp;
    milestones: the node ids of the planned route home; claimed: the robot said that it arrived; goal_node: where it was
    sent last; legs: one for each goal, in their order; fault: what ended the run before its time; log_state, log_note:
    whether all that was written of it was there to be read ("whole"), and what was not.
    """

    world: str
    seed: int | None
    config: Mapping[str, object]
    versions: Mapping[str, str]
    stamps_ns: IntArray
    dead_reckoning: FloatArray
    online: FloatArray
    final: FloatArray
    truth: FloatArray | None = None
    plan: Plan = field(default_factory=Plan)
    driven: BoolArray | None = None
    contact: BoolArray | None = None
    difference: FloatArray | None = None
    place_difference: FloatArray | None = None
    homing_difference: FloatArray | None = None
    threshold: float | None = None
    nodes: tuple[NodeData, ...] = ()
    edges: tuple[tuple[int, int, str], ...] = ()
    decisions: tuple[Decision, ...] = ()
    calibration: CalibrationState | None = None
    true_calibration: TrueCalibration = field(default_factory=TrueCalibration)
    first_closure: tuple[tuple[str, Image], ...] = ()
    goal_node: int | None = None
    claimed: bool | None = None
    milestones: tuple[int, ...] = ()
    legs: tuple[Leg, ...] = ()
    replayed: bool = False
    graph_hash: str = ""
    trust: Trust = field(default_factory=Trust)
    mount: MountLean | None = None
    topology_hash: str = ""
    fault: str = ""
    log_state: str = "whole"
    log_note: str = ""
    steps_per_s: float | None = None
    stage_ms: Mapping[str, FloatArray] = field(default_factory=dict)
    earlier: Mapping[int, FloatArray] = field(default_factory=dict)
    false_distance_m: float = 1.0
    gross_distance_m: float = 5.0
