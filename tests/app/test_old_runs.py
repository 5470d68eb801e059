"""Logs and maps of the first version: they load, report, export and replay; what a log asked for is kept or told."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import topomap
from logs.replay import ReplayRobot
from topomap.app.config import RunConfig
from topomap.app.stored_config import first_defaults, parse_stored
from topomap.app.stored_run import open_log
from topomap.cli.main import app
from topomap.core.errors import ConfigError

GOLDEN = Path(__file__).parents[1] / "golden"
LOG, MAP = GOLDEN / "first-house.mcap", GOLDEN / "first-house.topomap"
"""Made by version 0.1: a small camera, 1.4 laps of a small room, `stack.mapper.closing.likeness.times=2.5`,
`log.flush_seconds=30`."""


@pytest.fixture
def stored() -> dict[str, Any]:
    config: dict[str, Any] = json.loads(ReplayRobot(LOG).header.config)
    return config


def test_an_old_log_is_read_as_it_was() -> None:
    run = topomap.load_run(LOG)
    assert len(run.stamps_ns) == 58
    assert run.graph_hash.startswith("218e040fa892e25d")
    assert sum(decision.verdict == "accepted" for decision in run.decisions) == 3
    assert len(run.nodes) == 16


def test_an_old_map_is_read_as_it_was() -> None:
    topo = topomap.load_map(MAP)
    assert sum(node.snapshot is not None for node in topo.nodes) == 12
    assert topo.calibration.rotation_scale == pytest.approx(1.0339, abs=1e-4)
    assert len(topo.closures) == 3


def test_an_old_log_reports_exports_and_lists_its_closures(tmp_path: Path) -> None:
    for words in (["report", str(LOG)], ["export", str(LOG), "--tum", "--g2o"]):
        done = CliRunner().invoke(app, [*words, "--out", str(tmp_path)])
        assert done.exit_code == 0, done.output
    assert {path.name for path in tmp_path.iterdir()} >= {"summary.json", "report.html", "map.tum", "map.g2o"}
    assert CliRunner().invoke(app, ["closures", str(LOG)]).stdout.startswith("4 closure candidates")


def test_an_old_log_replays(tmp_path: Path) -> None:
    result = topomap.replay(LOG, tmp_path)
    told = [note for note in result.notes if "same_place.times = 2.5" not in note]
    assert told == ["the log asks for log.flush_seconds = 30.0, which is no setting any more: it is left out"]
    assert result.summary["steps"] == 58
    assert result.summary["closures"]["false"] == 0


def test_what_an_old_log_asks_for_is_kept_under_its_new_name(stored: dict[str, Any]) -> None:
    stored["stack"]["mapper"]["correction"]["every"] = 7
    config, _ = parse_stored(stored, "log")
    assert config.stack.mapper.optimisation.every == 7
    assert config.sim.body.step == 0.6


def test_what_is_no_more_is_told_where_it_mattered(stored: dict[str, Any]) -> None:
    stored["stack"]["mapper"]["magic"] = {"wand": 3}
    stored["log"]["ink"] = "blue"
    _, notes = parse_stored(stored, "log")
    told = {note.split(",")[0] for note in notes}
    assert told >= {"the log asks for stack.mapper.magic.wand = 3", "the log asks for log.ink = 'blue'"}
    assert len(told) <= 4, "no line for what was the default"


def test_a_note_is_a_line_on_the_terminal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("topomap.app.stored_config.RENAMED", (("sim.odometer", "sim.wheels"),))
    monkeypatch.setattr("topomap.app.stored_config.first_defaults", dict)
    done = CliRunner().invoke(app, ["replay", str(LOG), "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert "Note: the log asks for sim.wheels.distance_scale = 0.95, which is no setting any more" in done.stdout


def test_a_wrong_value_in_a_log_is_one_line(stored: dict[str, Any]) -> None:
    stored["sim"]["body"]["step"] = -1
    with pytest.raises(ConfigError, match=r"log: sim\.body\.step = -1"):
        parse_stored(stored, "log")


def test_a_replay_takes_no_settings_of_the_simulator() -> None:
    for word in ("sim.body.step=0.2", " sim.driver.laps=1", "nonsense=1", "stack"):
        with pytest.raises(ConfigError, match="the drive is history"):
            open_log(LOG, [word])


def test_every_old_default_was_once_a_setting(stored: dict[str, Any]) -> None:
    assert len(first_defaults()) == 175 - 3, "three settings of 0.1 are none by default"
    assert parse_stored(RunConfig().resolved(), "log") == (RunConfig(), ())
