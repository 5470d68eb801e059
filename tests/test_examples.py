"""Every example script runs and says something."""

from __future__ import annotations

import runpy
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "examples"
EXAMPLES = sorted(FOLDER.glob("*.py"))
WORDS = {"home_in_five_lines.py": [str(FOLDER / "panoramas" / name) for name in ("here.png", "goal.png")]}
DRIVES = ("own_robot.py", "own_homing.py")
"""These run in this process, which spares each 4 s of imports and a report of ten pictures."""


def run(script: Path, cwd: Path) -> str:
    words = [sys.executable, str(script), *WORDS.get(script.name, [])]
    done = subprocess.run(words, cwd=cwd, capture_output=True, text=True, timeout=180, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda script: script.name)
def test_the_example_runs(
    script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if script.name in DRIVES:
        monkeypatch.chdir(tmp_path)
        runpy.run_path(str(script), run_name="__main__")
        said = capsys.readouterr().out
    else:
        said = run(script, tmp_path)
    assert said.strip()
    assert len(script.read_text().splitlines()) <= 30
    if script.name == "home_in_five_lines.py":
        assert 170 < abs(float(said.split("lies ")[1].split()[0])) <= 180, "home lies behind"
    if script.name == "own_robot.py":
        driven, replayed = said.split()
        assert driven == replayed, "the log replays to the same map"
        assert len(driven) == 64
