"""The topics of a log and the record that each carries."""

from __future__ import annotations

from logs import records

PANORAMA = "/panorama"
RANGES = "/ranges"
POINTS = "/ranges/points"
ODOMETRY = "/odometry"
TRUTH = "/truth"
TRUE_POSE = "/pose/true"
ESTIMATED_POSE = "/pose/estimated"
DEAD_RECKONING_POSE = "/pose/dead_reckoning"
TRANSFORMS = "/tf"
BELIEF = "/belief"
DIFFERENCE = "/image_difference"
HOME_VECTOR = "/home_vector"
COMMAND = "/command"
MISSION = "/mission"
NODE = "/map/node_added"
NODES = "/map/nodes"
GRAPH = "/map/graph"
CLOSURES = "/closures"
CALIBRATION = "/calibration"
TIMINGS = "/timings"
TEXT = "/log"
FINAL = "/final"
PERFORMANCE = "/performance"

TOPICS: dict[str, type] = {
    PANORAMA: records.Image,
    RANGES: records.Scan,
    POINTS: records.Points,
    ODOMETRY: records.Odometry,
    TRUTH: records.Truth,
    TRUE_POSE: records.FramedPose,
    ESTIMATED_POSE: records.FramedPose,
    DEAD_RECKONING_POSE: records.FramedPose,
    TRANSFORMS: records.Transforms,
    BELIEF: records.Belief,
    DIFFERENCE: records.ImageDifference,
    HOME_VECTOR: records.HomeVector,
    COMMAND: records.Command,
    MISSION: records.Mission,
    NODE: records.Node,
    NODES: records.NodePoses,
    GRAPH: records.Graph,
    CLOSURES: records.Closure,
    CALIBRATION: records.Calibration,
    TIMINGS: records.Timings,
    TEXT: records.Text,
    FINAL: records.Final,
    PERFORMANCE: records.Performance,
}
