"""Logs that somebody wrote by hand: every record of a whole one in turn replaced by what no run writes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from google.protobuf.message import Message as Protobuf
from mcap.records import Attachment, Message, Metadata
from mcap.writer import Writer

from logs.mcap_file import McapFile
from logs.schemas import codec
from logs.topics import TOPICS

Change = Callable[[bytes], bytes]
EXTREME = {"double": (float("nan"), float("inf"), -1e308), "int64": (-(2**63), 2**63 - 1), "string": ("\x1b[31m[/x]",)}
DEEP = "[" * 100_000
HEADERS: dict[str, object] = {
    "world": "../[/x]\x1b[2J$\\frac{$",
    "seed": "seven",
    "rig": {"width": 10**9, "height": 10**9},
    "start": [1, 2],
    "errors": {"rotation_scale": "much"},
    "replayed": {},
}


def crafted(source: Path, target: Path) -> Iterator[str]:
    """Write one log after the other to a path and say what is wrong with each."""
    for topic in TOPICS:
        for name, change in _changes(topic).items():
            rewrite(source, target, topic, change)
            yield f"{topic}: {name}"
    for name, value in HEADERS.items():
        rewrite(source, target, header={name: json.dumps(value)})
        yield f"header: {name} = {value!r}"
    for name in ("config", "plan"):
        for text in (DEEP, "{}", "7", "", '{"stack": 3}', '{"sim": {"kidnaps": [{"at_s": NaN}]}}'):
            rewrite(source, target, parts={name: text})
            yield f"header: {name} is {text[:40]!r}"


def rewrite(
    source: Path,
    target: Path,
    topic: str = "",
    change: Change | None = None,
    header: dict[str, str] | None = None,
    parts: dict[str, str] | None = None,
) -> None:
    """Copy a log with the messages of one topic, fields of its header or its config and plan changed."""
    with McapFile(source) as file, target.open("wb") as out:
        writer, known = Writer(out, enable_data_crcs=True), dict[int, int]()
        writer.start("", "")
        contents = file.contents
        for record in file.everything():
            if isinstance(record, Message):
                channel = contents.channels[record.channel_id]
                schema = contents.schemas[channel.schema_id]
                if channel.id not in known:
                    made = writer.register_schema(schema.name, schema.encoding, schema.data)
                    known[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, made)
                data = change(record.data) if change is not None and channel.topic == topic else record.data
                writer.add_message(known[channel.id], record.log_time, data, record.publish_time)
            elif isinstance(record, Metadata):
                writer.add_metadata(record.name, record.metadata)
            elif isinstance(record, Attachment):
                writer.add_attachment(0, 0, record.name, record.media_type, _whole(record, header, parts))
        writer.finish()


def _whole(record: Attachment, header: dict[str, str] | None, parts: dict[str, str] | None) -> bytes:
    if record.name != "header.json":
        return bytes(record.data)
    whole = json.loads(record.data)
    whole["run"].update(header or {})
    return json.dumps(whole | (parts or {})).encode()


def _changes(topic: str) -> dict[str, Change]:
    rng = np.random.default_rng(0)
    noise = rng.bytes(200)
    found: dict[str, Change] = {"nothing": lambda _: b"", "noise": lambda _: noise, "half": lambda d: d[: len(d) // 2]}
    record = TOPICS[topic]
    if record in codec.MESSAGES:
        found["extremes"] = lambda data: _extreme(codec.MESSAGES[record].FromString(data))
        found["no lists"] = lambda data: _without_lists(codec.MESSAGES[record].FromString(data))
    return found


def _extreme(message: Protobuf) -> bytes:
    """Return a message whose numbers are as large as can be, and whose words steer a terminal."""
    _fill(message, 0)
    return message.SerializeToString()


def _fill(message: Protobuf, turn: int) -> None:
    for field in message.DESCRIPTOR.fields:
        kind = {field.TYPE_DOUBLE: "double", field.TYPE_INT64: "int64", field.TYPE_STRING: "string"}.get(field.type)
        value = getattr(message, field.name)
        if kind is None and field.message_type is not None:
            for one in value if field.is_repeated else [value] if message.HasField(field.name) else []:
                _fill(one, turn + 1)
        elif kind is not None:
            choice = EXTREME[kind][(field.number + turn) % len(EXTREME[kind])]
            if field.is_repeated:
                value[:] = [choice] * len(value)
            else:
                setattr(message, field.name, choice)


def _without_lists(message: Protobuf) -> bytes:
    for field in message.DESCRIPTOR.fields:
        if field.is_repeated:
            message.ClearField(field.name)
    return message.SerializeToString()
