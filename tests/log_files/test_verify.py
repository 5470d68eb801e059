"""Whether a log says what it lacks: flipped bits, cut tails, bombs and links, as an attacker or a disk makes them."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
import zstandard
from kept import as_before
from log_samples import EPOCH, STEP, header, write_log, write_step
from mcap.opcode import Opcode
from mcap.writer import Writer

from logs import budget, scan, topics
from logs import records as log
from logs.contents import data_checksum, from_index
from logs.errors import LogError
from logs.header import Header
from logs.image_size import image_size
from logs.info import info
from logs.mcap_file import McapFile
from logs.pieces import MAGIC
from logs.reader import LogReader
from logs.recorder import Recorder
from logs.recover import recover
from logs.replay import ReplayRobot, decoded
from logs.schemas import codec, foxglove
from logs.schemas.wire import too_many_fields


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("whole") / "run.mcap"
    write_log(path, 8, chunk_size=4096)
    return path.read_bytes()


def flipped(data: bytes, bit: int) -> bytes:
    return data[: bit // 8] + bytes([data[bit // 8] ^ 1 << bit % 8]) + data[bit // 8 + 1 :]


def stamps(path: Path) -> list[int]:
    with LogReader(path, skip_damaged=True) as reader:
        return [stamp for stamp, _ in reader.records(topics.ODOMETRY, log.Odometry)]


def test_a_whole_log_is_called_whole(tmp_path: Path, whole: bytes) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(whole)
    assert info(path).state.whole
    assert info(path).state.note == ""
    assert recover(path, tmp_path / "copy.mcap").state.whole
    assert info(tmp_path / "copy.mcap").state.whole


def test_no_flipped_bit_is_overlooked_and_none_is_fatal(tmp_path: Path, whole: bytes) -> None:
    """Of every bit that is flipped the log says so, keeps its header and all steps but those of one chunk."""
    path = tmp_path / "run.mcap"
    rng = np.random.default_rng(0)
    places = [*range(0, 64, 7), *rng.integers(64, 8 * 5000, 60).tolist(), *rng.integers(0, 8 * len(whole), 60).tolist()]
    for bit in places:
        path.write_bytes(flipped(whole, bit))
        found = info(path)
        assert not found.state.whole, bit
        assert found.state.word in ("damaged", "cut off")
        assert found.header == header()
        assert len(stamps(path)) >= 6


def test_a_cut_and_flipped_log_is_read_on_behind_the_damage(tmp_path: Path, whole: bytes) -> None:
    """Without an index, the length of every record in turn is damaged: only that record's steps are lost."""
    path = tmp_path / "run.mcap"
    path.write_bytes(whole)
    with LogReader(path) as reader:
        offsets = [chunk.offset for chunk in reader.file.contents.chunks]
        offsets += [offset for _, offset in reader.file.contents.metadata + reader.file.contents.attachments]
    for offset in offsets:
        path.write_bytes(flipped(whole, 8 * (offset + 1) + 13)[:-40])
        found = info(path)
        assert found.state.word == "damaged", offset
        assert found.header == header(), "stored twice"
        assert len(stamps(path)) >= 5, offset


@pytest.mark.parametrize("cut", [1, 8, 9, 30, 200])
def test_a_cut_tail_is_said(tmp_path: Path, whole: bytes, cut: int) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(whole[:-cut])
    assert info(path).state.word == "cut off"
    assert len(stamps(path)) == 8


def test_a_repaired_log_says_what_it_was_repaired_from(tmp_path: Path, whole: bytes) -> None:
    path, target, again = (tmp_path / name for name in ("run.mcap", "repaired.mcap", "again.mcap"))
    path.write_bytes(whole)
    with LogReader(path) as reader:
        middle = reader.file.contents.chunks[1].offset + 100
    path.write_bytes(whole[:middle] + bytes(8) + whole[middle + 8 :])
    saved = recover(path, target)
    assert (saved.damaged, saved.state.word) == (1, "damaged")
    assert info(target).complete, "viewers take it"
    assert info(target).state.word == "recovered"
    assert "1 of its chunks can't be read and is left out" in info(target).state.note
    assert recover(target, again).state.word == info(again).state.word == "recovered"


def test_a_repaired_log_keeps_the_schemas_of_its_messages(tmp_path: Path, whole: bytes) -> None:
    path, target = tmp_path / "run.mcap", tmp_path / "copy.mcap"
    path.write_bytes(whole)
    recover(path, target)

    def told(file: Path) -> list[tuple[str, str, int]]:
        with LogReader(file) as reader:
            return [(item.topic, item.schema, item.stamp_ns) for item in reader.file.items()]

    assert told(target) == told(path)
    assert all(schema for _, schema, _ in told(target))


