"""The TUC format and the corridor."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from drives import laps, write_recording

from topomap.core.errors import DataError
from topomap.core.records import Verdict
from topomap.datasets.tuc.drive import drive_of
from topomap.datasets.tuc.mapping import map_tuc
from topomap.datasets.tuc.recording import read_tuc

HEAD = "odom2 0 0.4 0 0 0.0025 0.0025 0.0001\nodom2 1 0.4 0 0.1 0.0025 0.0025 0.0001\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEAD + "odom2 2 0.4 0\n", "Small_Input.txt:3: 'odom2' needs 7 numbers"),
        (HEAD + "odom2 2 0.4 x 0 1 1 1\n", "Small_Input.txt:3: velocity y: 'x' is no number"),
        (HEAD + "odom2 2 nan 0 0 1 1 1\n", "Small_Input.txt:3: velocity x: 'nan' isn't finite"),
        (HEAD + "odom3 2 1 0 0 1 1 1\n", "Small_Input.txt:3: row 'odom3' is none of"),
        (HEAD + "odom2 0.5 1 0 0 1 1 1\n", "row 3 of 'odom2': time: 0.5 s runs backwards"),
        (HEAD + "odom2 2 1 0 0 1 -1 1\n", "row 3 of 'odom2': a variance is negative"),
        ("loop 1 0 1\n", "at least two rows 'odom2'"),
        (HEAD.splitlines()[0], "at least two rows 'odom2', it has 1"),
        (HEAD + "odom2 2 0 0 inf 1 1 1\n", "Small_Input.txt:3: turn rate: 'inf' isn't finite"),
        (HEAD + "loop nan 0 1\n", "Small_Input.txt:3: time of the query: 'nan' isn't finite"),
        (HEAD + "odom2 1e300 0 0 0 1 1 1\n", "Small_Input.txt:3: time: '1e300' s is no time"),
    ],
)
def test_bad_files_name_line_and_field(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(DataError, match=message):
        read_tuc(write_recording(tmp_path, text))


def test_missing_folder(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no such folder"):
        read_tuc(tmp_path / "nowhere")
    with pytest.raises(DataError, match=r"0 files"):
        read_tuc(tmp_path)


def test_truth_by_row_name_and_clock_restart(tmp_path: Path) -> None:
    truth = "point2 0 1 2 0 0 0 0\npoint2 1 2 2 0 0 0 0\nangle 0 3.1 0\nangle 1 -3.1 0\n"
    recording = read_tuc(write_recording(tmp_path, HEAD, truth))
    assert recording.truth is not None
    at = recording.truth.at(np.array([500_000_000]))[0]
    assert np.allclose(at[:2], [1.5, 2.0])
    assert abs(abs(at[2]) - np.pi) < 1e-6


def test_increments_end_at_named_stamps_too(tmp_path: Path) -> None:
    recording = read_tuc(write_recording(tmp_path, HEAD + "odom2 2 0 0 0 0 0 0\nloop 1.25 0.5 1\n"))
    drive = drive_of(recording)
    assert drive.node_stamps.tolist() == [0, 500_000_000, 1_250_000_000, 2_000_000_000]
    assert drive.way[-1] == pytest.approx(0.8)


def test_small_loop_is_closed_without_truth(tmp_path: Path) -> None:
    text, truth = laps()
    run = map_tuc(read_tuc(write_recording(tmp_path, text + "loop 99999 3 0.5\n")))
    assert run.truth is None
    assert run.calibration is not None
    assert abs(run.calibration.curvature.value - 0.004) < 0.001
    xy = np.array([row.split()[2:4] for row in truth.splitlines()], float)
    assert np.abs(run.final[:, :2] - xy).max() < np.abs(run.dead_reckoning[:, :2] - xy).max() / 4
    verdicts = {(d.candidate.query_ns, d.candidate.match_ns): d for d in run.decisions}
    assert verdicts[99999 * 10**9, 3 * 10**9].reason == "a stamp lies outside the recording"
    assert all(d.verdict is not Verdict.PENDING for d in verdicts.values())


def test_no_candidates_leave_odometry(tmp_path: Path) -> None:
    run = map_tuc(read_tuc(write_recording(tmp_path, HEAD + "odom2 2 0.4 0 0 1 1 1\n")))
    assert np.allclose(run.final, run.dead_reckoning)


@pytest.mark.data
def test_corridor(data_dir: Path) -> None:
    """The mapping doesn't see the truth; it is only used here, to judge."""
    folder = data_dir / "tuc-corridor"
    if not folder.is_dir():
        pytest.skip(f"no TUC corridor at {folder}")
    recording = read_tuc(folder)
    run = map_tuc(recording)
    assert run.truth is not None
    assert recording.truth is not None
    error = run.final[:, :2] - run.truth[:, :2]
    assert _aligned(run.final, run.truth) < 2.2
    assert _aligned(run.dead_reckoning, run.truth) > 50
    assert len(error) == len(recording.stamps_ns)
    last = {(d.candidate.query_ns, d.candidate.match_ns): d for d in run.decisions}
    assert len(last) == len({*zip(recording.query_ns.tolist(), recording.match_ns.tolist(), strict=True)})
    kept = np.array([k for k, d in last.items() if d.verdict is Verdict.ACCEPTED])
    ends = [recording.truth.at(kept[:, n])[:, :2] for n in (0, 1)]
    gap = np.hypot(*(ends[0] - ends[1]).T)
    assert len(kept) > 1500
    assert (gap > 5).sum() == 0
    assert (gap > 2).sum() <= 10


def _aligned(poses: np.ndarray, truth: np.ndarray) -> float:
    a, b = poses[:, :2] - poses[:, :2].mean(axis=0), truth[:, :2] - truth[:, :2].mean(axis=0)
    u, _, v = np.linalg.svd(a.T @ b)
    rotation = u @ np.diag([1, np.sign(np.linalg.det(u @ v))]) @ v
    return float(np.sqrt(((a @ rotation - b) ** 2).sum(axis=1).mean()))
