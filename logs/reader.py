"""Reads topomap's logs, whole or cut off."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TypeVar

from logs import header as head
from logs.budget import gathered_limit
from logs.errors import LogError
from logs.header import Header
from logs.mcap_file import Item, McapFile
from logs.schemas import codec, foxglove
from logs.topics import PANORAMA
from logs.verify import State

R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class Gathered:
    """Messages in file order by topic."""

    rows: Mapping[str, list[Item]]

    def records(self, topic: str, kind: type[R]) -> list[tuple[int, R]]:
        """Return stamp [ns] and record of each message of a topic that is stored as `topomap.*`."""
        return [(item.stamp_ns, codec.decode(kind, item.data)) for item in self.rows[topic]]


class LogReader:
    """An open topomap log; raises LogError when the file can't be read or isn't one."""

    def __init__(self, path: Path | str, skip_damaged: bool = False) -> None:
        self.file = McapFile(path, skip_damaged)
        try:
            self.header: Header = _header(self.file)
        except BaseException:
            self.file.close()
            raise

    @property
    def state(self) -> State:
        """Whether all that was written is there."""
        return self.file.state

    @property
    def complete(self) -> bool:
        """Whether the log was closed properly."""
        return self.file.contents.complete

    def items(self, *topics: str) -> Iterator[Item]:
        """Yield the raw messages of some topics in file order."""
        return self.file.items(topics)

    def records(self, topic: str, kind: type[R]) -> Iterator[tuple[int, R]]:
        """Yield stamp [ns] and record of each message of a topic that is stored as `topomap.*`."""
        for item in self.file.items((topic,)):
            yield item.stamp_ns, codec.decode(kind, item.data)

    def gather(self, topics: Collection[str]) -> Gathered:
        """Return all messages of some topics, read in one pass; raises LogError for more than a log holds."""
        rows: dict[str, list[Item]] = {topic: [] for topic in topics}
        left = gathered_limit(self.file.size)
        for item in self.file.items(topics):
            left -= len(item.data)
            if left < 0:
                raise LogError(f"{self.file.path}: its messages are larger than any log of its size holds")
            rows[item.topic].append(item)
        return Gathered(rows)

    def panorama(self, stamp_ns: int) -> bytes | None:
        """Return the encoded panorama of one stamp, None where there is none."""
        items = self.file.items((PANORAMA,), stamp_ns, stamp_ns)
        return next((foxglove.decode_image(item.data) for item in items), None)

    def attachment(self, name: str) -> bytes | None:
        """Return an attached file, None where there is none."""
        return self.file.attachment(name)

    def close(self) -> None:
        """Close the file."""
        self.file.close()

    def __enter__(self) -> LogReader:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _header(file: McapFile) -> Header:
    return _whole_header(file) or _header_in_parts(file)


def _whole_header(file: McapFile) -> Header | None:
    """Return the header that has a checksum, None where it is missing, as in old logs, or damaged."""
    try:
        whole = file.attachment(head.WHOLE)
    except LogError:
        return None
    try:
        return None if whole is None else Header.of_whole(whole)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise LogError(f"{file.path}: its header can't be read ({error})") from error


def _header_in_parts(file: McapFile) -> Header:
    run = file.metadata(head.RUN)
    if run is None:
        cut = "" if file.contents.complete else ", or cut off inside its header"
        raise LogError(f"{file.path}: not a log of topomap{cut} (no {head.RUN} record)")
    config, plan = file.attachment(head.CONFIG), file.attachment(head.PLAN)
    if config is None or plan is None:
        raise LogError(f"{file.path}: cut off inside its header")
    try:
        return Header.of(run, file.metadata(head.VERSIONS) or {}, config, plan)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise LogError(f"{file.path}: its header can't be read ({error})") from error
