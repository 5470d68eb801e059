"""The mission's main job, end to end: drive, map, close the loop, go home, log, replay, report; and stopping early."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from typer.testing import CliRunner

from topomap.cli.main import app
from topomap.datasets.g2o import read_graph
from topomap.mapping.mapfile import load_map
from topomap.recording.run_reader import load_run

SUMMARY_KEYS = [
    *("world", "seed", "config", "distance_m", "steps", "steps_per_s", "snapshots", "closures"),
    *("dead_reckoning_ate_m", "map_ate_m", "online_ate_m", "rotation_scale", "distance_scale", "curvature"),
    *("home", "legs", "trust", "mount", "graph_hash", "topology_hash", "fault", "log", "versions"),
]


def topomap(*words: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "topomap", *words], cwd=cwd, capture_output=True, text=True, timeout=240, check=False
    )


def asked(*words: str) -> str:
    """What the command line answers, asked in this process, which spares it 4 s of imports."""
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    return done.stdout


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    folder = tmp_path_factory.mktemp("run")
    done = topomap("run", "room-corridor", "--seed", "7", "--out", "out", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert "run.mcap" in done.stdout
    assert "\x1b" not in done.stdout, "no bar and no colours in a pipe"
    return folder / "out", json.loads((folder / "out" / "summary.json").read_text())


def test_the_map_is_good_and_the_robot_comes_home(finished: tuple[Path, dict[str, Any]]) -> None:
    _, summary = finished
    assert list(summary) == SUMMARY_KEYS
    assert summary["map_ate_m"]["se2"] <= min(0.3, summary["dead_reckoning_ate_m"]["se2"])
    assert summary["closures"]["accepted"] >= 10
    assert summary["closures"]["false"] == 0
    assert summary["closures"]["recall"] >= 0.8
    assert summary["home"]["claimed"]
    assert summary["home"]["within_0_3_m"]
    assert summary["home"]["collisions"] == 0
    scale = summary["distance_scale"]
    assert abs(scale["found"] / scale["true"] - 1.0) < 0.015


def test_the_report_stands_alone(finished: tuple[Path, dict[str, Any]]) -> None:
    page = (finished[0] / "report.html").read_text()
    assert len(page) > 100_000
    assert "data:image/" in page
    assert 'src="http' not in page


def test_the_log_stays_small_and_the_map_loads(finished: tuple[Path, dict[str, Any]]) -> None:
    folder, summary = finished
    assert (folder / "run.mcap").stat().st_size < 60e6
    topo = load_map(folder / "run.topomap")
    assert sum(node.snapshot is not None for node in topo.nodes) == summary["snapshots"]


def test_viewers_end_on_the_finished_map(finished: tuple[Path, dict[str, Any]]) -> None:
    data, drawn = load_run(finished[0] / "run.mcap"), drawn_edges(finished[0] / "run.mcap")
    at = {node.node: tuple(np.round(node.pose[:2], 6).tolist()) for node in data.nodes}
    assert sorted(map(sorted, drawn)) == sorted(sorted((at[a], at[b])) for a, b, _ in data.edges)


def drawn_edges(path: Path) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Both ends (x, y) of every edge in the last drawing of the map."""
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        last = [p for _, _, _, p in reader.iter_decoded_messages(topics=["/map/graph"])][-1]
    ends = [(round(p.x, 6), round(p.y, 6)) for line in last.entities[0].lines for p in line.points]
    return list(zip(ends[::2], ends[1::2], strict=True))


def test_a_replay_gives_the_same_map(finished: tuple[Path, dict[str, Any]], tmp_path: Path) -> None:
    folder, summary = finished
    asked("replay", str(folder / "run.mcap"), "--out", str(tmp_path / "again"))
    again = json.loads((tmp_path / "again" / "summary.json").read_text())
    assert again["graph_hash"] == summary["graph_hash"]
    assert set(again["home"].values()) == {None}, "a replay can't change the drive"


@pytest.mark.slow
def test_a_replay_with_another_setting_gives_another_map(finished: tuple[Path, dict[str, Any]], tmp_path: Path) -> None:
    word = "stack.mapper.snapshots.threshold=0.6"
    asked("replay", str(finished[0] / "run.mcap"), "--set", word, "--out", str(tmp_path / "again"))
    again = json.loads((tmp_path / "again" / "summary.json").read_text())
    assert again["graph_hash"] != finished[1]["graph_hash"]
    assert again["snapshots"] > finished[1]["snapshots"]


def test_export_writes_what_other_tools_read(finished: tuple[Path, dict[str, Any]], tmp_path: Path) -> None:
    asked("export", str(finished[0] / "run.mcap"), "--tum", "--g2o", "--out", str(tmp_path))
    lines = (tmp_path / "map.tum").read_text().splitlines()
    rows = [line.split() for line in lines if not line.startswith("#")]
    assert len(rows) == finished[1]["steps"]
    assert {len(row) for row in rows} == {8}
    topo, graph = load_map(finished[0] / "run.topomap"), read_graph(tmp_path / "map.g2o")
    assert graph.nodes == len(topo.nodes)
    inserted = sum(abs(topo.chain.index(t.j) - topo.chain.index(t.i)) > 1 for t in topo.turns)
    assert len(graph.i) == len(topo.closures) + inserted


def test_the_audit_trail_agrees_with_the_summary(finished: tuple[Path, dict[str, Any]]) -> None:
    folder, summary = finished
    found = {}
    for words in ((), ("--verdict", "accepted"), ("--false", "--verdict", "accepted")):
        found[words] = int(asked("closures", str(folder / "run.mcap"), *words).split()[0])
    assert tuple(found.values()) == tuple(summary["closures"][name] for name in ("proposed", "accepted", "false"))


def test_the_readmes_closure_is_explained(finished: tuple[Path, dict[str, Any]], tmp_path: Path) -> None:
    readme = (Path(__file__).parents[1] / "README.md").read_text()
    pair = re.search(r"--explain (\d+) (\d+)", readme)
    assert pair is not None
    assert "topomap run room-corridor --seed 7 --out runs/a" in readme, "the run that it is of"
    log = str(finished[0] / "run.mcap")
    said = asked("closures", log, "--explain", *pair.groups(), "--out", str(tmp_path))
    assert f"(node {pair[1]}) against node {pair[2]}" in said
    assert list(tmp_path.glob("closure-*.png"))


def test_ctrl_c_stops_the_wheels_closes_the_log_and_writes_the_summary(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "topomap", "run", "room-corridor", "--out", "cut"]
    process = subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    log = tmp_path / "cut" / "run.mcap"
    deadline = time.monotonic() + 120
    while not (log.exists() and log.stat().st_size > 500_000) and time.monotonic() < deadline:
        time.sleep(0.1)
    os.kill(process.pid, signal.SIGINT)
    out, errors = process.communicate(timeout=120)
    assert process.returncode == 130, errors
    assert b"Traceback" not in errors
    summary = json.loads((tmp_path / "cut" / "summary.json").read_text())
    data = load_run(log)
    assert 10 < summary["steps"] == len(data.stamps_ns) < 800
    assert summary["graph_hash"] == data.graph_hash != ""
    assert b"run.mcap" in out
