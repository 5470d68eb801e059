"""Writes one run into one MCAP file so that a crash costs at most the last second."""

from __future__ import annotations

import errno
import os
import time
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import IO

from mcap.writer import CompressionType, Writer
from mcap_protobuf.schema import build_file_descriptor_set

from logs import header as head
from logs.config import Compression, LogConfig
from logs.errors import LogError
from logs.header import Header
from logs.schemas import codec, foxglove
from logs.topics import TOPICS

_COMPRESSIONS = {"zstd": CompressionType.ZSTD, "lz4": CompressionType.LZ4, "none": CompressionType.NONE}
_FSYNC_SECONDS = 1.0
CHUNK_SIZE = 262_144  # [bytes, uncompressed] at which a chunk is closed: a dozen steps of the default camera
FLUSH_SECONDS = 0.5  # that steps wait in memory: what a killed process may lose


class Recorder:
    """An open log; the header is on disk when the constructor returns.

    Finished steps are handed to the operating system every `flush_seconds` of run time and of wall time (that
    is enough to survive a killed process) and to the disk once per wall second (for a power cut). An existing
    file is replaced, a symbolic link isn't followed. Raises LogError when the file can't be written.
    """

    def __init__(
        self,
        path: Path | str,
        header: Header,
        compression: Compression = "zstd",
        chunk_size: int = CHUNK_SIZE,
        flush_seconds: float = FLUSH_SECONDS,
    ) -> None:
        self._path = Path(path)
        self._flush_ns = int(flush_seconds * 1e9)
        self._channels: dict[str, int] = {}
        self._schemas: dict[type, int] = {}
        self._stamp: int | None = None
        self._waiting_stamp = 0  # the first that isn't flushed
        self._flushed_at = self._synced_at = time.monotonic_ns()
        self._closed = False
        self._file = _create(self._path)
        self._writer = Writer(
            self._file, chunk_size=chunk_size, compression=_COMPRESSIONS[compression], enable_data_crcs=True
        )
        self._begin(header)

    @staticmethod
    def of(path: Path | str, header: Header, config: LogConfig) -> Recorder:
        """Open a log as the configuration says."""
        return Recorder(path, header, config.compression)

    def check(self, stamp_ns: int) -> None:
        """Raise LogError for a stamp that no log can hold: one before the last, or none of 64 bits."""
        if not 0 <= stamp_ns < 1 << 63:
            raise LogError(f"{self._path}: {stamp_ns} is no stamp in nanoseconds")
        if self._stamp is not None and stamp_ns < self._stamp:
            raise LogError(f"{self._path}: stamps run backwards, {stamp_ns} after {self._stamp}")

    def write(self, stamp_ns: int, topic: str, record: object) -> None:
        """Write one record; raises LogError for stamps that run backwards, a wrong record or a full disk."""
        if type(record) is not TOPICS[topic]:
            raise LogError(f"{topic} carries {TOPICS[topic].__name__}, not {type(record).__name__}")
        if stamp_ns != self._stamp:
            self.check(stamp_ns)
            self._next_step(stamp_ns)
        own = type(record) in codec.MESSAGES
        data = codec.encode(record) if own else foxglove.encode(record, stamp_ns)
        try:
            self._writer.add_message(self._channel(topic), stamp_ns, data, stamp_ns)
        except OSError as error:
            raise self._failed(error) from error

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        """Attach a file, such as the finished map, after what was written so far."""
        try:
            self._writer.flush()
            self._writer.add_attachment(0, self._stamp or 0, name, media_type, data)
        except OSError as error:
            raise self._failed(error) from error

    def flush(self) -> None:
        """Hand everything written so far to the operating system, and to the disk if a second has passed."""
        now = time.monotonic_ns()
        try:
            self._writer.flush()
            if now - self._synced_at >= _FSYNC_SECONDS * 1e9:
                os.fsync(self._file.fileno())
                self._synced_at = time.monotonic_ns()
        except OSError as error:
            raise self._failed(error) from error
        self._flushed_at = now

    def close(self) -> None:
        """Write the index and close the file; does nothing the second time."""
        if self._closed:
            return
        self._closed = True
        try:
            self._writer.finish()
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as error:
            raise self._failed(error) from error
        finally:
            with suppress(OSError):  # closing writes what is left once more, and fails once more
                self._file.close()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _begin(self, header: Header) -> None:
        try:
            self._writer.start("", "topomap")
            self._writer.add_metadata(head.RUN, header.run())
            self._writer.add_metadata(head.VERSIONS, dict(sorted(header.versions.items())))
            self._writer.add_attachment(0, 0, head.CONFIG, "application/json", header.config.encode())
            self._writer.add_attachment(0, 0, head.PLAN, "application/json", header.plan_json())
            self._writer.add_attachment(0, 0, head.WHOLE, "application/json", header.whole_json())
            self._file.flush()
            os.fsync(self._file.fileno())
            _sync_folder(self._path.parent)
        except OSError as error:
            with suppress(OSError):  # as in `close`
                self._file.close()
            raise self._failed(error) from error

    def _next_step(self, stamp_ns: int) -> None:
        """Flush between two steps, never inside one, so that a chunk holds whole steps."""
        if self._stamp is None:
            self._waiting_stamp = stamp_ns
        elif max(stamp_ns - self._waiting_stamp, time.monotonic_ns() - self._flushed_at) >= self._flush_ns:
            self.flush()
            self._waiting_stamp = stamp_ns
        self._stamp = stamp_ns

    def _channel(self, topic: str) -> int:
        if topic not in self._channels:
            schema = self._schema(TOPICS[topic])
            self._channels[topic] = self._writer.register_channel(topic, "protobuf", schema)
        return self._channels[topic]

    def _schema(self, record: type) -> int:
        if record not in self._schemas:
            message = codec.MESSAGES[record] if record in codec.MESSAGES else foxglove.MESSAGES[record]
            data = build_file_descriptor_set(message).SerializeToString(deterministic=True)
            name = message.DESCRIPTOR.full_name
            self._schemas[record] = self._writer.register_schema(name, "protobuf", data)
        return self._schemas[record]

    def _failed(self, error: OSError) -> LogError:
        return LogError(f"{self._path}: writing failed ({error.strerror})")


def _create(path: Path) -> IO[bytes]:
    try:
        number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)
    except OSError as error:
        link = error.errno == errno.ELOOP
        why = "it is a symbolic link, which isn't followed" if link else error.strerror
        raise LogError(f"{path}: can't be written ({why})") from error
    return os.fdopen(number, "wb")


def _sync_folder(folder: Path) -> None:
    """See that a new file's name is on the disk as well; where a folder can't be synced there is nothing to do."""
    with suppress(OSError):
        number = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)
