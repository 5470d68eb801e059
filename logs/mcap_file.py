"""An MCAP file of any origin, open for reading, whole or cut off."""

from __future__ import annotations

import stat
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import IO

from mcap.records import Attachment, Message, Metadata

from logs.budget import Budget
from logs.contents import Contents
from logs.errors import LogError
from logs.pieces import MAGIC, attachment, metadata, read_chunk, read_record, size_of
from logs.verify import State, read_contents, recovered

_Read = Callable[[IO[bytes], int, Budget], Sequence[Message | Attachment | Metadata | None]]
MAGIC_SOUND = 6  # of the eight first bytes: a flipped bit or two don't make it another kind of file


@dataclass(frozen=True, slots=True)
class Item:
    """A stored message: its topic, the name of its schema, its log time and its bytes."""

    topic: str
    schema: str
    stamp_ns: int
    data: bytes


class McapFile:
    """An open MCAP file, all of whose checksums were verified when it was opened.

    skip_damaged: leave out damaged chunks instead of raising. state: whether all that was written is there. Raises
    LogError when the file is missing, isn't an MCAP file, ends before its first record or unpacks to too much.
    """

    def __init__(self, path: Path | str, skip_damaged: bool = False) -> None:
        self.path = Path(path)
        self._skip_damaged = skip_damaged
        self._file = _open(self.path)
        try:
            self.contents, self.state = self._read()
            self.state = recovered(self.state, self.contents, self.metadata)
            if self.contents.damaged and not skip_damaged:
                raise LogError(self._damage(f"{self.contents.damaged} of its chunks can't be read"))
        except BaseException:
            self._file.close()
            raise

    @property
    def size(self) -> int:
        """The file's length [bytes]."""
        return size_of(self._file)

    def items(
        self, topics: Collection[str] | None = None, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[Item]:
        """Yield the messages of some topics (None: all) in file order, start_ns and end_ns included."""
        channels = self.contents.channels
        wanted = {id for id, channel in channels.items() if topics is None or channel.topic in topics}
        for message in self._messages(wanted, start_ns, end_ns):
            channel = channels[message.channel_id]
            schema = self.contents.schemas.get(channel.schema_id)
            yield Item(channel.topic, schema.name if schema else "", message.log_time, message.data)

    def metadata(self, name: str) -> dict[str, str] | None:
        """Return the last metadata of a name, or None; raises LogError when it is damaged."""
        content = self._named(name, self.contents.metadata)
        try:
            values: dict[str, str] | None = None if content is None else metadata(content).metadata
        except Exception as error:  # struct, Unicode, mcap: whatever damaged bytes lead to
            raise LogError(self._damage(f"metadata {name} can't be read")) from error
        return values

    def attachment(self, name: str) -> bytes | None:
        """Return the last attachment of a name, or None; raises LogError when it is damaged."""
        content = self._named(name, self.contents.attachments)
        try:
            data: bytes | None = None if content is None else attachment(content).data
        except Exception as error:  # as above
            raise LogError(self._damage(f"attachment {name} can't be read")) from error
        return data

    def everything(self) -> Iterator[Message | Attachment | Metadata | None]:
        """Yield messages, attachments and metadata in file order, None for each that can't be read."""
        contents = self.contents
        places: list[tuple[int, _Read]] = [(entry.offset, _chunk) for entry in contents.chunks]
        places += [(offset, _attachment) for _, offset in contents.attachments]
        places += [(offset, _metadata) for _, offset in contents.metadata]
        budget = Budget.of(self.size)
        for offset, read in sorted(places, key=lambda place: place[0]):
            try:
                records = read(self._file, offset, budget)
            except (OSError, LogError):
                raise
            except Exception:  # what can't be read is reported as such, whatever the reason
                records = [None]
            for record in records:
                known = not isinstance(record, Message) or record.channel_id in contents.channels
                yield record if known else None

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> McapFile:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _read(self) -> tuple[Contents, State]:
        try:
            contents, state = read_contents(self._file)
        except LogError as error:
            raise LogError(f"{self.path}: {error}") from error
        if not _has_magic(self._file):
            state = State("damaged", "its first bytes aren't those of an MCAP file")
        return contents, state

    def _messages(self, channels: set[int], start_ns: int | None, end_ns: int | None) -> Iterator[Message]:
        low, high = start_ns or 0, (1 << 64) if end_ns is None else end_ns
        budget = Budget.of(self.size)
        for entry in self.contents.chunks:
            if entry.end_ns < low or entry.start_ns > high:
                continue
            if entry.channels and not entry.channels & channels:
                continue
            for message in self._chunk(entry.offset, budget):
                if message.channel_id in channels and low <= message.log_time <= high:
                    yield message

    def _chunk(self, offset: int, budget: Budget) -> list[Message]:
        try:
            return _chunk(self._file, offset, budget)
        except LogError as error:
            raise LogError(f"{self.path}: {error}") from error
        except ValueError as error:
            if self._skip_damaged:
                return []
            raise LogError(self._damage(f"the chunk at byte {offset} can't be read")) from error

    def _named(self, name: str, places: list[tuple[str, int]]) -> bytes | None:
        offsets = [offset for found, offset in places if found == name]
        record = read_record(self._file, offsets[-1]) if offsets else None
        return record[1] if record else None

    def _damage(self, what: str) -> str:
        return f"{self.path}: damaged, {what}; repair it into a new file first"


def _chunk(file: IO[bytes], offset: int, budget: Budget) -> list[Message]:
    return [record for record in read_chunk(file, offset, budget) if isinstance(record, Message)]


def _attachment(file: IO[bytes], offset: int, _: Budget) -> list[Attachment]:
    return [attachment(_content(file, offset))]


def _metadata(file: IO[bytes], offset: int, _: Budget) -> list[Metadata]:
    return [metadata(_content(file, offset))]


def _content(file: IO[bytes], offset: int) -> bytes:
    record = read_record(file, offset)
    if record is None:
        raise ValueError("no whole record there")
    return record[1]


def _open(path: Path) -> IO[bytes]:
    try:
        if not stat.S_ISREG(path.stat().st_mode) and not path.is_dir():  # a pipe would be waited for without end
            raise LogError(f"{path}: can't be read (it is no regular file)")
        file = path.open("rb")
        magic = file.read(len(MAGIC))
    except (OSError, ValueError) as error:
        raise LogError(f"{path}: can't be read ({getattr(error, 'strerror', error)})") from error
    if len(magic) == len(MAGIC) and sum(a == b for a, b in zip(magic, MAGIC, strict=True)) >= MAGIC_SOUND:
        return file
    file.close()
    if MAGIC.startswith(magic):
        raise LogError(f"{path}: cut off before its first record ({len(magic)} bytes)")
    raise LogError(f"{path}: not an MCAP file")


def _has_magic(file: IO[bytes]) -> bool:
    file.seek(0)
    return file.read(len(MAGIC)) == MAGIC
