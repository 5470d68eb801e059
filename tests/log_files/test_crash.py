"""Killed, cut off and damaged logs: nothing but the last second is lost, and nothing but LogError is raised."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from log_samples import EPOCH, STEP, write_log

from logs import records as log
from logs import topics
from logs.errors import LogError
from logs.info import info
from logs.reader import LogReader
from logs.recover import recover
from logs.replay import ReplayRobot

ROOT = Path(__file__).resolve().parents[2]


def _stamps(path: Path) -> list[int]:
    with LogReader(path, skip_damaged=True) as reader:
        return [stamp for stamp, _ in reader.records(topics.ODOMETRY, log.Odometry)]


def _replay(path: Path) -> None:
    robot = ReplayRobot(path)
    while robot.sense() is not None:
        pass
    robot.close()


def _recover(path: Path) -> None:
    target = path.with_name("recovered.mcap")
    target.unlink(missing_ok=True)
    recover(path, target)


def _complaint(use: Callable[[Path], object], path: Path) -> str:
    """Return what a use of a log says is wrong, nothing when all is well; other errors are for the test."""
    try:
        use(path)
    except LogError as error:
        return str(error)
    return ""


USES = (_stamps, info, _replay, _recover)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("whole") / "run.mcap"
    write_log(path, 8, chunk_size=4096)
    return path.read_bytes()


def test_sigkill_loses_at_most_the_last_second(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    environment = os.environ | {"PYTHONPATH": f"{ROOT}{os.pathsep}{Path(__file__).parent}"}
    command = [sys.executable, str(Path(__file__).with_name("paced_writer.py")), str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment, text=True) as writer:
        assert writer.stdout is not None
        writer.stdout.readline()  # the first step is written
        time.sleep(3.0)
        writer.send_signal(signal.SIGKILL)
        written = int(writer.stdout.read().split("\n")[-2]) + 1
    stamps = _stamps(path)
    assert written > 30
    assert written - len(stamps) <= 20
    assert stamps == [EPOCH + i * 50_000_000 for i in range(len(stamps))]
    assert not info(path).complete


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(share=st.floats(0.0, 1.0))
def test_cut_off_anywhere(tmp_path: Path, whole: bytes, share: float) -> None:
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole[: int(share * len(whole))])
    messages = [message for use in USES if (message := _complaint(use, path))]
    assert all(str(path) in message and "\n" not in message for message in messages)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=st.floats(0.0, 0.999), length=st.integers(1, 40), value=st.integers(0, 255))
def test_damaged_anywhere(tmp_path: Path, whole: bytes, place: float, length: int, value: int) -> None:
    path, start = tmp_path / "damaged.mcap", int(place * len(whole))
    path.write_bytes((whole[:start] + bytes([value] * length) + whole[start + length :])[: len(whole)])
    messages = [message for use in USES if (message := _complaint(use, path))]
    assert all("\n" not in message for message in messages)


def test_a_log_without_its_end_reads_all_but_the_last_chunk(tmp_path: Path, whole: bytes) -> None:
    full, cut = tmp_path / "full.mcap", tmp_path / "cut.mcap"
    full.write_bytes(whole)
    with LogReader(full) as reader:
        last = reader.file.contents.chunks[-1]
    cut.write_bytes(whole[: last.offset + 20])
    assert _stamps(cut) == [stamp for stamp in _stamps(full) if stamp < last.start_ns]
    cut.write_bytes(whole[:-1])
    assert _stamps(cut) == _stamps(full)


def test_recover_gives_a_complete_log(tmp_path: Path, whole: bytes) -> None:
    cut, target = tmp_path / "cut.mcap", tmp_path / "recovered.mcap"
    cut.write_bytes(whole[: int(len(whole) * 0.7)])
    saved = recover(cut, target)
    assert (saved.attachments, saved.metadata, saved.damaged) == (3, 2, 0)
    assert saved.messages == info(cut).messages > 0
    assert info(target).complete
    assert _stamps(target) == _stamps(cut)
    with LogReader(target) as new, LogReader(cut) as old:
        assert new.header == old.header
    with pytest.raises(LogError, match="can't be written"):
        recover(cut, target)


def test_a_damaged_chunk_is_noticed_and_left_out_only_on_request(tmp_path: Path, whole: bytes) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(whole)
    with LogReader(path) as reader:
        first, second = reader.file.contents.chunks[:2]
    middle = (first.offset + second.offset) // 2
    path.write_bytes(whole[:middle] + bytes(8) + whole[middle + 8 :])
    with pytest.raises(LogError, match="damaged"), LogReader(path) as reader:
        list(reader.file.items())
    assert _stamps(path)[-1] == EPOCH + 7 * STEP
    assert recover(path, tmp_path / "recovered.mcap").damaged == 1


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (None, "No such file"),
        (b"", "cut off before its first record"),
        (b"\x89MCAP", "cut off before its first record"),
        (b"#!/bin/sh\n", "not an MCAP file"),
        (b"\x89MCAP0\r\n", "not a log of topomap"),
    ],
)
def test_what_is_no_log_says_so(tmp_path: Path, content: bytes | None, what: str) -> None:
    path = tmp_path / "x.mcap"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(LogError, match=what) as caught:
        LogReader(path)
    assert str(path) in str(caught.value)


def test_a_directory_is_no_log(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="can't be read"):
        LogReader(tmp_path)


def test_a_cut_off_log_whose_first_chunk_is_damaged_is_refused_not_misread(tmp_path: Path, whole: bytes) -> None:
    path, target = tmp_path / "run.mcap", tmp_path / "recovered.mcap"
    path.write_bytes(whole)
    with LogReader(path) as reader:
        first, second = reader.file.contents.chunks[:2]
    middle = (first.offset + second.offset) // 2
    path.write_bytes((whole[:middle] + bytes(8) + whole[middle + 8 :])[:-40])
    assert len(_stamps(path)) < 8
    with pytest.raises(LogError, match="damaged"):
        _replay(path)
    assert recover(path, target).damaged >= 1
