"""Drives in folders: what is read, what is told to be wrong, and the whole way to a report."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from drive_folders import HEAD, write_drive
from round_world import RIG
from typer.testing import CliRunner

import topomap
from topomap.bench.recordings.made_odometry import MadeErrors, scaled, thinned, with_made_odometry
from topomap.core.errors import DataError
from topomap.datasets.drive_folder import FolderRobot, read_folder
from topomap.datasets.drive_folder.table import increments
from topomap.mapping.odometry.increments import Calibration, Increments, track


@pytest.fixture(scope="module")
def posed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_drive(tmp_path_factory.mktemp("drives") / "posed", 130)


@pytest.fixture(scope="module")
def with_odometry(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_drive(tmp_path_factory.mktemp("drives") / "odometry", 130, ",forward_m,turn_rad")


def test_poses_alone_are_the_odometers(posed: Path) -> None:
    drive = read_folder(posed)
    assert drive.table.truth is None
    assert "x_m" in drive.notes[0]
    table = drive.table
    route = track(Increments(table.stamps_ns[1:], table.deltas[1:], table.covariances[1:]), Calibration())
    last = (posed / "drive.csv").read_text().splitlines()[-1].split(",")
    assert route[-1, :2] == pytest.approx([float(last[1]), float(last[2])], abs=1e-6)


def test_poses_beside_odometry_are_the_truth(with_odometry: Path) -> None:
    robot = FolderRobot(read_folder(with_odometry))
    readings = [robot.sense() for _ in range(3)]
    assert readings[2] is not None
    assert readings[2].motion.forward == pytest.approx(readings[1].motion.forward if readings[1] else 0)
    truth = robot.truth()
    assert truth is not None
    assert truth.stamp_ns == readings[2].stamp_ns
    assert truth.x > 0


def test_increments_are_the_inverse_of_a_track() -> None:
    deltas = np.random.default_rng(0).normal(0, 0.4, (50, 3))
    poses = track(Increments(np.arange(50), deltas, np.tile(np.eye(3), (50, 1, 1))), Calibration())
    assert increments(poses)[1:] == pytest.approx(deltas)


def test_a_drive_comes_out_as_a_run_does(with_odometry: Path, tmp_path: Path) -> None:
    result = topomap.map_folder(with_odometry, tmp_path / "out")
    assert {path.name for path in result.files} == {"run.mcap", "run.topomap", "summary.json", "report.html"}
    assert result.summary["closures"]["accepted"] > 0
    assert result.summary["closures"]["false"] == 0
    assert result.summary["map_ate_m"]["se2"] < 0.3
    assert any(note.startswith("odometry: increments forward_m") for note in result.notes)
    again = topomap.replay(result.folder.log)
    assert again.summary["graph_hash"] == result.summary["graph_hash"]


def test_the_command_takes_a_folder(posed: Path, tmp_path: Path) -> None:
    from topomap.cli.main import app

    said = CliRunner().invoke(app, ["map", str(posed), "--out", str(tmp_path), "--made-odometry", "3"])
    assert said.exit_code == 0, said.output
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["seed"] == 3
    assert summary["rotation_scale"]["true"] != 1.0
    assert summary["dead_reckoning_ate_m"]["se2"] > 0


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("0.25,0,0,0,images/001.png\n0.25,0,0,0,images/001.png", r"drive.csv:4: stamp_s: '0.25' isn't later"),
        ("0.25,0,nan,0,images/001.png", r"drive.csv:3: y_m: 'nan' is no finite number"),
        ("0.25,0,0,0,images/none.png", r"drive.csv:3: image: there is no file 'images/none.png'"),
        ("0.25,0,0,0", r"drive.csv:3: image: there is no file ''"),
    ],
)
def test_a_broken_line_is_named(posed: Path, tmp_path: Path, line: str, words: str) -> None:
    (tmp_path / "images").symlink_to(posed / "images")
    (tmp_path / "drive.csv").write_text(f"{HEAD}\n0,0,0,0,images/000.png\n{line}\n")
    with pytest.raises(DataError, match=words):
        read_folder(tmp_path)


def test_what_is_missing_is_named(posed: Path, tmp_path: Path) -> None:
    (tmp_path / "images").symlink_to(posed / "images")
    with pytest.raises(DataError, match=r"drive\.csv: can't be read: No such file"):
        read_folder(tmp_path)
    row = "{},0,images/000.png"
    (tmp_path / "drive.csv").write_text("\n".join(["stamp_s,x_m,image", row.format(0), row.format(1)]))
    with pytest.raises(DataError, match="there is no odometry: give the columns forward_m, turn_rad or odom_x_m"):
        read_folder(tmp_path)


@pytest.mark.parametrize(
    ("rig", "words"),
    [
        ({"width": 7}, "width: 7: input should be greater"),
        ({"width": 1000}, "width: 1000, but the first image has"),
        ({"forward_column": 5000}, "forward_column: 5000, but the images have"),
        ({"camera_height": "high"}, "camera_height: 'high'"),
    ],
)
def test_a_wrong_rig_is_named(posed: Path, tmp_path: Path, rig: dict[str, object], words: str) -> None:
    for name in ("images", "drive.csv"):
        (tmp_path / name).symlink_to(posed / name)
    (tmp_path / "rig.json").write_text(json.dumps(rig))
    with pytest.raises(DataError, match=words):
        read_folder(tmp_path)


def test_what_the_rig_doesnt_tell_is_told_to_be_assumed(posed: Path, tmp_path: Path) -> None:
    for name in ("images", "drive.csv"):
        (tmp_path / name).symlink_to(posed / name)
    drive = read_folder(tmp_path)
    said = " ".join(drive.notes)
    assert "tells no horizon_row: eye level" in said
    assert "tells no camera_height" in said
    assert drive.rig.forward_column == drive.rig.width // 2


@pytest.mark.data
def test_eye_level_of_recorded_drives_is_found_or_said_to_be_unclear(data_dir: Path, tmp_path: Path) -> None:
    for name, row in (("antworld-loop", 119.5), ("outdoor-loop", None)):
        (tmp_path / name).mkdir()
        for part in ("images", "drive.csv"):
            (tmp_path / name / part).symlink_to(data_dir / "drives" / name / part)
        drive = read_folder(tmp_path / name)
        if row is None:
            assert "isn't clear" in " ".join(drive.notes)
        else:
            assert drive.rig.horizon_row == pytest.approx(row, abs=1.0)


def test_made_odometry_reads_the_drawn_errors(posed: Path) -> None:
    drive = thinned(scaled(read_folder(posed), 10.0), 2)
    quiet = MadeErrors(forward_noise=0.0, turn_noise=0.0)
    made, known = with_made_odometry(drive, 5, quiet)
    assert made.table.truth is not None
    true = increments(made.table.truth)[1:]
    read = made.table.deltas[1:]
    assert read[:, 0] == pytest.approx(known.distance_scale * true[:, 0], abs=1e-3)
    assert read[:, 2] == pytest.approx(known.rotation_scale * true[:, 2] + known.curvature * true[:, 0], abs=1e-4)
    noisy, _ = with_made_odometry(drive, 5)
    off = (noisy.table.deltas - made.table.deltas)[1:, 2] / np.sqrt(noisy.table.covariances[1:, 2, 2])
    assert 0.7 < float(off.std()) < 1.4
    assert made.rig.camera_height == pytest.approx(10 * RIG.camera_height)
    assert len(made.table) == 65


@pytest.mark.data
def test_recorded_drives_are_read(data_dir: Path) -> None:
    for name, readings in (("antworld-loop", 1621), ("outdoor-loop", 563)):
        drive = read_folder(data_dir / "drives" / name)
        assert len(drive.table) == readings
