"""Records that viewers know, as Foxglove protobuf messages (https://docs.foxglove.dev/docs/sdk/schemas)."""

from __future__ import annotations

import math
from functools import singledispatch
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.Point3_pb2 import Point3
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from foxglove_schemas_protobuf.Pose_pb2 import Pose as PoseMessage
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.SpherePrimitive_pb2 import SpherePrimitive
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.message import DecodeError, Message
from google.protobuf.timestamp_pb2 import Timestamp
from numpy.typing import NDArray

from logs import records
from logs.errors import LogError

CAMERA, BODY, MAP = "camera", "base_link", "map"
MESSAGES: dict[type, type[Message]] = {
    records.Image: CompressedImage,
    records.Scan: LaserScan,
    records.Points: PointCloud,
    records.FramedPose: PoseInFrame,
    records.Transforms: FrameTransforms,
    records.NodePoses: PosesInFrame,
    records.Graph: SceneUpdate,
    records.Text: Log,
}


def encode(record: object, stamp_ns: int) -> bytes:
    """Return the Foxglove message of a record; raises LogError for an image that is neither JPEG nor PNG."""
    data: bytes = _message(record, _stamp(stamp_ns)).SerializeToString(deterministic=True)
    return data


def image_format(encoded: bytes) -> str:
    """Return "jpeg" or "png", the exact words viewers accept; raises LogError for anything else."""
    for name, magic in (("jpeg", b"\xff\xd8\xff"), ("png", b"\x89PNG\r\n\x1a\n")):
        if encoded.startswith(magic):
            return name
    raise LogError("an image to be logged is neither JPEG nor PNG")


def decode_image(data: bytes) -> bytes:
    """Return the encoded image of a CompressedImage message; raises LogError when it isn't one."""
    return bytes(_parsed(CompressedImage, data).data)


def decode_scan(data: bytes) -> NDArray[np.float32]:
    """Return the ranges (W,) float32 [m] of a LaserScan message; raises LogError when it isn't one."""
    # the message holds doubles; every float32 comes back from one unchanged
    return np.array(_parsed(LaserScan, data).ranges, dtype=np.float64).astype(np.float32)


def decode_text(data: bytes) -> records.Text:
    """Return the text of a Log message; raises LogError when it isn't one."""
    log = _parsed(Log, data)
    return records.Text(records.Level(log.level), log.name, log.message)


def _parsed(kind: type[Any], data: bytes) -> Any:  # Any: generated classes have no types
    try:
        return kind.FromString(data)
    except DecodeError as error:
        raise LogError(f"a {kind.DESCRIPTOR.full_name} message can't be decoded: {error}") from error


@singledispatch
def _message(record: object, stamp: Timestamp) -> Message:
    raise LogError(f"{type(record).__name__} has no Foxglove form")


@_message.register
def _(record: records.Image, stamp: Timestamp) -> Message:
    encoded = record.encoded
    return CompressedImage(timestamp=stamp, frame_id=CAMERA, data=encoded, format=image_format(encoded))


@_message.register
def _(record: records.Scan, stamp: Timestamp) -> Message:
    count = len(record.ranges)
    scan = LaserScan(timestamp=stamp, frame_id=BODY, pose=_pose(0.0, 0.0, 0.0), start_angle=0.0)
    scan.end_angle = math.tau * (count - 1) / count
    scan.ranges.extend(record.ranges.tolist())
    return scan


@_message.register
def _(record: records.Points, stamp: Timestamp) -> Message:
    xyz = np.zeros((len(record.points), 3), dtype="<f4")
    xyz[:, :2] = record.points
    number = PackedElementField.FLOAT32
    fields = [PackedElementField(name=name, offset=4 * i, type=number) for i, name in enumerate("xyz")]
    pose = _pose(0.0, 0.0, 0.0)
    return PointCloud(timestamp=stamp, frame_id=BODY, pose=pose, point_stride=12, fields=fields, data=xyz.tobytes())


@_message.register
def _(record: records.FramedPose, stamp: Timestamp) -> Message:
    pose = record.pose
    return PoseInFrame(timestamp=stamp, frame_id=record.frame, pose=_pose(pose.x, pose.y, pose.heading))


@_message.register
def _(record: records.Transforms, stamp: Timestamp) -> Message:
    return FrameTransforms(transforms=[_transform(one, stamp) for one in record.transforms])


@_message.register
def _(record: records.NodePoses, stamp: Timestamp) -> Message:
    poses = [_pose(x, y, heading) for x, y, heading in record.poses.tolist()]
    return PosesInFrame(timestamp=stamp, frame_id=MAP, poses=poses)


@_message.register
def _(record: records.Graph, stamp: Timestamp) -> Message:
    # one entity id: sending it again replaces the drawing, as it must after an optimisation
    entity = SceneEntity(timestamp=stamp, frame_id=MAP, id="map")
    entity.lines.extend(_lines(record))
    entity.spheres.extend(_spheres(record))
    return SceneUpdate(entities=[entity])


@_message.register
def _(record: records.Text, stamp: Timestamp) -> Message:
    return Log(timestamp=stamp, level=int(record.level), message=record.message, name=record.name)


def _lines(graph: records.Graph) -> list[Message]:
    blue, red = Color(r=0.2, g=0.4, b=0.9, a=1.0), Color(r=0.9, g=0.2, b=0.1, a=1.0)
    layers = (graph.links, blue), (graph.closures, red)
    return [_line(graph.poses, pairs, colour) for pairs, colour in layers if len(pairs)]


def _line(poses: NDArray[np.float64], pairs: NDArray[np.int64], colour: Message) -> Message:
    points = [Point3(x=x, y=y) for x, y, _ in poses[pairs.reshape(-1)].tolist()]
    return LinePrimitive(
        type=LinePrimitive.LINE_LIST, pose=_pose(0.0, 0.0, 0.0), thickness=0.03, points=points, color=colour
    )


def _spheres(graph: records.Graph) -> list[Message]:
    size, colour = Vector3(x=0.12, y=0.12, z=0.12), Color(r=0.1, g=0.6, b=0.2, a=1.0)
    rows = graph.poses[graph.snapshots].tolist()
    return [SpherePrimitive(pose=_pose(x, y, heading), size=size, color=colour) for x, y, heading in rows]


def _transform(one: records.Transform, stamp: Timestamp) -> Message:
    return FrameTransform(
        timestamp=stamp,
        parent_frame_id=one.parent,
        child_frame_id=one.child,
        translation=Vector3(x=one.pose.x, y=one.pose.y),
        rotation=_rotation(one.pose.heading),
    )


def _pose(x: float, y: float, heading: float) -> Message:
    return PoseMessage(position=Vector3(x=x, y=y), orientation=_rotation(heading))


def _rotation(heading: float) -> Message:
    return Quaternion(z=math.sin(heading / 2), w=math.cos(heading / 2))


def _stamp(stamp_ns: int) -> Timestamp:
    return Timestamp(seconds=stamp_ns // 1_000_000_000, nanos=stamp_ns % 1_000_000_000)