def test_a_repair_that_fails_leaves_nothing_behind(
    tmp_path: Path, whole: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, target = tmp_path / "run.mcap", tmp_path / "repaired.mcap"
    path.write_bytes(whole)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Writer, "finish", full)
    with pytest.raises(LogError, match="No space left"):
        recover(path, target)
    assert not target.exists()


def test_a_file_without_checksums_is_unverified(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    with path.open("wb") as file:
        writer = Writer(file, enable_crcs=False)
        writer.start("", "")
        channel = writer.register_channel("/a", "", writer.register_schema("a", "", b""))
        writer.add_message(channel, 1, b"data", 1)
        writer.finish()
    with McapFile(path) as opened:
        assert opened.state.word == "unverified"
        assert [item.data for item in opened.items()] == [b"data"]


def test_a_log_of_the_first_house_has_no_doubts() -> None:
    assert info(Path(__file__).parents[1] / "golden" / "first-house.mcap").state.whole


def test_replay_leaves_out_readings_that_damage_took(tmp_path: Path, whole: bytes) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(whole)
    with LogReader(path) as reader:
        middles = [chunk.offset + 100 for chunk in reader.file.contents.chunks]
    counts = []
    for middle in middles:
        path.write_bytes(whole[:middle] + bytes(8) + whole[middle + 8 :])
        robot = ReplayRobot(path, skip_damaged=True)
        counts.append(0)
        while (reading := robot.sense()) is not None:
            assert reading.ranges is not None
            counts[-1] += 1
        assert robot.state.word == "damaged"
    assert min(counts) < 8
    assert sum(8 - count for count in counts) >= 8, "each reading lies in one of the chunks at least"
    assert min(counts) >= 5


def chunk_record(records: bytes, size: int | None = None, compression: str = "zstd") -> bytes:
    """A chunk that says that it unpacks to `size` bytes."""
    data = zstandard.compress(records) if compression == "zstd" else records
    name = compression.encode()
    content = struct.pack("<QQQII", 1, 1, len(records) if size is None else size, zlib.crc32(records), len(name))
    content += name + struct.pack("<Q", len(data)) + data
    return struct.pack("<BQ", 6, len(content)) + content


def message(data: bytes) -> bytes:
    content = struct.pack("<HIQQ", 1, 0, 1, 1) + data
    return struct.pack("<BQ", 5, len(content)) + content


CHANNEL = struct.pack("<BQ", 4, 2 + 2 + 4 + 2 + 4 + 4) + struct.pack("<HHI", 1, 0, 2) + b"/a" + struct.pack("<II", 0, 0)


@pytest.mark.parametrize("size", [None, 100, 1 << 40])
def test_a_chunk_that_unpacks_to_gigabytes_is_damaged_before_memory_is_taken(tmp_path: Path, size: int | None) -> None:
    """200 MB of zeros in some kB, whatever the chunk says of them."""
    path = tmp_path / "bomb.mcap"
    sound = chunk_record(CHANNEL + message(b"x"))
    bomb = chunk_record(message(bytes(200_000_000)), size)
    path.write_bytes(MAGIC + bomb + sound)
    with McapFile(path, skip_damaged=True) as opened:
        assert opened.contents.damaged == 1
        assert [item.data for item in opened.items()] == [b"x"]


def test_many_chunks_that_each_unpack_to_much_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "bombs.mcap"
    path.write_bytes(MAGIC + chunk_record(CHANNEL + message(bytes(50_000_000))) * 3)
    with pytest.raises(LogError, match="unpack to more than any log of its size") as caught:
        McapFile(path, skip_damaged=True)
    assert str(path) in str(caught.value)


def test_more_messages_than_bytes_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "crumbs.mcap"
    path.write_bytes(MAGIC + chunk_record(CHANNEL + message(b"") * 200_000))
    with pytest.raises(LogError, match="unpack to more"):
        McapFile(path, skip_damaged=True)


def test_a_budget_is_spent_to_the_last_byte_and_message() -> None:
    assert budget.Budget.of(1000) == budget.Budget(64_200_000, 10_250)
    assert budget.gathered_limit(10) == 64_000_040
    left = budget.Budget(5, 2)
    left.take(3, 1)
    left.take(2, 1)
    for count, messages in ((1, 0), (0, 1)):
        with pytest.raises(LogError, match="unpack to more"):
            budget.Budget(0, 0).take(count, messages)


@pytest.mark.parametrize("block", [1 << 20, 700])
def test_every_damage_is_told_as_before(
    tmp_path: Path, whole: bytes, block: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A byte changed in every kind of record, and cuts: what is said, and how much is left."""
    monkeypatch.setattr(scan, "BLOCK", block)
    path = tmp_path / "run.mcap"
    path.write_bytes(whole)
    with path.open("rb") as file:
        contents = from_index(file)
        assert contents is not None
        assert contents.checksum == zlib.crc32(whole[: contents.end]) == data_checksum(file, contents.end)
    assert whole[contents.end] == Opcode.DATA_END
    chunks = [entry.offset for entry in contents.chunks]
    places = {f"chunk {k}": offset + 60 for k, offset in enumerate(chunks)}
    places |= {f"length of chunk {k}": offset + 3 for k, offset in enumerate(chunks[::3])}
    places |= {f"attachment {name}": offset + 50 for name, offset in contents.attachments}
    places |= {f"metadata {name}": offset + 20 for name, offset in contents.metadata}
    places |= {
        "summary": contents.end + 40,
        "footer": len(whole) - 20,
        "magic": len(whole) - 3,
    }
    cuts = {f"cut in chunk {k}": whole[: offset + 100] for k, offset in enumerate(chunks)}
    cuts |= {"cut in the summary": whole[: contents.end + 30], "cut in the footer": whole[:-12]}
    told = {}
    for name, data in [*((name, flipped(whole, 8 * at)) for name, at in places.items()), *cuts.items()]:
        path.write_bytes(data)
        with McapFile(path, skip_damaged=True) as log_file:
            steps = sum(1 for _ in log_file.items((topics.ODOMETRY,)))
            count = len(log_file.contents.chunks)
            told[name] = [log_file.state.word, log_file.state.note, f"{count} chunks, {steps} steps"]
    as_before("damage", told)


def test_no_bit_between_the_data_and_the_index_is_overlooked(tmp_path: Path, whole: bytes) -> None:
    """The record that holds the checksum is itself in no checksum."""
    path = tmp_path / "run.mcap"
    path.write_bytes(whole)
    with path.open("rb") as file:
        contents = from_index(file)
    assert contents is not None
    for bit in range(8 * contents.end, 8 * (contents.end + 13)):
        path.write_bytes(flipped(whole, bit))
        with McapFile(path, skip_damaged=True) as log_file:
            assert not log_file.state.whole, bit - 8 * contents.end


def test_what_is_kept_of_a_log_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run.mcap"
    write_log(path, 8)
    monkeypatch.setattr(budget, "SPARE_BYTES", 0)
    monkeypatch.setattr(budget, "GATHERED_RATIO", 0)
    with LogReader(path) as reader, pytest.raises(LogError, match="larger than any log"):
        reader.gather((topics.ODOMETRY,))


def test_a_record_of_millions_of_values_is_refused() -> None:
    crumbs = b"\x1a\x00" * 1_100_000  # empty nodes of a finished map
    with pytest.raises(LogError, match="holds more than 1000000 values"):
        codec.decode(log.Final, crumbs)
    assert not too_many_fields(codec.encode(log.Final((1,) * 50, (0.5,) * 150, (), (), None, "", None, None)), 60)
    assert too_many_fields(b"\x1a\x00" * 61, 60)
    assert not too_many_fields(b"\x1a", 60), "what is no message is left to the decoder"


def test_an_image_of_gigapixels_is_refused_by_its_header() -> None:
    png = b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sII", 13, b"IHDR", 30_000, 30_000)
    jpeg = b"\xff\xd8\xff\xe0\x00\x04ab\xff\xff\xc0\x00\x11\x08" + struct.pack(">HH", 30_001, 30_002)
    assert (image_size(png), image_size(jpeg)) == ((30_000, 30_000), (30_002, 30_001))
    for data in (png, jpeg + bytes(9)):
        with pytest.raises(LogError, match="more than any camera's"):
            decoded(data)
    assert image_size(b"GIF89a") is None
    assert image_size(b"\xff\xd8\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00") is None


def test_a_panorama_of_another_size_than_the_rig_says_is_one_line(tmp_path: Path) -> None:
    from log_samples import jpeg, odometry

    rng = np.random.default_rng(0)
    with Recorder(tmp_path / "run.mcap", header()) as recorder:
        recorder.write(EPOCH, topics.PANORAMA, log.Image(jpeg(rng, 20, 72)))
        recorder.write(EPOCH, topics.ODOMETRY, odometry(rng, scanned=False))
    with pytest.raises(LogError, match=r"\(20, 72, 3\), the rig says \(10, 72, 3\)"):
        ReplayRobot(tmp_path / "run.mcap").sense()


def test_a_link_is_not_followed(tmp_path: Path) -> None:
    precious, link = tmp_path / "precious", tmp_path / "run.mcap"
    precious.write_text("mine")
    link.symlink_to(precious)
    with pytest.raises(LogError, match="symbolic link"):
        Recorder(link, header())
    assert precious.read_text() == "mine"


def test_the_log_and_its_name_are_on_the_disk_when_the_header_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    synced: list[str] = []

    def note(number: int) -> None:
        synced.append(Path(f"/proc/self/fd/{number}").resolve().name)

    monkeypatch.setattr("os.fsync", note)
    recorder = Recorder(tmp_path / "run.mcap", header())
    assert synced == ["run.mcap", tmp_path.name]
    with LogReader(tmp_path / "run.mcap") as reader:
        assert reader.header == header()
    recorder.close()
    assert synced == ["run.mcap", tmp_path.name, "run.mcap"]


def test_steps_are_synced_once_a_second_of_wall_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    now, synced = [0], []
    monkeypatch.setattr("time.monotonic_ns", lambda: now[0])
    monkeypatch.setattr("os.fsync", lambda _: synced.append(now[0]))
    rng = np.random.default_rng(0)
    with Recorder(tmp_path / "run.mcap", header()) as recorder:
        synced.clear()
        for i in range(12):
            now[0] = i * 400_000_000
            write_step(recorder, EPOCH + i * STEP, rng)
    assert synced[:-1] == [1_600_000_000, 3_200_000_000]
    assert len(synced) == 3, "and once at the end"


def test_a_stamp_that_no_log_can_hold_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", header()) as recorder:
        recorder.check(0)
        recorder.check((1 << 63) - 1)
        for stamp in (-1, 1 << 63):
            with pytest.raises(LogError, match="is no stamp"):
                recorder.check(stamp)
        recorder.write(5, topics.COMMAND, log.Command(0.0, 0.0))
        recorder.check(5)
        with pytest.raises(LogError, match="run backwards, 4 after 5"):
            recorder.check(4)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("errors", '{"rotation_scale": "much"}'),
        ("start", '{"x": [], "y": 0, "heading": 0}'),
        ("rig", "[1]"),
        ("seed", '"seven"'),
        ("format", "9"),
    ],
)
def test_a_header_of_other_values_is_one_line(
    tmp_path: Path, name: str, value: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, run = tmp_path / "run.mcap", Header.run
    monkeypatch.setattr(Header, "run", lambda self: run(self) | {name: value})
    Recorder(path, header()).close()
    with pytest.raises(LogError, match="its header can't be read") as caught:
        LogReader(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_without_the_copy_the_header_is_read_in_parts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As in logs of the first house."""
    path, attach = tmp_path / "run.mcap", Writer.add_attachment

    def without(self: Writer, *values: object) -> None:
        if "header.json" not in values:
            attach(self, *values)

    monkeypatch.setattr(Writer, "add_attachment", without)
    write_log(path, 2)
    with LogReader(path) as reader:
        assert reader.attachment("header.json") is None
        assert reader.header == header()


def test_what_viewers_know_is_refused_in_one_line_too() -> None:
    for decode in (foxglove.decode_image, foxglove.decode_scan, foxglove.decode_text):
        with pytest.raises(LogError, match="can't be decoded"):
            decode(b"\xff\xff")


def test_a_jpegs_size_stands_behind_any_number_of_tables() -> None:
    """Real ones, as OpenCV writes them, and every kind of frame header; tables look alike and hold none."""
    real = cv2.imencode(".jpg", np.zeros((33, 57, 3), np.uint8))[1].tobytes()
    assert image_size(real) == (57, 33)
    assert image_size(cv2.imencode(".png", np.zeros((33, 57, 3), np.uint8))[1].tobytes()) == (57, 33)
    assert image_size(real[:100]) is None
    for start in (b"\xff\xd8", b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff\xc0\0\x08\x08\0\x01\0", b"GIF89a"):
        assert image_size(start) is None, start
    assert image_size(b"\xff\xd8\xff\xc0\0\x08\x08\0\x01\0\x02") == (2, 1)
    for mark in range(0xC0, 0xD0):
        table = b"\xff\xc4\x00\x09" + struct.pack(">xHH", 1, 2) + b"\0\0"
        frame = bytes([0xFF, mark]) + struct.pack(">HBHH", 8, 8, 300, 400) + b"\0"
        sized = mark not in (0xC4, 0xC8, 0xCC)
        assert image_size(b"\xff\xd8\xff\xd0" + table + frame + bytes(9)) == ((400, 300) if sized else None), hex(mark)
