"""The command line: one clear line and exit code 2 for what a user gets wrong."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from topomap.cli.main import main


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


@pytest.mark.parametrize(
    "command", [[], ["run"], ["replay"], ["report"], ["info"], ["recover"], ["export"], ["map", "tuc"], ["optimize"]]
)
def test_help_says_what_a_command_does(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], command: list[str]
) -> None:
    assert call(monkeypatch, *command, "--help") == 0
    assert len(capsys.readouterr().out) > 100


def test_the_version_is_shown(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "--version") == 0
    assert capsys.readouterr().out.startswith("topomap ")
