"""A run owns its folder: one at a time, no mixture with an earlier one, nothing written over unasked."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from round_world import RoundRobot

import topomap
from topomap.app.export import export_run
from topomap.app.folder import RunFolder
from topomap.app.runs import report_log
from topomap.core.errors import DataError

FILES = ("run.mcap", "run.topomap", "summary.json", "report.html")


@pytest.mark.parametrize("name", FILES)
def test_what_an_earlier_run_left_is_replaced_only_when_asked(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("mine")
    with pytest.raises(DataError, match=rf"holds a run already \({name}\); choose another --out or give --force"):
        RunFolder.create(tmp_path)
    assert (tmp_path / name).read_text() == "mine"
    folder = RunFolder.create(tmp_path, force=True)
    assert (tmp_path / name).read_text() == "mine", "not before the run begins"
    folder.clear()
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_in_use_is_refused_even_when_forced(tmp_path: Path) -> None:
    for force in (False, True):
        with RunFolder(tmp_path).owned(), pytest.raises(DataError, match="another run is writing there"):
            RunFolder.create(tmp_path, force=force)
    RunFolder.create(tmp_path)


def test_another_process_is_kept_out_and_a_dead_one_is_not(tmp_path: Path) -> None:
    code = (
        "import sys, time; from pathlib import Path; from topomap.app.folder import RunFolder\n"
        "with RunFolder(Path(sys.argv[1])).owned(): print('in', flush=True); time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "in\n"
        with pytest.raises(DataError, match="another run is writing there"):
            RunFolder.create(tmp_path)
        other.kill()
    RunFolder.create(tmp_path)


def test_links_are_taken_away_and_not_followed(tmp_path: Path) -> None:
    precious, out = tmp_path / "precious", tmp_path / "out"
    precious.write_text("mine")
    out.mkdir()
    (out / "run.mcap").symlink_to(precious)
    (out / "report.html").symlink_to(tmp_path / "nowhere")
    with pytest.raises(DataError, match=r"holds a run already \(run.mcap, report.html\)"):
        RunFolder.create(out)
    result = topomap.drive(RoundRobot(10), out, force=True)
    assert precious.read_text() == "mine"
    assert not result.folder.log.is_symlink()
    assert not (tmp_path / "nowhere").exists()


def test_a_second_drive_needs_force_and_leaves_no_mixture(tmp_path: Path) -> None:
    first = topomap.drive(RoundRobot(30), tmp_path)
    made = {path.name: path.read_bytes() for path in first.files}
    with pytest.raises(DataError, match="--force"):
        topomap.drive(RoundRobot(40), tmp_path)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == made
    again = topomap.drive(RoundRobot(40), tmp_path, force=True)
    assert again.summary["steps"] > first.summary["steps"]
    assert json.loads((tmp_path / "summary.json").read_text())["steps"] == again.summary["steps"]


def test_the_map_of_another_run_is_not_exported(tmp_path: Path) -> None:
    topomap.drive(RoundRobot(40), tmp_path / "a")
    topomap.drive(RoundRobot(90), tmp_path / "b")
    log = tmp_path / "a" / "run.mcap"
    assert export_run(log, tmp_path / "out", tum=True, g2o=True)[1] == ""
    (tmp_path / "a" / "run.topomap").write_bytes((tmp_path / "b" / "run.topomap").read_bytes())
    with pytest.raises(DataError, match="isn't the map of this log's run"):
        export_run(log, tmp_path / "out", tum=True, g2o=True)


def test_a_report_is_written_again_beside_its_log_but_not_into_another_runs_folder(tmp_path: Path) -> None:
    topomap.drive(RoundRobot(20), tmp_path / "a")
    topomap.drive(RoundRobot(30), tmp_path / "b")
    log = tmp_path / "a" / "run.mcap"
    report_log(log, tmp_path / "a")
    report_log(log, tmp_path / "c")
    kept = (tmp_path / "b" / "summary.json").read_text()
    for name in "bc":
        with pytest.raises(DataError, match="--force"):
            report_log(log, tmp_path / name)
    assert (tmp_path / "b" / "summary.json").read_text() == kept
    report_log(log, tmp_path / "c", force=True)
