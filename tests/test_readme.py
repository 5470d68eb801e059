"""Every command and every Python block of the README runs, in its order, beside the files that the repository ships.

A small room stands in for longer drives, one seed for many and three methods for all: the tables below say so.
"""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import Result
from typer.testing import CliRunner

from topomap.cli.main import app

ROOT = Path(__file__).parents[1]
DEN = ROOT / "tests" / "helpers" / "den.toml"
SMALL_WORLDS = ("room-corridor", "hall", "office-loop", "flat", "offices")
"""What stands in for a world is the small room under its name, so that it has folders of its own."""
SMALLER = {
    **{name: f"small/{name}.toml" for name in SMALL_WORLDS},
    "examples/worlds/flat.toml": "small/flat.toml",
    "examples/worlds/offices.yaml": "small/offices.toml",
    "examples/sweeps/conditions.toml": "small/variants.toml",
    "examples/sweeps/real-weather.toml": "small/variants.toml",
    "0-4": "0",
    "all": "alv,acv,area-centroid",
}
SHORT = ["--set", "sim.driver.laps=0.3"]
LESS = {
    "topomap run hall --set sim": SHORT,
    "topomap run hall --set stack.travel": SHORT,
    "topomap run office-loop": SHORT,
    "topomap run examples": SHORT,
    "topomap run room-corridor --set": SHORT,
    "topomap sweep": ["--set", "sim.driver.laps=0.3", "--set", "stack.mission.then=stop", "--jobs", "1"],
    "topomap run hall --mission hall": [
        f"--set={word}" for word in ("stack.hall.ahead=2.5", "stack.hall.behind=0.3", "stack.hall.width=1.8")
    ],
    "topomap bench graphs": ["--seeds", "0", "--peers", "none", "--kinds", "random"],
    "topomap bench kidnapped": ["--starts", "1"],
    "topomap bench homing --env": ["--starts", "0", "--jobs", "1", "--every", "8"],
    "topomap bench homing --grid": ["--methods", "alv", "--jobs", "1"],
    "topomap bench looks": ["--jobs", "1"],
    "topomap bench recording": ["--jobs", "1"],
    "topomap bench sessions": ["--laps", "0", "--jobs", "1"],
    "topomap bench spacing": ["--apart", "0.5", "--seeds", "0", "--jobs", "1"],
    "topomap bench drive": ["--draws", "1", "--jobs", "1"],
}
"""What the README leaves at its default is made less here."""
NOT_HERE = {
    "make demo": "installs into .venv; it then runs the first command of the list",
    "make test": "this is it",
    "make bench": "takes an hour",
    "make mutate": "takes an hour",
}


def blocks() -> list[list[str]]:
    """The README's indented blocks as lists of lines."""
    found: list[list[str]] = [[]]
    for line in (ROOT / "README.md").read_text(encoding="utf8").splitlines():
        if line.startswith("    "):
            found[-1].append(line[4:])
        elif line.strip() and found[-1]:
            found.append([])
    return [block for block in found if block]


PYTHON = ["\n".join(block) for block in blocks() if re.match(r"(from|import) ", block[0])]
COMMANDS = [
    line.partition(" #")[0].strip() for block in blocks() for line in block if re.match(r"(topomap|make|head) ", line)
]


def smaller(command: str) -> list[str]:
    words = shlex.split(command)[1:]
    if words[0] == "worlds":
        return words
    if words[:2] == ["bench", "recording"]:
        return [*words[:2], "small/square"]
    before = ["", *words]  # the mission in the hall bears a world's name
    return [word if before[k] == "--mission" else SMALLER.get(word, word) for k, word in enumerate(words)]


def first_pair() -> tuple[str, str]:
    """The first closure that the small room's run accepted: another world has other nodes."""
    listed = CliRunner().invoke(app, ["closures", "runs/a/run.mcap", "--verdict", "accepted", "--limit", "1"])
    _, query, match, *_ = listed.stdout.splitlines()[2].split()
    return query, match


