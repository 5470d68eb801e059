"""What an MCAP file holds and where, from its index or, when that is missing or damaged, from the stream."""

from __future__ import annotations

import io
import struct
import zlib
from collections import Counter
from dataclasses import dataclass, field
from typing import IO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Message,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)
from mcap.stream_reader import StreamReader, breakup_chunk

MAGIC = b"\x89MCAP0\r\n"
_PREFIX = struct.Struct("<BQ")
_FOOTER = struct.Struct("<BQQQI")


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

    complete: the file was closed properly; note: what is wrong otherwise; damaged: chunks in the middle that
    can't be read.
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


def read_contents(file: IO[bytes]) -> Contents:
    """Return the table of contents of an open MCAP file, by its index if sound, else by reading through."""
    return _from_index(file) or _from_stream(file)


def read_record(file: IO[bytes], offset: int) -> tuple[int, bytes] | None:
    """Return the opcode and content of the record at an offset, None where no whole record is."""
    file.seek(offset)
    prefix = file.read(_PREFIX.size)
    if len(prefix) < _PREFIX.size:
        return None
    opcode, length = _PREFIX.unpack(prefix)
    # a damaged length may be astronomic: ask the file before the memory
    if opcode == 0 or length > _size(file) - offset - _PREFIX.size:
        return None
    return opcode, file.read(length)


def read_chunk(file: IO[bytes], offset: int) -> list[Schema | Channel | Message]:
    """Return the records of the chunk at an offset; raises ValueError when it is damaged."""
    record = read_record(file, offset)
    if record is None or record[0] != Opcode.CHUNK:
        raise ValueError("no chunk there")
    return _open_chunk(record[1])


def _open_chunk(content: bytes) -> list[Schema | Channel | Message]:
    try:
        chunk = Chunk.read(_stream(content))
        records: list[Schema | Channel | Message] = breakup_chunk(chunk, validate_crc=True)
    except Exception as error:  # mcap, zstandard, lz4 and struct each raise their own kinds
        raise ValueError(f"{type(error).__name__}: {error}") from error
    return records


def _from_index(file: IO[bytes]) -> Contents | None:
    start = _size(file) - len(MAGIC) - _FOOTER.size
    if start < len(MAGIC):
        return None
    file.seek(start)
    tail = file.read()
    opcode, _, summary_start, _, crc = _FOOTER.unpack(tail[: _FOOTER.size])
    if opcode != Opcode.FOOTER or not tail.endswith(MAGIC) or not len(MAGIC) < summary_start < start:
        return None
    file.seek(summary_start)
    summary = file.read(start - summary_start)
    if crc and zlib.crc32(tail[: _FOOTER.size - 4], zlib.crc32(summary)) != crc:
        return None
    return _summarised(summary + tail)


def _summarised(summary: bytes) -> Contents | None:
    contents = Contents()
    try:
        for record in StreamReader(io.BytesIO(summary), skip_magic=True).records:
            _note(contents, record)
    except Exception:  # an index that can't be read is the same as none, whatever the reason
        return None
    missing = any((entry.channels or frozenset()) - contents.channels.keys() for entry in contents.chunks)
    return None if missing or not contents.chunks else contents


def _note(contents: Contents, record: object) -> None:
    match record:
        case Schema():
            contents.schemas[record.id] = record
        case Channel():
            contents.channels[record.id] = record
        case ChunkIndex():
            ids = frozenset(record.message_index_offsets) or None
            start, end = record.message_start_time, record.message_end_time
            contents.chunks.append(ChunkEntry(record.chunk_start_offset, start, end, ids))
        case AttachmentIndex():
            contents.attachments.append((record.name, record.offset))
        case MetadataIndex():
            contents.metadata.append((record.name, record.offset))
        case Statistics():
            contents.counts.update(record.channel_message_counts)
        case _:
            pass


def _from_stream(file: IO[bytes]) -> Contents:
    contents = Contents(complete=False, note="it was cut off: no index at its end")
    offset, damaged_tail = len(MAGIC), 0
    while (record := read_record(file, offset)) is not None and record[0] != Opcode.DATA_END:
        sound = _scan(contents, offset, *record)
        # unreadable chunks at the very end are the cut itself, before a readable one they are damage
        damaged_tail += not sound
        if sound and record[0] == Opcode.CHUNK:
            contents.damaged, damaged_tail = contents.damaged + damaged_tail, 0
        offset += _PREFIX.size + len(record[1])
    return contents


def _scan(contents: Contents, offset: int, opcode: int, content: bytes) -> bool:
    try:
        if opcode == Opcode.CHUNK:
            _scan_chunk(contents, offset, content)
        elif opcode == Opcode.METADATA:
            contents.metadata.append((metadata(content).name, offset))
        elif opcode == Opcode.ATTACHMENT:
            contents.attachments.append((attachment(content).name, offset))
    except Exception:  # a record that can't be read is left out, whatever the reason
        return False
    return True


def _scan_chunk(contents: Contents, offset: int, content: bytes) -> None:
    records = _open_chunk(content)
    for record in records:
        if not isinstance(record, Message):
            _note(contents, record)
    messages = [record for record in records if isinstance(record, Message)]
    if not messages:
        return
    counts = Counter(message.channel_id for message in messages)
    if not counts.keys() <= contents.channels.keys():
        raise ValueError("its messages' channels were described in a chunk that is damaged")
    stamps = [message.log_time for message in messages]
    contents.counts.update(counts)
    contents.chunks.append(ChunkEntry(offset, min(stamps), max(stamps), frozenset(counts)))


def attachment(content: bytes) -> Attachment:
    """Return an attachment record; raises ValueError when its checksum is wrong, or mcap's errors."""
    crc = int.from_bytes(content[-4:], "little")
    if crc and zlib.crc32(content[:-4]) != crc:
        raise ValueError("its checksum is wrong")
    return Attachment.read(_stream(content))


def metadata(content: bytes) -> Metadata:
    """Return a metadata record; raises mcap's errors when it is damaged."""
    return Metadata.read(_stream(content))


def _stream(content: bytes) -> ReadDataStream:
    return ReadDataStream(io.BytesIO(content))


def _size(file: IO[bytes]) -> int:
    here = file.tell()
    size = file.seek(0, io.SEEK_END)
    file.seek(here)
    return size
