"""The command line: one clear line and exit code 2 for what a user gets wrong."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
import typer

from topomap.app.config import load_config
from topomap.cli.main import app, main


def call(monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
    monkeypatch.setattr(sys, "argv", ["topomap", *words])
    with pytest.raises(SystemExit) as stopped:
        main()
    return int(stopped.value.code or 0)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["run", "nowhere"], "unknown world 'nowhere'; there are a1original, "),
        (["run", "hall", "--set", "stack.speed=3"], "unknown key stack.speed"),
        (["run", "hall", "--config", "none.toml"], "none.toml: cannot be read"),
        (["run", "hall", "--out", "/proc/none"], "/proc/none: the output folder can't be made"),
        (["replay", "none.mcap"], "none.mcap"),
        (["report", "none.mcap"], "none.mcap"),
        (["info", "none.mcap"], "none.mcap"),
        (["recover", "none.mcap", "out.mcap"], "none.mcap"),
        (["export", "none.mcap", "--tum"], "none.mcap"),
        (["map", "tuc", "none"], "none"),
        (["optimize", "none.g2o"], "none.g2o: can't be read"),
    ],
)
def test_a_mistake_is_one_line_and_exit_code_2(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    words: list[str],
    says: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert call(monkeypatch, *words) == 2
    printed = capsys.readouterr()
    assert says in printed.err
    assert printed.err.count("\n") == 1
    assert not printed.out
    assert not list(tmp_path.iterdir())


def commands(group: click.Command, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    yield path, group
    for name, one in getattr(group, "commands", {}).items():
        yield from commands(one, (*path, name))


ALL = dict(commands(typer.main.get_command(app)))


@pytest.mark.parametrize("command", ALL, ids=" ".join)
def test_help_says_what_a_command_does(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], command: tuple[str, ...]
) -> None:
    said = []
    for word in ("-h", "--help"):
        assert call(monkeypatch, *command, word) == 0
        said.append(capsys.readouterr().out)
    assert said[0] == said[1]
    assert len(said[0]) > 100
    assert ALL[command].help
    without = [one.name for one in ALL[command].params if not getattr(one, "help", None)]
    assert not without, "every argument and option says what it is for"


def test_the_version_is_shown(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "--version") == 0
    assert capsys.readouterr().out.startswith("topomap ")


def test_config_show_prints_what_config_reads(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert call(monkeypatch, "config", "show", "--set", "sim.camera.hour=14", "--set", "stack.mission.then=stop") == 0
    text = capsys.readouterr().out
    lines = text.splitlines()
    assert lines[lines.index('then = "stop"') - 1].endswith('("home" or "stop"; default "home")')
    assert "hour = 14.0" in lines
    assert "# laps is not set" in lines, "TOML has no null"
    settings = [k for k, line in enumerate(lines) if " = " in line and not line.startswith("#")]
    assert all(lines[k - 1].startswith("# ") and "default " in lines[k - 1] for k in settings)
    (tmp_path / "mine.toml").write_text(text)
    again = load_config(tmp_path / "mine.toml")
    assert again == load_config(None, ["sim.camera.hour=14", "stack.mission.then=stop"])


def test_config_show_leaves_out_what_makes_the_simulated_robot_worse_until_asked(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(monkeypatch, "config", "show") == 0
    short = capsys.readouterr().out.splitlines()
    assert call(monkeypatch, "config", "show", "--all") == 0
    whole = capsys.readouterr().out.splitlines()
    left = sum("default " in line for line in whole) - sum("default " in line for line in short)
    assert sum("default " in line for line in short) < 60, "as many as somebody reads"
    assert short[-1] == f"# {left} more by which the simulated robot can be made worse: topomap config show --all"
    worse = {"blur = 0.0", "[sim.camera.lens]"}
    assert worse <= set(whole)
    assert not worse & set(short)
    assert all(line in whole for line in short[:-1])


def test_config_show_keeps_what_is_set(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["--set", "sim.camera.lens.seam=0.1", "--set", "sim.camera.blur=1.5"]
    assert call(monkeypatch, "config", "show", *asked) == 0
    lines = capsys.readouterr().out.splitlines()
    assert {"seam = 0.1", "blur = 1.5"} <= set(lines)
    assert "roll_deg = 0.0" not in lines


def test_config_show_prints_tables_in_lists(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "mine.toml").write_text('[[sim.kidnaps]]\nat_s = 3.0\nplace = "the \\"sofa\\" ä"\n')
    assert call(monkeypatch, "config", "show", "--config", str(tmp_path / "mine.toml")) == 0
    (tmp_path / "again.toml").write_text(capsys.readouterr().out)
    assert load_config(tmp_path / "again.toml") == load_config(tmp_path / "mine.toml")


def test_config_schema_is_one(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "config", "schema") == 0
    schema = json.loads(capsys.readouterr().out)
    assert set(schema["properties"]) == {"stack", "sim", "log"}
    assert "goal_node" in schema["$defs"]["MissionSettings"]["properties"]
