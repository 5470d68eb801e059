"""What a program that calls topomap sees: exit codes, one line on standard error, nothing that steers a terminal."""

from __future__ import annotations

import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from rich.console import Console
from round_world import RoundRobot
from typer.testing import CliRunner

import topomap
from topomap.cli import console
from topomap.cli.main import app, main
from topomap.core.names import printable, safe_name

GOLDEN = Path(__file__).parents[1] / "golden" / "first-house.mcap"
DEN = Path(__file__).parents[1] / "helpers" / "den.toml"


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A whole log, and the same cut off and with a damaged chunk, each in a folder of its own."""
    folder = tmp_path_factory.mktemp("logs")
    topomap.drive(RoundRobot(60), folder / "whole", settings=["stack.mission.then=stop"])
    data = (folder / "whole" / "run.mcap").read_bytes()
    middle = len(data) // 2
    kinds = {"cut": data[: len(data) * 2 // 3], "damaged": data[:middle] + bytes(16) + data[middle + 16 :]}
    for name, content in kinds.items():
        (folder / name).mkdir()
        (folder / name / "run.mcap").write_bytes(content)
    return {name: folder / name / "run.mcap" for name in ("whole", *kinds)}


COMMANDS = {
    "info": ["info", "LOG"],
    "replay": ["replay", "LOG", "--out", "OUT"],
    "report": ["report", "LOG", "--out", "OUT"],
    "export": ["export", "LOG", "--tum", "--out", "OUT"],
    "recover": ["recover", "LOG", "OUT.mcap"],
}


def call(words: list[str], log: Path, out: Path) -> tuple[int, str, str]:
    done = CliRunner().invoke(app, [word.replace("LOG", str(log)).replace("OUT", str(out)) for word in words])
    return done.exit_code, done.stdout, done.stderr


@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("kind", ["cut", "damaged"])
def test_every_reader_says_that_a_log_is_not_whole(name: str, kind: str, logs: dict[str, Path], tmp_path: Path) -> None:
    words = COMMANDS[name]
    code, _, said = call(words, logs[kind], tmp_path / "a")
    assert code == 3
    assert re.fullmatch(rf"topomap: {re.escape(str(logs[kind]))}: (cut off|damaged): .+\n", said)
    content, _, again = call([*words, "--partial"], logs[kind], tmp_path / "b")
    assert (content, again) == (0, said)
    if name == "report":
        summary = json.loads((tmp_path / "b" / "summary.json").read_text())
        assert summary["log"]["state"] in said
        assert summary["log"]["note"] in (tmp_path / "b" / "report.html").read_text().replace("&#39;", "'")


@pytest.mark.parametrize("name", COMMANDS)
def test_of_a_whole_log_nothing_is_said(name: str, logs: dict[str, Path], tmp_path: Path) -> None:
    code, out, said = call(COMMANDS[name], logs["whole"], tmp_path / "a")
    assert (code, said) == (0, "")
    assert name != "replay" or "The graph hash is the run's." in out


def test_a_run_that_a_fault_ended_is_code_4(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
                                            tmp_path: Path) -> None:  # fmt: skip
    from sim2d.robot import SimRobot

    sense, count = SimRobot.sense, [0]

    def failing(self: SimRobot) -> object:
        count[0] += 1
        if count[0] > 30:
            raise OSError("the camera is gone")
        return sense(self)

    monkeypatch.setattr(SimRobot, "sense", failing)
    monkeypatch.setattr(sys, "argv", ["topomap", "run", str(DEN), "--out", str(tmp_path / "out")])
    with pytest.raises(SystemExit) as stopped:
        main()
    printed = capsys.readouterr()
    assert stopped.value.code == 4
    assert printed.err == "topomap: the robot's sense() at step 30 failed: OSError: the camera is gone\n"
    assert "report.html" in printed.out
    monkeypatch.setattr(SimRobot, "sense", sense)
    monkeypatch.setattr(sys, "argv", ["topomap", "run", str(DEN), "--out", str(tmp_path / "out")])
    with pytest.raises(SystemExit) as stopped:
        main()
    assert stopped.value.code == 2
    assert "--force" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["worlds"], ["info", str(GOLDEN)], ["config", "show"], ["closures", str(GOLDEN)]])
def test_a_full_standard_output_is_one_line(words: list[str]) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "topomap", *words], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert done.returncode == 1
    assert done.stderr == "topomap: standard output can't be written (No space left on device)\n"


EVIL = "a[/x] [red]b[/red] \x1b[31m \x07 \u202e $\\frac{$"


def test_texts_are_texts_for_a_terminal(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    text = io.StringIO()
    monkeypatch.setattr(console, "console", console.PlainConsole(file=text, width=200))
    console.say(EVIL)
    console.table([(EVIL, EVIL)], EVIL)
    shown = console.grid(EVIL, (EVIL,))
    shown.add_row(EVIL)
    console.show_wide(shown)
    console.fail(EVIL)
    for said in (text.getvalue(), capsys.readouterr().err):
        assert "a[/x] [red]b[/red] \\x1b[31m" in said
        assert not re.search(r"[\x00-\x09\x0b-\x1f\u202e]", said)
    assert Console  # the plain one is one of these


def test_names_become_files_only_when_they_are_safe() -> None:
    for name in ("../../etc", "/etc/x", "..", "", ".", "a/b\\c", "x\0y", "\x1b[31m", "a" * 5000, "naïve café"):
        safe = safe_name(name)
        assert safe
        assert Path(safe).name == safe
        assert not safe.startswith(".")
        assert len(safe) <= 100
        assert safe.isprintable()
    assert safe_name("room-corridor") == "room-corridor"
    assert safe_name("a=[1, 2], b=0.5") == "a=_1_2_b=0.5"
    assert printable("a\nb\tc") == "a\nb\tc"
    assert printable("\x9b\u2028") == "\\x9b\\u2028"


def test_a_world_whose_name_is_a_path_stays_in_the_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    world, inside = tmp_path / "evil.toml", tmp_path / "in" / "side"
    world.write_text(DEN.read_text().replace('"den"', '"../../../out [/x] $\\\\frac{$"'))
    inside.mkdir(parents=True)
    monkeypatch.chdir(inside)
    done = CliRunner().invoke(app, ["worlds", "show", str(world)])
    assert done.exit_code == 0, done.output
    short = ["--set", "sim.driver.laps=0.1", "--set", "stack.mission.then=stop"]
    done = CliRunner().invoke(app, ["run", str(world), *short])
    assert done.exit_code == 0, done.output
    assert sorted(path.name for path in tmp_path.iterdir()) == ["evil.toml", "in"]
    assert [path.name for path in (tmp_path / "in").iterdir()] == ["side"]
    assert [path.name for path in (inside / "runs").iterdir() if path.name != "worlds"] == ["_.._.._out_x_frac_-0"]


def test_where_no_cache_can_be_kept_a_run_still_runs(tmp_path: Path) -> None:
    code = (
        "import os, tempfile\n"
        "from topomap.core import caches\n"
        "caches.writable = lambda folder: False\n"
        "caches.see_to_caches()\n"
        "from numba import njit\n"
        "a, b = os.environ['NUMBA_CACHE_DIR'], os.environ['MPLCONFIGDIR']\n"
        "print(os.path.isdir(a), a == b)\n"
    )
    bare = {k: v for k, v in os.environ.items() if k not in ("NUMBA_CACHE_DIR", "MPLCONFIGDIR")}
    done = subprocess.run(
        [sys.executable, "-c", code], env=bare | {"TMPDIR": str(tmp_path)}, capture_output=True, text=True, check=True
    )
    assert done.stdout == "True True\n"
    assert not list(tmp_path.iterdir()), "it is gone with the program"
