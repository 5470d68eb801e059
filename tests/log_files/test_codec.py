"""Own records survive protobuf bit by bit, and the committed .proto is what the dataclasses say."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Optional

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import logs.schemas
from logs import records as log
from logs.errors import LogError
from logs.schemas.codec import RECORDS, decode, encode
from logs.schemas.descriptor import Shape, _shape, file_descriptor, proto_text, shapes
from logs.schemas.wire import too_many_fields

floats = st.floats(allow_nan=False)
int64 = st.integers(-(2**63), 2**63 - 1)
odometries = st.builds(
    log.Odometry,
    forward=floats,
    left=floats,
    turn=floats,
    covariance=st.lists(floats, min_size=9, max_size=9).map(tuple),
    dt=floats,
    contact=st.booleans(),
    driven=st.booleans(),
    scanned=st.booleans(),
)
poses = st.builds(log.Pose, floats, floats, floats)
closures = st.builds(
    log.Closure,
    stamp_ns=int64,
    verdict=st.text(),
    reason=st.text(),
    query_ns=int64,
    query=st.none() | int64,
    match=int64,
    match_ns=int64,
    relative=poses,
    covariance=st.lists(floats, max_size=9).map(tuple),
    similarity=floats,
    scores=st.lists(st.builds(log.Score, st.text(), floats), max_size=4).map(tuple),
)


@settings(deadline=None)
@given(odometries)
def test_odometry_is_bit_equal(record: log.Odometry) -> None:
    back = decode(log.Odometry, encode(record))
    assert back == record
    assert struct.pack("<3d", back.forward, back.left, back.turn) == struct.pack(
        "<3d", record.forward, record.left, record.turn
    )


@settings(max_examples=40, deadline=None)
@given(closures)
def test_a_closure_keeps_every_field(record: log.Closure) -> None:
    assert decode(log.Closure, encode(record)) == record


@pytest.mark.parametrize("node", [None, 0, 3])
def test_none_and_zero_stay_apart(node: int | None) -> None:
    record = log.Belief(log.Pose(), log.Pose(1.0, -0.0, 3.0), node, 0.5, 0.0)
    assert decode(log.Belief, encode(record)).node == node


def test_a_missing_nested_record_stays_none() -> None:
    final = log.Final((1, 2), (0.0,) * 6, (), (log.Edge(1, 2, "odometry"),), None, "abc", None, 0)
    assert decode(log.Final, encode(final)) == final


def test_rubbish_is_a_log_error() -> None:
    with pytest.raises(LogError, match="Odometry"):
        decode(log.Odometry, b"\xff\xff\xff")


@pytest.mark.parametrize(
    "hint", [int | str, int | str | None, tuple[int, str], tuple[int, int], list[int], complex, dict[str, int]]
)
def test_a_type_without_a_protobuf_form_is_refused(hint: object) -> None:
    with pytest.raises(TypeError, match="no protobuf form for thing"):
        _shape("thing", hint)


def test_a_field_is_one_value_several_or_maybe_none() -> None:
    assert _shape("a", float) == Shape("a", float, False)
    assert _shape("a", log.Pose | None) == Shape("a", log.Pose, True, optional=True)
    assert _shape("a", Optional[int]) == Shape("a", int, False, optional=True)  # noqa: UP045 as older code writes it
    assert _shape("a", tuple[log.Pose, ...]) == Shape("a", log.Pose, True, repeated=True)


def test_a_scalar_that_may_be_none_stands_in_a_oneof_of_its_own() -> None:
    for record, message in zip(RECORDS, file_descriptor(RECORDS).message_type, strict=True):
        maybe = [shape.name for shape in shapes(record) if shape.optional and not shape.nested]
        assert [one.name for one in message.oneof_decl] == [f"_{name}" for name in maybe]
        assert [field.name for field in message.field if field.proto3_optional] == maybe


def test_values_are_counted_before_they_are_made() -> None:
    fixed, half = bytes([1 << 3 | 1]) + bytes(8), bytes([2 << 3 | 5]) + bytes(4)
    several = bytes([3 << 3 | 2, 3, 200, 200, 200])
    message = fixed + half + several + bytes([4 << 3, 200, 1])
    assert not too_many_fields(message, 4)
    assert too_many_fields(message, 3)
    assert not too_many_fields(message[:-1], 3)  # cut off: left to the decoder


def test_the_committed_proto_is_what_the_records_say() -> None:
    path = Path(logs.schemas.__file__).with_name("topomap.proto")
    assert path.read_text() == proto_text(RECORDS)
