"""What the recorder writes reads back, in order, under the names that viewers know."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from log_samples import EPOCH, STEP, header, jpeg, odometry, write_log, write_step
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from logs import mcap_file, topics
from logs import records as log
from logs.config import LogConfig
from logs.errors import LogError
from logs.info import info
from logs.reader import LogReader
from logs.recorder import Recorder

SCHEMAS = {
    "/panorama": "foxglove.CompressedImage",
    "/ranges": "foxglove.LaserScan",
    "/ranges/points": "foxglove.PointCloud",
    "/odometry": "topomap.Odometry",
    "/truth": "topomap.Truth",
    "/pose/true": "foxglove.PoseInFrame",
    "/pose/estimated": "foxglove.PoseInFrame",
    "/pose/dead_reckoning": "foxglove.PoseInFrame",
    "/tf": "foxglove.FrameTransforms",
    "/map/nodes": "foxglove.PosesInFrame",
    "/map/graph": "foxglove.SceneUpdate",
    "/log": "foxglove.Log",
}
POSES = np.array([[0.0, 0.0, 0.0], [1.0, 0.5, 0.2], [2.0, 1.0, -0.4]])
PAIRS = np.array([[0, 1], [1, 2]])


def _every_viewer_record() -> dict[str, object]:
    rng, pose = np.random.default_rng(1), log.Pose(1.0, 2.0, 0.5)
    return {
        "/panorama": log.Image(jpeg(rng)),
        "/ranges": log.Scan(rng.random(72).astype(np.float32)),
        "/ranges/points": log.Points(rng.random((5, 2)).astype(np.float32)),
        "/odometry": odometry(rng),
        "/truth": log.Truth(EPOCH, 1.0, 2.0, 0.5, False),
        "/pose/true": log.FramedPose("world", pose),
        "/pose/estimated": log.FramedPose("map", pose),
        "/pose/dead_reckoning": log.FramedPose("map", pose),
        "/tf": log.Transforms((log.Transform("map", "odom", pose),)),
        "/map/nodes": log.NodePoses(POSES),
        "/map/graph": log.Graph(POSES, np.array([True, False, True]), PAIRS, PAIRS[:1]),
        "/log": log.Text(log.Level.WARNING, "robot", "contact"),
    }


def test_schema_names_and_contents_as_any_mcap_reader_sees_them(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with Recorder(path, header()) as recorder:
        for topic, record in _every_viewer_record().items():
            recorder.write(EPOCH, topic, record)
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        rows = {c.topic: (s.name, m) for s, c, _, m in reader.iter_decoded_messages()}
    assert {topic: name for topic, (name, _) in rows.items()} == SCHEMAS
    assert rows["/panorama"][1].format == "jpeg"
    assert rows["/tf"][1].transforms[0].child_frame_id == "odom"
    assert rows["/tf"][1].transforms[0].rotation.z == pytest.approx(np.sin(0.25))
    assert rows["/ranges"][1].end_angle == pytest.approx(2 * np.pi * 71 / 72)
    entity = rows["/map/graph"][1].entities[0]
    assert [len(line.points) for line in entity.lines] == [4, 2]
    assert len(entity.spheres) == 2
    assert len(rows["/map/nodes"][1].poses) == 3
    assert rows["/log"][1].level == 3
    assert rows["/odometry"][1].covariance[:] == list(odometry_of(path).covariance)
    assert rows["/panorama"][1].timestamp.ToNanoseconds() == EPOCH


def odometry_of(path: Path) -> log.Odometry:
    with LogReader(path) as reader:
        return next(reader.records(topics.ODOMETRY, log.Odometry))[1]


def test_the_header_reads_back_equal(tmp_path: Path) -> None:
    write_log(tmp_path / "run.mcap", 1)
    with LogReader(tmp_path / "run.mcap") as reader:
        assert reader.header == header()
        assert reader.complete


def test_a_log_of_another_format_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("logs.header.FORMAT", "2")
    write_log(tmp_path / "run.mcap", 1)
    monkeypatch.undo()
    with pytest.raises(LogError, match=r"run.mcap: its header can't be read \(log format 2, this version reads 1\)"):
        LogReader(tmp_path / "run.mcap")


def test_records_and_stamps_read_back_in_order(tmp_path: Path) -> None:
    steps = write_log(tmp_path / "run.mcap", 12, chunk_size=4096)
    with LogReader(tmp_path / "run.mcap") as reader:
        assert len(reader.file.contents.chunks) > 3
        rows = list(reader.records(topics.ODOMETRY, log.Odometry))
        stamps = [item.stamp_ns for item in reader.file.items()]
        schemas = {item.topic: item.schema for item in reader.file.items()}
        third = reader.panorama(EPOCH + 3 * STEP)
    assert [record for _, record in rows] == [step[topics.ODOMETRY] for step in steps]
    assert [stamp for stamp, _ in rows] == [EPOCH + i * STEP for i in range(12)]
    assert stamps == sorted(stamps)
    assert schemas[topics.PANORAMA] == "foxglove.CompressedImage"
    assert schemas[topics.ODOMETRY] == "topomap.Odometry"
    assert log.Image(third or b"") == steps[3][topics.PANORAMA]


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
def test_every_compression_reads_back(tmp_path: Path, compression: str) -> None:
    config = LogConfig.model_validate({"compression": compression})
    rng = np.random.default_rng(0)
    with Recorder.of(tmp_path / "run.mcap", header(), config) as recorder:
        step = write_step(recorder, EPOCH, rng)
    assert odometry_of(tmp_path / "run.mcap") == step[topics.ODOMETRY]


def test_same_input_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_log(tmp_path / name, 5)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_only_chunks_of_the_wanted_time_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_log(tmp_path / "run.mcap", 20, chunk_size=1)
    read: list[int] = []
    chunk = mcap_file._chunk
    monkeypatch.setattr(mcap_file, "_chunk", lambda file, at, budget: read.append(at) or chunk(file, at, budget))
    low, high = EPOCH + 5 * STEP, EPOCH + 7 * STEP
    with LogReader(tmp_path / "run.mcap") as reader:
        found = [item.stamp_ns for item in reader.file.items([topics.ODOMETRY], low, high)]
    assert found == [low, low + STEP, high]
    assert len(read) == 3


def test_close_twice_and_attach(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "run.mcap", header())
    recorder.attach("map.zip", "application/zip", b"a map")
    recorder.close()
    size = (tmp_path / "run.mcap").stat().st_size
    recorder.close()
    assert (tmp_path / "run.mcap").stat().st_size == size
    with LogReader(tmp_path / "run.mcap") as reader:
        assert reader.attachment("map.zip") == b"a map"
        assert reader.attachment("other") is None
        kept = reader.file
    with (tmp_path / "run.mcap").open("rb") as file:
        times = [(one.create_time, one.log_time) for one in make_reader(file).iter_attachments()]
    assert times == [(0, 0)] * 4, "no clock but the run's"
    with pytest.raises(ValueError, match="closed file"):
        list(kept.items())


def test_a_pose_is_the_origin_unless_it_says_otherwise() -> None:
    assert [getattr(log.Pose(), name) for name in ("x", "y", "heading")] == [0.0, 0.0, 0.0]


def test_steps_are_readable_before_the_log_is_closed(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    with Recorder(tmp_path / "run.mcap", header()) as recorder:
        for i in range(20):
            write_step(recorder, EPOCH + i * STEP, rng)
            if i:
                with LogReader(tmp_path / "run.mcap") as reader:
                    read = sum(1 for _ in reader.records(topics.ODOMETRY, log.Odometry))
                assert not reader.complete
                assert i + 1 - read <= 2  # half a second


def test_an_unwritable_path_is_one_clear_line(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "missing" / "run.mcap"):
        with pytest.raises(LogError, match="can't be written") as caught:
            Recorder(path, header())
        assert str(path) in str(caught.value)
        assert "\n" not in str(caught.value)


def test_a_full_disk_is_a_log_error() -> None:
    with pytest.raises(LogError, match="No space left"):
        Recorder("/dev/full", header())


def test_wrong_records_are_refused(tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", header()) as recorder:
        recorder.write(EPOCH, topics.COMMAND, log.Command(0.1, 0.2))
        with pytest.raises(LogError, match="carries Odometry"):
            recorder.write(EPOCH, topics.ODOMETRY, log.Command(0.1, 0.2))
        with pytest.raises(LogError, match="run backwards"):
            recorder.write(EPOCH - 1, topics.COMMAND, log.Command(0.1, 0.2))
        with pytest.raises(LogError, match="neither JPEG nor PNG"):
            recorder.write(EPOCH, topics.PANORAMA, log.Image(b"GIF89a"))


def test_every_topic_has_a_record_that_can_be_stored() -> None:
    from logs.schemas import codec, foxglove

    stored = codec.MESSAGES.keys() | foxglove.MESSAGES.keys()
    assert all(kind in stored and dataclasses.is_dataclass(kind) for kind in topics.TOPICS.values())


def test_info_counts(tmp_path: Path) -> None:
    write_log(tmp_path / "run.mcap", 9)
    summary = info(tmp_path / "run.mcap")
    assert (summary.steps, summary.messages, summary.complete) == (9, 36, True)
    assert summary.duration_s == pytest.approx(8 * 0.25)
    assert ("/panorama", "foxglove.CompressedImage", 9) in [dataclasses.astuple(t) for t in summary.topics]
    assert summary.attachments == ("config.json", "plan.json", "header.json")
    assert summary.header.world == "test-room"
