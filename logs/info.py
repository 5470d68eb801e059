"""What a log is, at a glance."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from logs.header import Header
from logs.reader import LogReader
from logs.topics import ODOMETRY
from logs.verify import State


@dataclass(frozen=True, slots=True)
class TopicInfo:
    """One topic: its name, its schema and how many messages it has."""

    topic: str
    schema: str
    messages: int


@dataclass(frozen=True, slots=True)
class LogInfo:
    """A log's summary; state: whether all that was written is there; damaged: unreadable chunks."""

    path: Path
    size: int
    header: Header
    complete: bool
    state: State
    damaged: int
    steps: int
    messages: int
    start_ns: int
    end_ns: int
    topics: tuple[TopicInfo, ...]
    attachments: tuple[str, ...]

    @property
    def duration_s(self) -> float:
        """Run time from the first to the last message [s]."""
        return (self.end_ns - self.start_ns) / 1e9


def info(path: Path | str) -> LogInfo:
    """Return the summary of a log; raises LogError when it can't be read."""
    with LogReader(path, skip_damaged=True) as log:
        contents, topics = log.file.contents, _topics(log)
        return LogInfo(
            path=log.file.path,
            size=log.file.path.stat().st_size,
            header=log.header,
            complete=contents.complete,
            state=log.state,
            damaged=contents.damaged,
            steps=next((topic.messages for topic in topics if topic.topic == ODOMETRY), 0),
            messages=sum(topic.messages for topic in topics),
            start_ns=min((chunk.start_ns for chunk in contents.chunks), default=0),
            end_ns=max((chunk.end_ns for chunk in contents.chunks), default=0),
            topics=topics,
            attachments=tuple(dict.fromkeys(name for name, _ in contents.attachments)),
        )


def _topics(log: LogReader) -> tuple[TopicInfo, ...]:
    contents = log.file.contents
    schemas = {id: schema.name for id, schema in contents.schemas.items()}
    rows = [
        TopicInfo(channel.topic, schemas.get(channel.schema_id, ""), contents.counts[id])
        for id, channel in contents.channels.items()
    ]
    return tuple(sorted(rows, key=lambda row: row.topic))
