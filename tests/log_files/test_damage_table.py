"""Every record of a log damaged in every way, and logs of other writers: what is said and saved is as before."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from kept import as_before
from log_samples import EPOCH, STEP, header
from mcap.opcode import Opcode
from mcap.writer import CompressionType, IndexType, Writer

from logs import topics
from logs.budget import Budget
from logs.contents import data_checksum, from_index
from logs.errors import LogError
from logs.header import Header
from logs.image_size import image_size
from logs.info import info
from logs.mcap_file import McapFile
from logs.pieces import MAGIC, PREFIX, fits, open_chunk, read_by_inner_length, read_record
from logs.reader import LogReader
from logs.recorder import Recorder
from logs.records import Image, Odometry, Scan, Truth
from logs.recover import recover
from logs.replay import ReplayRobot
from logs.scan import MARKS, _next, from_stream
from logs.schemas.wire import _varint, too_many_fields
from logs.verify import RECOVERED

PIXELS = np.arange(72 * 10 * 3, dtype=np.uint8).reshape(10, 72, 3)
PNG = bytes(cv2.imencode(".png", PIXELS)[1].tobytes())


def written(path: Path, compression: str, steps: int = 5) -> Path:
    """A log in which nothing is random, a chunk to each two steps or so."""
    with Recorder(path, header(), compression, chunk_size=2500) as recorder:  # type: ignore[arg-type]
        for k in range(steps):
            stamp = EPOCH + k * STEP
            recorder.write(stamp, topics.PANORAMA, Image(PNG))
            recorder.write(stamp, topics.RANGES, Scan(np.full(72, 1.0 + k, np.float32)))
            recorder.write(stamp, topics.TRUTH, Truth(stamp, 1.0 * k, 2.0, 0.1, True))
            recorder.write(stamp, topics.ODOMETRY, Odometry(0.1, 0.0, 0.05, (1.0,) * 9, 0.25, False, True, True))
    return path


def records(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield where each record begins, its opcode, and where it ends."""
    place = len(MAGIC)
    while place + PREFIX.size <= len(data) - len(MAGIC):
        opcode, length = PREFIX.unpack_from(data, place)
        yield place, opcode, place + PREFIX.size + length
        place += PREFIX.size + length


def damages(data: bytes) -> Iterator[tuple[str, bytes]]:
    """Yield the log damaged in one way after the other, each with its name: of each kind the first and last record."""
    places = list(records(data))
    ends = {kind: [k for k, one in enumerate(places) if one[1] == kind] for kind in {one[1] for one in places}}
    for k, (start, opcode, end) in enumerate(places):
        if k not in (ends[opcode][0], ends[opcode][-1]):
            continue
        name = f"{k} {Opcode(opcode).name.lower()}"
        content = start + PREFIX.size
        for what, place, flip in (
            ("opcode", start, 0x40), ("none", start, opcode), ("length", start + 1, 0x01), ("huge", start + 6, 0x20),
            ("first", content, 0x01), ("inner", min(content + 28, end - 1), 0x01), ("last", end - 1, 0x80),
        ):  # fmt: skip
            yield f"{name} {what}", data[:place] + bytes([data[place] ^ flip]) + data[place + 1 :]
        for what, place in (("before", start), ("short", end - 1)):
            yield f"{name} cut {what}", data[:place]
        yield f"{name} gone", data[:start] + data[end:]
    for k in (1, 3, 6, len(MAGIC), len(MAGIC) + 5):
        yield f"only {k}", data[:k]
    yield "magic", data[:1] + b"N" + data[2:]
    yield "other magic", b"\x00" * 3 + data[3:]
    yield "end magic", data[:-1] + b"x"


def said(path: Path, do: Callable[[], object]) -> str:
    try:
        return str(do()).replace(str(path.parent), "")
    except LogError as error:
        return f"LogError {error}".replace(str(path.parent), "")


def told(path: Path) -> list[str]:
    """What is known of a log, how much can be read, and what is saved of it."""

    def opened(skip: bool) -> str:
        with McapFile(path, skip_damaged=skip) as file:
            there = file.contents
            items = sum(1 for _ in file.items())
            some = sum(1 for _ in file.items((topics.TRUTH,), EPOCH + STEP, EPOCH + 3 * STEP))
            counts = f"{there.complete} {there.damaged} {sum(there.counts.values())} {len(there.chunks)}"
            return f"{file.state} {counts} {items} {some} {len(there.attachments)} {len(there.metadata)}"

    def read() -> str:
        with LogReader(path, skip_damaged=True) as log:
            return f"{log.header == header()} {len(log.gather((topics.TRUTH,)).rows[topics.TRUTH])} {log.complete}"

    def played() -> str:
        robot = ReplayRobot(path, skip_damaged=True)
        count = sum(1 for _ in iter(robot.sense, None))
        robot.close()
        return f"{robot.steps} {count}"

    def saved() -> str:
        target = path.with_name("saved.mcap")
        target.unlink(missing_ok=True)
        found = recover(path, target)
        with McapFile(target) as file:
            return f"{found} then {file.state} {sum(1 for _ in file.items())} {file.metadata(RECOVERED)}"

    tolerant, strict = (said(path, lambda skip=skip: opened(skip)) for skip in (True, False))
    return [tolerant, *([strict] if strict != tolerant else []), *(said(path, do) for do in (read, played, saved))]


