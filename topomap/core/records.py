"""The records that flow between the stages, and the conventions they all keep.

Metres, radians; stamps are integer nanoseconds (a fixed epoch plus run time, never the wall clock).
x forward, y left, counter-clockwise, angles in (-pi, pi]. A *bearing* is in the robot frame, a *heading*
in the map frame; the map frame starts at the first pose. Transforms are named `a_from_b`.

The odometry's systematic errors are what the odometer does to the truth:
`forward_read = distance_scale * forward`, `turn_read = rotation_scale * turn + curvature * forward`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from topomap.core.arrays import FloatArray
from topomap.core.evidence import Evidence
from topomap.core.geometry import Pose2

UNKNOWN_HEADING = 1.0
"""A heading variance above this [rad^2] says that the heading isn't known (a uniform one has 3.3)."""


@dataclass(frozen=True, slots=True)
class Motion:
    """One odometry increment in the robot frame.

    forward [m], left [m], turn [rad], covariance (3, 3) of these three, dt [s].
    """

    forward: float
    left: float
    turn: float
    covariance: FloatArray
    dt: float


@dataclass(frozen=True, slots=True)
class Command:
    """What the wheels shall do until the next command: forward [m/s], turn [rad/s]."""

    forward: float = 0.0
    turn: float = 0.0


@dataclass(frozen=True, slots=True)
class HomeVector:
    """Where the goal lies, seen from the current robot.

    bearing [rad] in the current robot's frame; distance [m] or None where the method gives a bearing only;
    confidence in [0, 1], 0 means no answer.
    """

    bearing: float
    distance: float | None = None
    confidence: float = 1.0


@dataclass(frozen=True, slots=True)
class Alignment:
    """How the current view is turned against the goal view.

    rotation [rad]: heading of the current robot minus heading of the goal (rolling the current panorama by
    +rotation aligns it); residual: what difference remains, smaller is better, scale is the method's own;
    home: the home vector where the method finds one as well; sharp: False where the best rotation lies at the edge of
    what was searched, or others are as good: then it may be far off.
    """

    rotation: float
    residual: float
    home: HomeVector | None = None
    sharp: bool = True


class Verdict(StrEnum):
    """What became of a closure candidate."""

    ACCEPTED = "accepted"
    REFUSED = "refused"
    PENDING = "pending"
    WITHDRAWN = "withdrawn"


@dataclass(frozen=True, slots=True)
class Candidate:
    """A proposal that the robot at `query_ns` stood where node `match` was taken.

    match: node id; query: node id once the query has a node, else None; relative: `match_from_query` [m, rad];
    covariance (3, 3) of relative (a heading variance above UNKNOWN_HEADING: unknown); similarity in [0, 1];
    evidence: what each test measured.
    """

    query_ns: int
    match: int
    match_ns: int
    relative: Pose2
    covariance: FloatArray
    similarity: float = 1.0
    query: int | None = None
    evidence: Evidence = field(default_factory=Evidence)


@dataclass(frozen=True, slots=True)
class Decision:
    """A verdict on a candidate at `stamp_ns`, with the reason in plain words."""

    stamp_ns: int
    candidate: Candidate
    verdict: Verdict
    reason: str


@dataclass(frozen=True, slots=True)
class Estimate:
    """A calibration value with its standard deviation; observed is False while the data doesn't show it."""

    value: float
    sigma: float
    observed: bool


@dataclass(frozen=True, slots=True)
class CalibrationState:
    """The odometry's systematic errors as estimated now (conventions: this module's docstring)."""

    rotation_scale: Estimate
    distance_scale: Estimate
    curvature: Estimate


@dataclass(frozen=True, slots=True)
class MountLean:
    """How the camera's mount leans, by what stands upright in its views.

    roll: to the right, pitch: forward [rad]; sigma: of both [rad]; sway: how far the body leans besides, from step to
    step [rad], 0 where it doesn't; taken_out: whether views are taken upright before anything else uses them.
    """

    roll: float
    pitch: float
    sigma: float
    sway: float = 0.0
    taken_out: bool = False


@dataclass(frozen=True, slots=True)
class PlaceMatch:
    """The most similar node: node id, difference (0 same, about 1.4 unrelated) and rotation [rad] as in Alignment."""

    node: int
    difference: float
    rotation: float


@dataclass(frozen=True, slots=True)
class NodeAdded:
    """A node that was added this step; snapshot is False for a bare pose node (at a closure)."""

    node: int
    stamp_ns: int
    pose: Pose2
    snapshot: bool
    reason: str


@dataclass(frozen=True, slots=True)
class MapChange:
    """What one step did to the map.

    difference: image difference to the last snapshot (NaN before the first); place: best match among the nodes
    outside the recent past; solved: whether the back end moved the poses; broken: why the odometry of this step isn't
    believed, in plain words ("" where it is); mended: what was taken instead of a step's odometry, and why ("" for
    nothing).
    """

    pose: Pose2
    difference: float
    threshold: float
    place: PlaceMatch | None = None
    added: tuple[NodeAdded, ...] = ()
    decisions: tuple[Decision, ...] = ()
    solved: bool = False
    calibration: CalibrationState | None = None
    broken: str = ""
    mended: str = ""


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A place where the robot may be: the nearest snapshot node, the pose in the map frame, its probability."""

    node: int
    pose: Pose2
    weight: float


@dataclass(frozen=True, slots=True)
class Where:
    """Where the robot believes it is.

    pose, node: the likeliest pose and the snapshot node nearest to it (None: the map holds none); difference: of the
    view to that node's, or to the last snapshot's where it wasn't compared; lost: the probability in [0, 1] that the
    robot is not at `pose`; rivals: the other places where it may be, the likeliest first; event: what was noticed in
    this step, in plain words ("" for nothing).
    """

    pose: Pose2
    node: int | None
    difference: float
    lost: float
    rivals: tuple[Hypothesis, ...] = ()
    event: str = ""


class Phase(StrEnum):
    """What the mission is doing."""

    TEACH = "teach"
    TRAVEL = "travel"
    ARRIVED = "arrived"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class Goal:
    """The mission's wish: the node to reach (None while teaching) and the phase."""

    phase: Phase
    node: int | None = None


@dataclass(frozen=True, slots=True)
class Travel:
    """What the traveller did: milestone node, its home vector and image difference, legs left, a note on events."""

    phase: Phase
    milestone: int | None = None
    home: HomeVector | None = None
    difference: float = float("nan")
    legs_left: int = 0
    note: str = ""


@dataclass(frozen=True, slots=True)
class StepRecord:
    """All that one step saw and decided, for the log.

    dead_reckoning: raw odometry integrated, uncorrected; timings: milliseconds by stage, never hashed.
    """

    stamp_ns: int
    dead_reckoning: Pose2
    change: MapChange
    where: Where
    goal: Goal
    travel: Travel
    command: Command
    timings: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Plan:
    """A world's plan in the truth's frame [m]: polylines (N, 2), circles (x, y, r), labels (x, y, text)."""

    polylines: tuple[FloatArray, ...] = ()
    circles: tuple[tuple[float, float, float], ...] = ()
    labels: tuple[tuple[float, float, str], ...] = ()
