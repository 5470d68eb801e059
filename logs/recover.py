"""Repairs a cut off or damaged MCAP file into a new one."""

from __future__ import annotations

import os
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from mcap.records import Attachment, Message, Metadata
from mcap.writer import Writer

from logs.errors import LogError
from logs.mcap_file import McapFile
from logs.verify import RECOVERED, State


@dataclass(frozen=True, slots=True)
class Recovery:
    """What was saved: messages, attachments and metadata; damaged: chunks and other records left out; state: the
    source's, which the repaired log tells as well."""

    messages: int
    attachments: int
    metadata: int
    damaged: int
    state: State


def recover(source: Path | str, target: Path | str) -> Recovery:
    """Copy all that is readable, in the order it was written, into a new file with an index.

    Raises LogError when the source can't be read at all, or the target exists already or can't be written; a target
    that can't be written wholly isn't left behind.
    """
    with McapFile(source, skip_damaged=True) as file:
        try:
            with Path(target).open("xb") as out:
                return _whole_or_nothing(file, out, Path(target))
        except OSError as error:
            raise LogError(f"{target}: can't be written ({error.strerror})") from error


def _whole_or_nothing(file: McapFile, out: IO[bytes], target: Path) -> Recovery:
    try:
        saved = _copy(file, out)
        out.flush()
        os.fsync(out.fileno())
    except BaseException:
        target.unlink(missing_ok=True)
        raise
    return saved


def _copy(file: McapFile, out: IO[bytes]) -> Recovery:
    writer, counts = Writer(out, enable_data_crcs=True), Counter[type]()
    writer.start("", "topomap recover")
    if not file.state.whole:
        said = f"{file.state.word}: {file.state.note}"
        writer.add_metadata(RECOVERED, {"state": said, "damaged": str(file.contents.damaged)})
    channels = _Channels(file, writer)
    for record in file.everything():
        counts[type(record)] += 1
        if isinstance(record, Message):
            channel, stamp = channels.id(record.channel_id), record.log_time
            writer.add_message(channel, stamp, record.data, record.publish_time, record.sequence)
        elif isinstance(record, Attachment):
            times = record.create_time, record.log_time
            writer.add_attachment(*times, record.name, record.media_type, record.data)
        elif isinstance(record, Metadata):
            writer.add_metadata(record.name, record.metadata)
    writer.finish()
    damaged = counts[type(None)] + file.contents.damaged
    return Recovery(counts[Message], counts[Attachment], counts[Metadata], damaged, file.state)


class _Channels:
    """The new file's channel ids by the old ones; schemas and channels are written when first used."""

    def __init__(self, file: McapFile, writer: Writer) -> None:
        self._contents, self._writer = file.contents, writer
        self._channels: dict[int, int] = {}
        self._schemas: dict[int, int] = {0: 0}

    def id(self, old: int) -> int:
        if old not in self._channels:
            channel = self._contents.channels[old]
            schema, encoding = self._schema(channel.schema_id), channel.message_encoding
            new: int = self._writer.register_channel(channel.topic, encoding, schema, channel.metadata)
            self._channels[old] = new
        return self._channels[old]

    def _schema(self, old: int) -> int:
        if old not in self._schemas:
            schema = self._contents.schemas.get(old)
            if schema is None:
                return 0  # messages are worth keeping even where what describes them is lost
            self._schemas[old] = self._writer.register_schema(schema.name, schema.encoding, schema.data)
        return self._schemas[old]
