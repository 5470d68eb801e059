"""The records of an MCAP file, one at a time: found at an offset, unpacked within bounds, checked by their sums."""

from __future__ import annotations

import io
import struct
import zlib
from dataclasses import replace
from typing import IO

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Message, Metadata, Schema
from mcap.stream_reader import breakup_chunk

from logs.budget import CHUNK_LIMIT, Budget
from logs.errors import LogError

MAGIC = b"\x89MCAP0\r\n"
PREFIX = struct.Struct("<BQ")
_FREE = (Opcode.HEADER, Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)
"""What may stand outside chunks besides; how long it is follows from it no further."""


def size_of(file: IO[bytes]) -> int:
    """Return the length of an open file [bytes]."""
    here = file.tell()
    size = file.seek(0, io.SEEK_END)
    file.seek(here)
    return size


def read_record(file: IO[bytes], offset: int) -> tuple[int, bytes] | None:
    """Return the opcode and content of the record at an offset, None where no whole record is."""
    file.seek(offset)
    prefix = file.read(PREFIX.size)
    if len(prefix) < PREFIX.size:
        return None
    opcode, length = PREFIX.unpack(prefix)
    # a damaged length may be astronomic: ask the file before the memory
    if opcode == 0 or length > size_of(file) - offset - PREFIX.size:
        return None
    return opcode, file.read(length)


def fits(opcode: int, content: bytes) -> bool:
    """Return whether a record is exactly as long as what it holds: else it leads astray where the next one begins."""
    end = len(content)
    if opcode == Opcode.CHUNK:
        return _sized(content, (28, 4), (0, 8)) == end
    if opcode == Opcode.ATTACHMENT:
        return _sized(content, (16, 4), (0, 4), (0, 8)) == end - 4
    if opcode == Opcode.METADATA:
        return _sized(content, (0, 4), (0, 4)) == end
    if opcode == Opcode.MESSAGE_INDEX:
        return _sized(content, (2, 4)) == end
    return (opcode == Opcode.DATA_END and end == 4) or opcode in _FREE


def read_by_inner_length(file: IO[bytes], offset: int) -> tuple[int, bytes] | None:
    """Return a chunk whose own length is damaged but whose content says how long it is, None where none is.

    Its checksum tells whether it was one.
    """
    file.seek(offset)
    start = file.read(PREFIX.size + 64)
    if len(start) < PREFIX.size + 64 or start[0] != Opcode.CHUNK:
        return None
    length = _sized(start[PREFIX.size :], (28, 4), (0, 8))
    if length > size_of(file) - offset - PREFIX.size:
        return None
    file.seek(offset + PREFIX.size)
    content = file.read(length)
    return (int(Opcode.CHUNK), content) if fits(Opcode.CHUNK, content) else None


def _sized(content: bytes, *fields: tuple[int, int]) -> int:
    """Return where the last of some fields ends, each so many bytes behind the one before, its length in so many."""
    place = 0
    for gap, width in fields:
        place += gap + width
        place += int.from_bytes(content[place - width : place], "little")
    return place


def read_chunk(file: IO[bytes], offset: int, budget: Budget) -> list[Schema | Channel | Message]:
    """Return the records of the chunk at an offset; raises ValueError when it is damaged, LogError over budget."""
    record = read_record(file, offset)
    if record is None or record[0] != Opcode.CHUNK:
        raise ValueError("no chunk there")
    return open_chunk(record[1], budget)


def open_chunk(content: bytes, budget: Budget) -> list[Schema | Channel | Message]:
    """Return the records in a chunk record; raises ValueError when it is damaged, LogError over budget."""
    try:
        chunk = Chunk.read(_stream(content))
        data = _unpacked(chunk)
        messages = _messages(data, budget.messages_left)
        budget.take(len(data), messages)
        plain = replace(chunk, compression="", data=data)
        records: list[Schema | Channel | Message] = breakup_chunk(plain, validate_crc=True)
    except LogError:
        raise
    except Exception as error:  # mcap, zstandard, lz4 and struct each raise their own kinds
        raise ValueError(f"{type(error).__name__}: {error}") from error
    return records


def checksummed(content: bytes) -> bool:
    """Return whether a chunk record holds a checksum of its content; raises mcap's errors when it is damaged."""
    return bool(Chunk.read(_stream(content)).uncompressed_crc)


def _unpacked(chunk: Chunk) -> bytes:
    """Return a chunk's bytes, never more than it says and never more than the limit; raises ValueError."""
    size = chunk.uncompressed_size
    if size > CHUNK_LIMIT:
        raise ValueError(f"it says that it unpacks to {size} bytes")
    if chunk.compression == "zstd":
        data = zstandard.ZstdDecompressor().stream_reader(chunk.data).read(size + 1)
    elif chunk.compression == "lz4":
        data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size + 1)
    elif chunk.compression == "":
        data = chunk.data
    else:
        raise ValueError(f"its compression {chunk.compression!r} isn't known")
    if len(data) != size:
        raise ValueError(f"it doesn't unpack to the {size} bytes that it says")
    return bytes(data)


def _messages(data: bytes, most: int) -> int:
    """Return how many records a chunk holds, counted only until there are too many."""
    place = count = 0
    while place + PREFIX.size <= len(data) and count <= most:
        place += PREFIX.size + int(PREFIX.unpack_from(data, place)[1])
        count += 1
    return count


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