def grid(folder: Path) -> None:
    """Somebody's panoramas on a grid, with what `grid.toml` says of them."""
    folder.mkdir()
    rng = np.random.default_rng(0)
    for x in range(3):
        for y in range(3):
            cv2.imwrite(str(folder / f"{x}_{y}.png"), rng.integers(0, 256, (20, 72, 3), dtype=np.uint8))
    (folder / "grid.toml").write_text('pattern = "{x}_{y}.png"\nunit_m = 0.3\n')


def drive(folder: Path) -> None:
    """Somebody's panoramas along a way."""
    folder.mkdir()
    rng, rows = np.random.default_rng(0), ["stamp_s,x_m,y_m,heading_rad,image"]
    for k in range(12):
        cv2.imwrite(str(folder / f"{k}.png"), rng.integers(0, 256, (20, 72, 3), dtype=np.uint8))
        rows.append(f"{k},{0.3 * k},0,0,{k}.png")
    (folder / "drive.csv").write_text("\n".join(rows))
    (folder / "rig.json").write_text('{"horizon_row": 9.5, "camera_height": 0.5}')


def square(folder: Path) -> None:
    """The recording that ships with every tenth of its loop candidates: 40 maps are made of it."""
    folder.mkdir()
    shipped = ROOT / "examples" / "recordings" / "square"
    (folder / "Square_GT.txt").write_text((shipped / "Square_GT.txt").read_text())
    lines = (shipped / "Square_Input.txt").read_text().splitlines(keepends=True)
    loops = [line for line in lines if line.startswith("loop")]
    (folder / "Square_Input.txt").write_text("".join([*(line for line in lines if line not in loops), *loops[::10]]))


@pytest.fixture(scope="module")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("clone")
    (folder / "examples").symlink_to(ROOT / "examples")
    grid(folder / "FOLDER")
    drive(folder / "DRIVE")
    (folder / "small").mkdir()
    square(folder / "small" / "square")
    (folder / "small" / "variants.toml").write_text("[as-it-is]\n[aside.sim.driver]\nlateral_offset = 0.1\n")
    for name in SMALL_WORLDS:
        (folder / "small" / f"{name}.toml").write_text(DEN.read_text().replace('"den"', f'"{name}"'))
    return folder


def run(command: str) -> Result:
    words = smaller(command)
    if "--explain" in words:
        words[-2:] = first_pair()
    return CliRunner().invoke(
        app, words + next((less for start, less in LESS.items() if command.startswith(start)), [])
    )


def test_the_commands_run_in_their_order(clone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(clone)
    monkeypatch.setenv("TOPOMAP_CACHE", str(clone / "cache"))
    assert len(COMMANDS) > 25
    logs: dict[Path, float] = {}

    for command in COMMANDS:
        if command in NOT_HERE:
            continue
        if command.startswith("head "):
            subprocess.run(command, shell=True, check=True)
            continue
        done = run(command)
        assert done.exit_code == 0, f"{command}: {done.output} {done.exception!r}"
        now = {path: path.stat().st_mtime for path in (clone / "runs").rglob("run.mcap")}
        overwritten = [path for path, made in logs.items() if now.get(path) != made]
        assert not overwritten, f"{command} writes over the run of a command before"
        logs = now
    assert len(logs) >= 9


@pytest.mark.parametrize("code", PYTHON, ids=lambda code: code.splitlines()[0])
def test_the_python_blocks_run(
    code: str, clone: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(clone)
    monkeypatch.setattr(sys, "path", [*sys.path])
    exec(compile(code, "README.md", "exec"), {"__name__": "__main__"})
    said = capsys.readouterr().out
    assert said.strip()
    if "replay" in code:
        assert said.splitlines()[0] == "True", "no finding, and the same hash"


def test_the_links_lead_somewhere() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf8")
    names = re.findall(r"\]\(([^)]+)\)", text) + re.findall(r"\b(?:examples|topomap)/[\w./-]+", text)
    assert len(names) > 10
    assert not [name for name in names if not name.startswith("http") and not (ROOT / name).exists()]
