"""Many runs: which ones, that the number of processes changes nothing, and what is told of them."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from topomap.app.config import load_config
from topomap.app.sweep import RunTask, plan, run_sweep, variants, write_sweep
from topomap.bench.sweeps.matrix import matrix, placed
from topomap.bench.sweeps.table import SweptRun, lines
from topomap.cli.sweep_commands import HEADINGS, cells
from topomap.core.errors import ConfigError, DataError

DEN = str(Path(__file__).parent.parent / "helpers" / "den.toml")
SHORT = ["sim.driver.laps=0.5", "stack.mission.then=stop"]


def swept(out: Path, jobs: int) -> list[SweptRun]:
    return run_sweep(plan([DEN], [0, 1], None, SHORT, variants([], None), out), jobs, False, out, lambda _: None)


@pytest.fixture(scope="module")
def twice(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[SweptRun], list[SweptRun]]:
    out, other = tmp_path_factory.mktemp("one"), tmp_path_factory.mktemp("two")
    return out, swept(out, 1), swept(other, 2)


def test_variants_are_every_combination(tmp_path: Path) -> None:
    named = tmp_path / "named.toml"
    named.write_text(
        "[calm]\n[crowd.sim.people]\nextra = 4\n[dusk.sim]\ncamera.light_changes = [{hour = 20, at_s = 3}]\n"
    )
    found = variants(["sim.driver.lateral_offset=[0.0, 0.3]"], named)
    assert [v.name for v in found] == [
        f"sim.driver.lateral_offset={offset}, {name}" for offset in ("0.0", "0.3") for name in ("calm", "crowd", "dusk")
    ]
    tasks = plan([DEN], [0], None, SHORT, found, tmp_path)
    assert tasks[4].config.sim.driver.lateral_offset == 0.3
    assert tasks[4].config.sim.people.extra == 4
    assert tasks[5].config.sim.camera.light_changes[0].hour == 20
    assert len({task.folder for task in tasks}) == 6
    assert not any(" " in str(task.folder.relative_to(tmp_path)) for task in tasks)


@pytest.mark.parametrize(
    ("name", "world", "count"),
    [
        ("conditions", DEN, 8),
        ("real-weather", DEN, 8),
        ("real-weather-strength", DEN, 48),
        ("standing", "office-loop", 5),
    ],
)
def test_the_example_holds_settings_that_there_are(tmp_path: Path, name: str, world: str, count: int) -> None:
    example = Path(__file__).parents[2] / "examples" / "sweeps" / f"{name}.toml"
    tasks = plan([world], [0], None, SHORT, variants([], example), tmp_path)
    assert len({task.config.model_dump_json() for task in tasks}) == len(tasks) >= count


@pytest.mark.parametrize(
    ("vary", "text", "says"),
    [
        (["sim.driver.laps=2"], None, "--vary sim.driver.laps=2: expected section.key=[value, ...]"),
        (["sim.driver.laps=[]"], None, "expected section.key=[value, ...]"),
        (["=[1]"], None, "expected section.key=[value, ...]"),
        ([], "laps = 2", "named.toml: laps = 2: expected a table of settings"),
        ([], "", "named.toml: holds no variants"),
        ([], "[a", "named.toml: not a TOML file"),
    ],
)
def test_wrong_variants_are_one_line(tmp_path: Path, vary: list[str], text: str | None, says: str) -> None:
    file = None if text is None else tmp_path / "named.toml"
    if file is not None and text is not None:
        file.write_text(text)
    with pytest.raises(ConfigError) as wrong:
        variants(vary, file)
    assert says in str(wrong.value)
    assert "\n" not in str(wrong.value)


def test_all_is_checked_before_anything_runs(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"unknown key sim\.speed"):
        plan([DEN], [0], None, [], variants(["sim.speed=[1]"], None), tmp_path)
    with pytest.raises(DataError, match="unknown world 'nowhere'"):
        plan([DEN, "nowhere"], [0], None, [], variants([], None), tmp_path)
    assert not list(tmp_path.iterdir())


def test_the_number_of_processes_changes_nothing(twice: tuple[Path, list[SweptRun], list[SweptRun]]) -> None:
    _, one, two = twice
    assert [run.summary["graph_hash"] for run in one] == [run.summary["graph_hash"] for run in two]
    assert one[0].summary["graph_hash"] != one[1].summary["graph_hash"]
    assert [run.seed for run in one] == [0, 1]


def test_what_is_there_is_not_made_again(twice: tuple[Path, list[SweptRun], list[SweptRun]]) -> None:
    out, one, _ = twice
    log = out / "den" / "default" / "seed-0" / "run.mcap"
    made = log.stat().st_mtime_ns
    assert [run.summary for run in swept(out, 1)] == [run.summary for run in one]
    assert log.stat().st_mtime_ns == made


def test_the_table_says_what_the_runs_say(twice: tuple[Path, list[SweptRun], list[SweptRun]]) -> None:
    out, one, _ = twice
    (line,) = lines(one)
    errors = [run.summary["map_ate_m"]["se2"] for run in one]
    assert line.spreads["map_ate_se2_m"].mean == pytest.approx(sum(errors) / 2)
    assert (line.spreads["map_ate_se2_m"].least, line.spreads["map_ate_se2_m"].most) == (min(errors), max(errors))
    assert math.isnan(line.home.value), "home wasn't asked for"
    assert len(cells(line)) == len(HEADINGS)
    table, rows, picture, glance = write_sweep(one, out)
    assert json.loads(table.read_text())[0]["seeds"] == [0, 1]
    assert [row["graph_hash"] for row in csv.DictReader(rows.open())] == [run.summary["graph_hash"] for run in one]
    assert picture.stat().st_size > 10_000
    assert glance.stat().st_size > 5_000


def test_the_strengths_of_one_variant_stand_side_by_side(twice: tuple[Path, list[SweptRun], list[SweptRun]]) -> None:
    _, one, _ = twice
    names = ("fog x1", "fog x2", "night x2", "axle x")
    runs = [replace(run, variant=name) for name in names for run in one]
    assert [placed(line) for line in lines(runs)] == [
        ("fog", "den\nx1"), ("fog", "den\nx2"), ("night", "den\nx2"), ("axle x", "den"),
    ]  # fmt: skip
    drawn = matrix(runs)
    titles = [axes.get_title(loc="left") for axes in drawn.axes]
    assert titles == ["false closures, in all", "map [m], mean"], "home wasn't asked for, nothing is seen again"
    words = [text.get_text() for text in drawn.axes[1].texts]
    assert words == [f"{lines(one)[0].spreads['map_ate_se2_m'].mean:.2f}"] * 4


def test_a_run_whose_files_were_deleted_is_made_again(twice: tuple[Path, list[SweptRun], list[SweptRun]]) -> None:
    out, one, _ = twice
    folder = out / "den" / "default" / "seed-1"
    for path in folder.iterdir():
        path.unlink()
    assert [run.summary["graph_hash"] for run in swept(out, 1)] == [run.summary["graph_hash"] for run in one]
    assert {path.name for path in folder.iterdir()} == {
        "run.mcap",
        "run.topomap",
        "run.truth.csv",
        "summary.json",
        "report.html",
    }


def test_the_key_holds_every_file_that_a_world_rests_on(tmp_path: Path) -> None:
    base, world = tmp_path / "base.toml", tmp_path / "mine.toml"
    base.write_text(Path(DEN).read_text())
    world.write_text('extends = "base.toml"\nname = "mine"\n')
    picture, plan_file = tmp_path / "map.pgm", tmp_path / "map.yaml"
    room = np.full((120, 160), 0, np.uint8)
    room[10:110, 10:150] = 254
    cv2.imwrite(str(picture), room)
    plan_file.write_text("image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n")

    def keys(name: Path) -> str:
        return RunTask(str(name), "default", 0, load_config(), tmp_path / "out").key

    for name, rests_on in ((world, (base, world)), (plan_file, (picture, plan_file))):
        for path in rests_on:
            before, content = keys(name), path.read_bytes()
            path.write_bytes(content + b"\n")
            assert keys(name) != before, path
            path.write_bytes(content)
            assert keys(name) == before