@pytest.mark.parametrize("part", range(8))
@pytest.mark.parametrize("compression", ["none", "lz4"])
def test_a_log_damaged_anywhere_says_and_saves_as_much_as_before(part: int, compression: str, tmp_path: Path) -> None:
    whole, path = written(tmp_path / "run.mcap", compression).read_bytes(), tmp_path / "bad.mcap"
    found = {}
    for k, (name, data) in enumerate(damages(whole)):
        if k % 8 == part and (compression == "none" or " chunk " in name):
            path.write_bytes(data)
            found[name] = told(path)
    as_before(f"damaged {compression} {part}", found)


def foreign(options: dict[str, object], fill: Callable[[Writer], None]) -> bytes:
    out = io.BytesIO()
    writer = Writer(out, **options)  # type: ignore[arg-type]
    writer.start("", "somebody")
    fill(writer)
    writer.finish()
    return out.getvalue()


def messages(writer: Writer) -> None:
    """Two topics over four seconds, one without a schema."""
    schema = writer.register_schema("a.Kind", "json", b"{}")
    one, two = writer.register_channel("/one", "json", schema), writer.register_channel("/two", "json", 0)
    for k in range(8):
        writer.add_message(one if k % 2 else two, EPOCH + k * STEP, b'{"k": 1}' * 40, EPOCH, k)
    writer.add_metadata("about", {"a": "b"})
    writer.add_attachment(5, 6, "note", "text/plain", b"hello")


FOREIGN: dict[str, tuple[dict[str, object], Callable[[Writer], None]]] = {
    "usual": ({"chunk_size": 900}, messages),
    "no sums": ({"chunk_size": 900, "enable_crcs": False}, messages),
    "data sums": ({"chunk_size": 900, "enable_data_crcs": True, "compression": CompressionType.NONE}, messages),
    "no chunks": ({"use_chunking": False}, messages),
    "no index": ({"chunk_size": 900, "index_types": IndexType.NONE}, messages),
    "no statistics": ({"chunk_size": 900, "use_statistics": False}, messages),
    "no summary": ({"chunk_size": 900, "index_types": IndexType.NONE, "use_statistics": False,
                    "repeat_channels": False, "repeat_schemas": False, "use_summary_offsets": False}, messages),
    "nothing": ({}, lambda writer: None),
    "metadata": ({}, lambda writer: writer.add_metadata("about", {})),
}  # fmt: skip


