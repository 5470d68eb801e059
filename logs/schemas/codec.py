"""Own records to protobuf bytes and back."""

from __future__ import annotations

from typing import TypeVar

from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message import DecodeError, Message
from google.protobuf.message_factory import GetMessageClass

from logs import records
from logs.budget import FIELD_FREE, FIELD_LIMIT
from logs.errors import LogError
from logs.schemas.descriptor import PACKAGE, file_descriptor, shapes
from logs.schemas.wire import too_many_fields

R = TypeVar("R")

RECORDS: tuple[type, ...] = (
    records.Pose,
    records.Odometry,
    records.Truth,
    records.Belief,
    records.ImageDifference,
    records.HomeVector,
    records.Command,
    records.Mission,
    records.Node,
    records.Score,
    records.Closure,
    records.Estimate,
    records.Calibration,
    records.Timings,
    records.Performance,
    records.Edge,
    records.Final,
)

# A pool of our own: the default one is shared with every other library of the process.
_POOL = DescriptorPool()
_POOL.Add(file_descriptor(RECORDS))
MESSAGES: dict[type, type[Message]] = {
    record: GetMessageClass(_POOL.FindMessageTypeByName(f"{PACKAGE}.{record.__name__}")) for record in RECORDS
}


def encode(record: object) -> bytes:
    """Return the protobuf bytes of an own record."""
    return _pack(record).SerializeToString(deterministic=True)


def decode(kind: type[R], data: bytes) -> R:
    """Return the record of protobuf bytes; raises LogError when they aren't one or hold more than any record does."""
    if len(data) > FIELD_FREE and too_many_fields(data):
        raise LogError(f"a {PACKAGE}.{kind.__name__} message holds more than {FIELD_LIMIT} values: it isn't read")
    try:
        return _unpack(kind, MESSAGES[kind].FromString(data))
    except DecodeError as error:
        raise LogError(f"a {PACKAGE}.{kind.__name__} message can't be decoded: {error}") from error


def _pack(record: object) -> Message:
    values: dict[str, object] = {}
    for shape in shapes(type(record)):
        value = getattr(record, shape.name)
        if shape.nested and shape.repeated:
            value = [_pack(item) for item in value]
        elif shape.nested and value is not None:
            value = _pack(value)
        values[shape.name] = value
    return MESSAGES[type(record)](**values)


def _unpack(kind: type[R], message: Message) -> R:
    values: dict[str, object] = {}
    for shape in shapes(kind):
        value = getattr(message, shape.name)
        if shape.optional and not message.HasField(shape.name):
            value = None
        elif shape.repeated:
            value = tuple(_unpack(shape.kind, item) for item in value) if shape.nested else tuple(value)
        elif shape.nested:
            value = _unpack(shape.kind, value)
        values[shape.name] = value
    return kind(**values)
