"""A file read through from its start: what is there when the index is missing or damaged."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import IO

from mcap.opcode import Opcode
from mcap.records import Message

from logs.budget import Budget
from logs.contents import ChunkEntry, Contents, record_end
from logs.errors import LogError
from logs.header import WHOLE
from logs.pieces import (
    MAGIC,
    PREFIX,
    attachment,
    fits,
    metadata,
    open_chunk,
    read_by_inner_length,
    read_record,
    size_of,
)

BLOCK = 1 << 20
MARKS = (
    (b"\x04\0\0\0zstd", PREFIX.size + 28),
    (b"\x03\0\0\0lz4", PREFIX.size + 28),
    (len(WHOLE).to_bytes(4, "little") + WHOLE.encode(), PREFIX.size + 16),
)
"""Bytes inside a packed chunk and inside the header's copy, and how far behind the record's start they lie: by these
reading goes on after a record whose length is damaged."""


def from_stream(file: IO[bytes]) -> Contents:
    """Return the table of contents of a file that is read through; raises LogError for one that unpacks to too much."""
    contents = Contents(complete=False, note="it was cut off: no index at its end")
    budget, damaged_tail, ended = Budget.of(size_of(file)), 0, False
    for offset, record in _records(file):
        if record is None:
            damaged_tail += 1
            continue
        if record[0] == Opcode.DATA_END:
            ended = True
            break
        sound = _scan(contents, offset, *record, budget)
        # unreadable records at the very end are the cut itself, before a readable one they are damage
        damaged_tail += not sound
        if sound and record[0] in (Opcode.CHUNK, Opcode.ATTACHMENT):
            contents.damaged, damaged_tail = contents.damaged + damaged_tail, 0
    # a cut goes through one record at most
    contents.damaged += damaged_tail if ended else max(damaged_tail - 1, 0)
    if ended:
        contents.note = "its index is cut off or damaged"
    return contents


def _records(file: IO[bytes]) -> Iterator[tuple[int, tuple[int, bytes] | None]]:
    """Yield offset, and opcode and content, of each record; None where one is damaged and reading goes on behind it."""
    offset: int | None = len(MAGIC)
    last = len(MAGIC)  # where a record may have begun whose length led astray
    while offset is not None:
        record = read_record(file, offset)
        if record is not None and fits(*record):
            yield offset, record
            last, offset = offset, record_end(offset, record[1])
            continue
        inner = read_by_inner_length(file, offset)
        if inner is not None:
            yield offset, None
            yield offset, inner
            last, offset = offset, record_end(offset, inner[1])
            continue
        found = _next(file, last + 1)
        if found == offset:
            found = _next(file, offset + 1)
        if found is not None:
            yield offset, None
            last = found
        offset = found


def _next(file: IO[bytes], start: int) -> int | None:
    """Return where the next record that bears a mark begins, at `start` or later."""
    keep = max(len(mark) for mark, _ in MARKS)
    file.seek(start)
    before, place = b"", start
    while block := file.read(BLOCK):
        window, base = before + block, place - len(before)
        hits = [base + hit - back for mark, back in MARKS if (hit := window.find(mark)) >= 0]
        sound = [hit for hit in hits if hit >= start]
        if sound:
            return min(sound)
        before, place = window[-keep:], place + len(block)
    return None


def _scan(contents: Contents, offset: int, opcode: int, content: bytes, budget: Budget) -> bool:
    try:
        if opcode == Opcode.CHUNK:
            _scan_chunk(contents, offset, content, budget)
        elif opcode == Opcode.METADATA:
            contents.metadata.append((metadata(content).name, offset))
        elif opcode == Opcode.ATTACHMENT:
            contents.attachments.append((attachment(content).name, offset))
    except LogError:
        raise
    except Exception:  # a record that can't be read is left out, whatever the reason
        return False
    return True


def _scan_chunk(contents: Contents, offset: int, content: bytes, budget: Budget) -> None:
    records = open_chunk(content, budget)
    for record in records:
        if not isinstance(record, Message):
            contents.note_record(record)
    messages = [record for record in records if isinstance(record, Message)]
    if not messages:
        return
    counts = Counter(message.channel_id for message in messages)
    if not counts.keys() <= contents.channels.keys():
        raise ValueError("its messages' channels were described in a chunk that is damaged")
    stamps = [message.log_time for message in messages]
    contents.counts.update(counts)
    contents.chunks.append(ChunkEntry(offset, min(stamps), max(stamps), frozenset(counts)))
