"""Whether all that was written into a log is there, found out when it is opened."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import IO, Literal

from mcap.opcode import Opcode
from mcap.records import Message

from logs.budget import Budget
from logs.contents import Contents, data_checksum, from_index
from logs.errors import LogError
from logs.pieces import attachment, checksummed, metadata, open_chunk, read_record, size_of
from logs.scan import from_stream

RECOVERED = "topomap.recovered"
"""The metadata of a repaired log: which state its source was in."""


@dataclass(frozen=True, slots=True)
class State:
    """What is known of a log's wholeness, and a line that says it; the note of a whole one is empty."""

    word: Literal["whole", "cut off", "damaged", "unverified", "recovered"]
    note: str = ""

    @property
    def whole(self) -> bool:
        """Whether all that was written is there, unchanged."""
        return self.word == "whole"


WHOLE = State("whole")


def read_contents(file: IO[bytes]) -> tuple[Contents, State]:
    """Return the table of contents of an open MCAP file, by its index if sound, else by reading through, and its state.

    Raises LogError for a file that unpacks to too much.
    """
    contents = from_index(file)
    if contents is None:
        contents = from_stream(file)
        return contents, _state_of_stream(contents)
    if contents.checksum is not None and data_checksum(file, contents.end) == contents.checksum:
        return contents, WHOLE
    return contents, _search(file, contents)


def recovered(state: State, contents: Contents, read: Callable[[str], dict[str, str] | None]) -> State:
    """Return a file's state; of a whole one what the one was that it was repaired from, if it was."""
    if not state.whole or all(name != RECOVERED for name, _ in contents.metadata):
        return state
    source = read(RECOVERED) or {}
    return State("recovered", f"it was repaired from a log that was {source.get('state', 'damaged')}")


def _state_of_stream(contents: Contents) -> State:
    if contents.damaged:
        return State("damaged", f"{contents.note}; {_left_out(contents.damaged)}")
    return State("cut off", contents.note)


def _search(file: IO[bytes], contents: Contents) -> State:
    """Take the chunks that can't be read out of the contents; return what is wrong with the file."""
    unverified = _drop_damaged(file, contents)
    lost = _damaged(file, contents)
    if contents.damaged:
        return State("damaged", _left_out(contents.damaged))
    if lost:
        return State("damaged", f"{', '.join(lost)} can't be read")
    if contents.checksum is not None:
        return State("damaged", "bytes outside its chunks aren't those that were written (checksum)")
    # before files had one checksum each chunk and each attachment had its own
    return State("unverified", "it holds no checksums") if unverified else WHOLE


def _drop_damaged(file: IO[bytes], contents: Contents) -> bool:
    """Keep the chunks that can be read; return whether one of them has no checksum."""
    budget, sound, unverified = Budget.of(size_of(file)), [], False
    counts = Counter[int]()
    for entry in contents.chunks:
        try:
            record = read_record(file, entry.offset)
            if record is None or record[0] != Opcode.CHUNK:
                raise ValueError("no chunk there")
            counts.update(one.channel_id for one in open_chunk(record[1], budget) if isinstance(one, Message))
            unverified = unverified or not checksummed(record[1])
        except LogError:
            raise
        except Exception:  # as in open_chunk
            contents.damaged += 1
        else:
            sound.append(entry)
    contents.chunks[:], contents.counts = sound, counts
    return unverified


def _damaged(file: IO[bytes], contents: Contents) -> list[str]:
    """Return the names of the attachments and metadata that can't be read."""
    found = []
    kinds = ((attachment, contents.attachments, Opcode.ATTACHMENT), (metadata, contents.metadata, Opcode.METADATA))
    for read, places, opcode in kinds:
        for name, offset in places:
            record = read_record(file, offset)
            try:
                if record is None or record[0] != opcode:
                    raise ValueError("no such record there")
                read(record[1])
            except Exception:  # whatever damaged bytes lead to
                found.append(name)
    return found


def _left_out(chunks: int) -> str:
    return f"{chunks} of its chunks can't be read and {'is' if chunks == 1 else 'are'} left out"