@pytest.mark.parametrize("name", FOREIGN)
def test_other_writers_logs_are_read_as_before(name: str, tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    path.write_bytes(foreign(*FOREIGN[name]))
    rows = told(path)

    def listed() -> str:
        with McapFile(path, skip_damaged=True) as file:
            items = [
                f"{one.topic} {one.schema} {(one.stamp_ns - EPOCH) // STEP} {len(one.data)}" for one in file.items()
            ]
            return f"{items} {file.metadata('about')} {file.attachment('note')} {file.metadata('none')}"

    rows.append(said(path, listed))
    rows.append(said(path, lambda: sorted((type(one).__name__) for one in McapFile(path).everything())))
    as_before("foreign logs", {name: rows}, part=True)


@pytest.mark.parametrize("compression", ["none", "lz4", "zstd"])
def test_a_whole_log_is_as_before_however_it_is_packed(compression: str, tmp_path: Path) -> None:
    path = written(tmp_path / "run.mcap", compression)
    found = info(path)
    rows = [*told(path), str(found.state), str(found.complete), f"{found.damaged} {found.steps} {found.messages}",
            str((found.start_ns - EPOCH) / STEP), str((found.end_ns - EPOCH) / STEP), str(found.duration_s),
            *(str(one) for one in found.topics), *found.attachments, str(found.header == header())]  # fmt: skip
    rows = [row for row in rows if "size" not in row]
    as_before("whole logs", {compression: rows}, part=True)
    with McapFile(path) as file:
        for topic, start, end, count in (
            ((topics.TRUTH,), None, None, 5), (None, None, None, 20), ((), None, None, 0), (("/none",), None, None, 0),
            (None, EPOCH + STEP, EPOCH + STEP, 4), ((topics.TRUTH,), EPOCH + STEP + 1, EPOCH + 4 * STEP, 3),
            (None, None, EPOCH, 4), (None, EPOCH + 4 * STEP, None, 4), (None, EPOCH + 4 * STEP + 1, None, 0),
            (None, 0, EPOCH - 1, 0), (None, 0, 0, 0),
        ):  # fmt: skip
            assert sum(1 for _ in file.items(topic, start, end)) == count, (topic, start, end)
    with LogReader(path) as log:
        assert log.panorama(EPOCH + STEP) == PNG
        assert log.panorama(EPOCH + 1) is None
        assert [stamp for stamp, _ in log.records(topics.TRUTH, Truth)] == [EPOCH + k * STEP for k in range(5)]
        assert [one.x for _, one in log.gather((topics.TRUTH,)).records(topics.TRUTH, Truth)] == [0, 1, 2, 3, 4]


def test_records_are_as_long_as_what_they_hold() -> None:
    def text(*parts: bytes) -> bytes:
        return b"".join(len(one).to_bytes(4, "little") + one for one in parts)

    chunk = bytes(28) + text(b"lz4") + (3).to_bytes(8, "little") + b"abc"
    attached = bytes(16) + text(b"name", b"kind") + (2).to_bytes(8, "little") + b"xy" + bytes(4)
    index = bytes(2) + (16).to_bytes(4, "little") + bytes(16)
    for opcode, content in ((Opcode.CHUNK, chunk), (Opcode.ATTACHMENT, attached), (Opcode.MESSAGE_INDEX, index),
                            (Opcode.METADATA, text(b"name", b"abc")), (Opcode.DATA_END, bytes(4))):  # fmt: skip
        assert fits(opcode, content)
        assert not fits(opcode, content + b"x")
        assert not fits(opcode, content[:-1])
    free = (Opcode.HEADER, Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)
    assert [op for op in Opcode if fits(op, b"any")] == [op for op in Opcode if op in free]


def test_a_record_is_read_where_one_stands_and_its_length_is_asked_of_the_file_first() -> None:
    data = PREFIX.pack(5, 3) + b"abc" + PREFIX.pack(6, 15) + b"short" + PREFIX.pack(0, 0)
    file = io.BytesIO(data)
    assert read_record(file, 0) == (5, b"abc")
    assert read_record(file, PREFIX.size + 3) is None
    assert read_record(file, len(data) - PREFIX.size) is None
    assert read_record(file, len(data) - PREFIX.size + 1) is None
    assert read_record(io.BytesIO(PREFIX.pack(7, 0)), 0) == (7, b"")
    content = bytes(28) + (4).to_bytes(4, "little") + b"zstd" + (40).to_bytes(8, "little") + b"c" * 40
    chunk, message = Opcode.CHUNK, Opcode.MESSAGE
    for opcode, body, found in ((chunk, content, content), (chunk, content[:-1], None), (message, content, None),
                                (chunk, content + b"rest", content)):  # fmt: skip
        told = read_by_inner_length(io.BytesIO(PREFIX.pack(opcode, 1 << 40) + body), 0)
        assert told == (None if found is None else (Opcode.CHUNK, found))


def test_marks_are_found_from_a_place_on_and_across_blocks() -> None:
    mark, back = MARKS[0]
    data = bytes(100) + mark + bytes(40) + MARKS[2][0] + bytes(20)
    file = io.BytesIO(data)
    assert _next(file, 3) == 100 - back
    assert _next(file, 100 - back) == 100 - back
    assert _next(file, 100 - back + 1) == 100 + len(mark) + 40 - MARKS[2][1]
    assert _next(file, 150) is None
    for place in range((1 << 20) - len(mark) - 1, (1 << 20) + 2):
        assert _next(io.BytesIO(bytes(place) + mark + bytes(9)), 0) == place - back


def test_an_index_is_believed_as_far_as_it_can_be(tmp_path: Path) -> None:
    whole = written(tmp_path / "run.mcap", "none").read_bytes()
    footer = len(whole) - len(MAGIC) - 29
    rows = [str(from_index(io.BytesIO(whole)) is not None)]
    for what, place, put in (("opcode", footer, b"\x03"), ("start", footer + 9, struct.pack("<Q", 10)),
                             ("late", footer + 9, struct.pack("<Q", footer)), ("sum", footer + 25, b"\x01"),
                             ("zero sum", footer + 25, bytes(4))):  # fmt: skip
        found = from_index(io.BytesIO(whole[:place] + put + whole[place + len(put) :]))
        rows.append(f"{what} {found is not None}")
    for count in (0, 8, 20, 37, 45, 46):
        rows.append(f"{count} {from_index(io.BytesIO(whole[-count:] if count else b''))}")
    data = bytes(range(256)) * 5000
    for end in (0, 1, 1 << 20, (1 << 20) + 1, len(data), len(data) + 9):
        assert data_checksum(io.BytesIO(data), end) == zlib.crc32(data[:end])
    as_before("log indexes", {"rows": rows})


def test_images_tell_their_size_and_what_is_none_does_not() -> None:
    jpeg = bytes(cv2.imencode(".jpg", PIXELS)[1].tobytes())
    assert image_size(PNG) == image_size(jpeg) == (72, 10)
    assert image_size(PNG[:24]) == (72, 10)
    assert [image_size(one) for one in (PNG[:23], jpeg[:9], b"", b"GIF89a" + bytes(30))] == [None] * 4
    frame = b"\xff\xc0\x00\x11\x08" + struct.pack(">HH", 33, 44)
    for between in (
        b"",
        b"\xff",
        b"\xff\x01",
        b"\xff\xd5",
        b"\xff\xe1\x00\x04ab",
        b"\xff\xc4\x00\x03a",
        b"\xff\xcc\x00\x02",
    ):
        assert image_size(b"\xff\xd8" + between + frame) == (44, 33), between
    assert image_size(b"\xff\xd8" + frame[:-1]) is None
    assert image_size(b"\xff\xd8" + b"\x00" + frame) is None
    assert image_size(b"\xff\xd8" + b"\xff\xcf" + frame[2:]) == (44, 33)


def test_varints_and_values_are_counted_at_their_bounds() -> None:
    assert _varint(b"\x00\xac\x02\x7f", 1) == (300, 3)
    assert _varint(b"\x7f", 0) == (127, 1)
    assert _varint(b"\x80\x80\x01", 0) == (1 << 14, 3)
    two = bytes([1 << 3, 5, 2 << 3 | 2, 2, 9, 9])
    assert [too_many_fields(two, limit) for limit in (0, 1, 2)] == [True, True, False]
    assert not too_many_fields(two[:-2] + b"", 3)
    assert not too_many_fields(b"\x80", 0)


def test_what_a_log_unpacks_to_is_bounded() -> None:
    budget = Budget.of(1000)
    assert (budget.bytes_left, budget.messages_left) == (64_000_000 + 200_000, 10_000 + 250)
    budget.take(64_200_000, 10_250)
    for count, messages_ in ((1, 0), (0, 1)):
        with pytest.raises(LogError, match="its chunks unpack to more"):
            Budget(0, 0).take(count, messages_)
    with pytest.raises(ValueError, match="unpacks to 64000001 bytes"):
        open_chunk(struct.pack("<QQQI", 0, 0, 64_000_001, 0) + bytes(4) + bytes(8), Budget.of(9))
    with pytest.raises(ValueError, match="compression 'odd' isn't known"):
        open_chunk(struct.pack("<QQQI", 0, 0, 0, 0) + b"\x03\0\0\0odd" + bytes(8), Budget.of(9))
    with pytest.raises(ValueError, match="doesn't unpack to the 2 bytes"):
        open_chunk(struct.pack("<QQQI", 0, 0, 2, 0) + bytes(4) + b"\x01" + bytes(7) + b"x", Budget.of(9))
    assert from_stream(io.BytesIO(MAGIC)).damaged == 0


@pytest.mark.parametrize("change", ["format", "world", "rig", "seed", "plan", "start", "versions"])
def test_a_header_that_is_none_is_refused(change: str) -> None:
    whole = header()
    run, versions, plan = whole.run(), dict(whole.versions), whole.plan_json()
    assert Header.of(run, versions, whole.config.encode(), plan) == whole
    assert Header.of_whole(whole.whole_json()) == whole
    bare = Header("a", whole.rig)
    assert Header.of(bare.run(), {}, b"{}", bare.plan_json()) == bare
    if change == "versions":
        assert Header.of(run, {}, b"", plan).versions == {}
        return
    if change == "plan":
        plan = b'{"polylines": [], "circles": [[1, 2]], "labels": []}'
    else:
        run[change] = {"format": "2", "rig": '{"width": "many"}', "start": '{"x": "here"}', "seed": '"ten"'}.get(
            change, "{"
        )
    with pytest.raises((ValueError, KeyError, TypeError)):
        Header.of(run, versions, b"{}", plan)
