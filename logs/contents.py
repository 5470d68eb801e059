"""What an MCAP file holds and where, from its index or, when that is missing or damaged, from the stream."""

from __future__ import annotations

import io
import struct
import zlib
from collections import Counter
from dataclasses import dataclass, field
from typing import IO

from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    ChunkIndex,
    MetadataIndex,
    Schema,
    Statistics,
)
from mcap.stream_reader import StreamReader

from logs.pieces import MAGIC, PREFIX, size_of

FOOTER = struct.Struct("<BQQQI")
DATA_END = struct.Struct("<BQI")


@dataclass(frozen=True, slots=True)
class ChunkEntry:
    """A chunk's place and first and last stamp [ns]; channels: which ids are inside, None where unknown."""

    offset: int
    start_ns: int
    end_ns: int
    channels: frozenset[int] | None


@dataclass
class Contents:
    """A file's table of contents; attachments and metadata: (name, offset); counts: messages by channel id.

    complete: the file was closed properly; note: what is wrong otherwise; damaged: chunks that can't be read and
    aren't among `chunks`; checksum: of all bytes before the index, None where the file has none; end: where they end.
    """

    complete: bool = True
    note: str = ""
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    chunks: list[ChunkEntry] = field(default_factory=list)
    attachments: list[tuple[str, int]] = field(default_factory=list)
    metadata: list[tuple[str, int]] = field(default_factory=list)
    counts: Counter[int] = field(default_factory=Counter)
    damaged: int = 0
    checksum: int | None = None
    end: int = 0

    def note_record(self, record: object) -> None:
        """Take up a record of the index, or a schema or channel of a chunk."""
        match record:
            case Schema():
                self.schemas[record.id] = record
            case Channel():
                self.channels[record.id] = record
            case ChunkIndex():
                ids = frozenset(record.message_index_offsets) or None
                start, end = record.message_start_time, record.message_end_time
                self.chunks.append(ChunkEntry(record.chunk_start_offset, start, end, ids))
            case AttachmentIndex():
                self.attachments.append((record.name, record.offset))
            case MetadataIndex():
                self.metadata.append((record.name, record.offset))
            case Statistics():
                self.counts.update(record.channel_message_counts)
            case _:
                pass


def from_index(file: IO[bytes]) -> Contents | None:
    """Return the table of contents that a file's index holds, None where there is no sound one."""
    start = size_of(file) - len(MAGIC) - FOOTER.size
    if start < len(MAGIC):
        return None
    file.seek(start)
    tail = file.read()
    opcode, _, summary_start, _, crc = FOOTER.unpack(tail[: FOOTER.size])
    if opcode != Opcode.FOOTER or not tail.endswith(MAGIC) or not len(MAGIC) + DATA_END.size < summary_start < start:
        return None
    file.seek(summary_start - DATA_END.size)
    data_end, summary = file.read(DATA_END.size), file.read(start - summary_start)
    if crc and zlib.crc32(tail[: FOOTER.size - 4], zlib.crc32(summary)) != crc:
        return None
    contents = _summarised(summary + tail)
    if contents is not None:
        contents.end = summary_start - DATA_END.size
        opcode, length, checksum = DATA_END.unpack(data_end)
        if (opcode, length) != (Opcode.DATA_END, DATA_END.size - PREFIX.size):  # no checksum holds these nine bytes
            return None
        contents.checksum = checksum or None
    return contents


def _summarised(summary: bytes) -> Contents | None:
    contents = Contents()
    try:
        for record in StreamReader(io.BytesIO(summary), skip_magic=True, record_size_limit=len(summary)).records:
            contents.note_record(record)
    except Exception:  # an index that can't be read is the same as none, whatever the reason
        return None
    missing = any((entry.channels or frozenset()) - contents.channels.keys() for entry in contents.chunks)
    places = {entry.offset for entry in contents.chunks}
    if missing or not contents.chunks or len(places) < len(contents.chunks):
        return None
    return contents


def data_checksum(file: IO[bytes], end: int) -> int:
    """Return the CRC-32 of a file's bytes up to `end`."""
    file.seek(0)
    crc, left = 0, end
    while left > 0 and (block := file.read(min(left, 1 << 20))):
        crc, left = zlib.crc32(block, crc), left - len(block)
    return crc


def record_end(offset: int, content: bytes) -> int:
    """Return where the record at an offset ends."""
    return offset + PREFIX.size + len(content)
