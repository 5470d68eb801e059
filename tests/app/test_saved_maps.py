"""Saved maps in a small room: travelled on, gone on with, merged, pruned; the truth decides what is right."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import Result
from typer.testing import CliRunner

from topomap.cli.main import app
from topomap.core.arrays import Image
from topomap.core.encoded import decode
from topomap.core.errors import TopomapError
from topomap.core.geometry import wrap
from topomap.evaluation.trajectory import ate
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapfile import load_map
from topomap.recording.true_nodes import read_truths, truth_file

DEN = Path(__file__).parents[1] / "helpers" / "den.toml"


def call(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


def run(out: Path, *words: object) -> dict[str, object]:
    done = call("run", DEN, "--out", out, *words)
    assert done.exit_code == 0, f"{done.output} {done.exception!r}"
    summary: dict[str, object] = json.loads((out / "summary.json").read_text())
    return summary


@pytest.fixture(scope="module")
def taught(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A map of one round and a little more, with a named place."""
    folder = tmp_path_factory.mktemp("taught")
    run(folder, "--mission", "teach", "--set", "sim.driver.laps=1.2")
    done = call("map", "places", folder / "run.topomap", "--add", "desk=5")
    assert "node 5 at" in done.output
    return folder / "run.topomap"


@pytest.fixture(scope="module")
def second(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive of its own that begins elsewhere, with another odometer."""
    folder = tmp_path_factory.mktemp("second")
    run(folder, "--mission", "teach", "--seed", 1, "--set", "sim.driver.laps=2.0", "--set", "sim.start.along=5")
    return folder / "run.topomap"


def truths(path: Path, topo: TopoMap) -> np.ndarray:
    known = read_truths(truth_file(path))
    return np.array([known[name] for name in topo.names])


def false_closures(path: Path) -> int:
    topo = load_map(path)
    true = truths(path, topo)
    away = [np.hypot(*(true[c.i] - true[c.j])[:2]) for c in topo.closures]
    turned = [abs(wrap(c.relative.heading - true[c.j, 2] + true[c.i, 2])) for c in topo.closures]
    return sum(a > 1.0 or t > np.radians(20) for a, t in zip(away, turned, strict=True))


def test_it_travels_on_a_saved_map_and_the_log_replays(taught: Path, tmp_path: Path) -> None:
    summary = run(tmp_path / "desk", "--map", taught, "--mission", "goto:desk", "--start", 0, "--seed", 1)
    home = summary["home"]
    assert isinstance(home, dict)
    assert home["claimed"]
    assert home["within_0_3_m"], "judged by where the saved node truly is"
    done = call("replay", tmp_path / "desk" / "run.mcap", "--out", tmp_path / "again")
    assert "The graph hash is the run's." in done.output


def test_a_map_whose_truth_nobody_kept_is_travelled_on_without_being_judged(taught: Path, tmp_path: Path) -> None:
    """A map file that was copied alone: where its nodes truly are isn't known, and the run ended in a traceback."""
    alone = tmp_path / "alone.topomap"
    shutil.copy(taught, alone)
    summary = run(tmp_path / "desk", "--map", alone, "--mission", "goto:desk", "--start", 0, "--seed", 1)
    home = summary["home"]
    assert isinstance(home, dict)
    assert (home["claimed"], home["within_0_3_m"], home["error_m"]) == (True, None, None)
    assert home["path_ratio"] is None
    assert home["shortest_ratio"] is None


def test_a_patrol_has_the_time_that_its_ways_take(
    taught: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("topomap.app.runs.STEPS_SPARE", 0)  # nothing else is granted than what the ways take
    words = ("--map", taught, "--mission", "patrol:desk,0,desk", "--start", 0, "--seed", 1)
    summary = run(tmp_path / "patrol", *words)
    legs = summary["legs"]
    assert isinstance(legs, list)
    assert [leg["claimed"] and leg["within_0_3_m"] for leg in legs] == [True] * 3
    assert legs[0]["way_m"] + legs[1]["way_m"] + legs[2]["way_m"] > 5.0
    assert all(leg["path_ratio"] < 1.3 and leg["collisions"] == 0 for leg in legs)


def test_put_down_anywhere_it_finds_itself_and_goes_where_it_was_sent(taught: Path, tmp_path: Path) -> None:
    summary = run(tmp_path, "--map", taught, "--mission", "goto:desk", "--at", "3.0,3.0,170", "--seed", 3)
    home = summary["home"]
    assert isinstance(home, dict)
    assert home["claimed"]
    assert home["within_0_3_m"]


@pytest.fixture(scope="module")
def gone_on(taught: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, object]]:
    """A lap more on the taught map: its folder, with the map pruned beside it, and its summary."""
    folder = tmp_path_factory.mktemp("gone_on")
    more = ("--map", taught, "--mission", "teach", "--start", 0, "--seed", 2, "--set", "sim.driver.laps=1")
    summary = run(folder, *more)
    done = call("map", "prune", folder / "run.topomap", "--out", folder / "pruned.topomap")
    assert done.exit_code == 0
    return folder, summary


def test_a_map_is_gone_on_with(taught: Path, gone_on: tuple[Path, dict[str, object]]) -> None:
    folder, summary = gone_on
    before, after = load_map(taught), load_map(folder / "run.topomap")
    assert after.names[: len(before.names)] == before.names
    assert after.places == before.places
    assert len(after.closures) >= len(before.closures) + 3
    assert false_closures(folder / "run.topomap") == 0
    closures = summary["closures"]
    assert isinstance(closures, dict)
    assert closures["recall"] > 0.9
    assert ate(after.poses, truths(folder / "run.topomap", after)) < 0.05

    pruned = load_map(folder / "pruned.topomap")
    assert len(pruned.nodes) <= 1.02 * len(before.nodes)
    known = {name: after.poses[node].tolist() for node, name in enumerate(after.names)}
    assert {name: pruned.poses[node].tolist() for node, name in enumerate(pruned.names)}.items() <= known.items()


def test_a_pruned_map_does_not_grow_on_known_ground(taught: Path, gone_on: tuple[Path, dict[str, object]]) -> None:
    assert (gone_on[0] / "pruned.topomap").stat().st_size <= 1.02 * taught.stat().st_size


def test_two_maps_become_one(taught: Path, second: Path, tmp_path: Path) -> None:
    out = tmp_path / "both.topomap"
    done = call("map", "merge", taught, second, "--out", out)
    assert done.exit_code == 0, f"{done.output} {done.exception!r}"
    a, b, both = load_map(taught), load_map(second), load_map(out)
    assert both.names[: len(a.names)] == a.names
    assert both.names[len(a.names) :] == [name + max(a.names) + 1 for name in b.names]
    assert len(both.closures) >= len(a.closures) + len(b.closures) + 5
    assert false_closures(out) == 0
    assert ate(both.poses, truths(out, both)) < 0.05
    measured = a.calibration.distance_scale
    assert both.calibration.distance_scale == pytest.approx(measured, rel=1e-4), "places seen again would bend it"


def test_what_a_map_has_not_is_said_before_anything_moves(taught: Path, tmp_path: Path) -> None:
    for words, said in (
        (("--mission", "goto:kitchen"), "no place 'kitchen' on the map; there are places desk"),
        (("--mission", "patrol:desk,999"), "no node 999 on the map: it has nodes 0 to"),
        (("--mission", "home", "--start", "999"), "no node 999"),
        (("--mission", "fly"), "expected teach, home, goto"),
        (("--at", "1"), "no such place"),
        (("--at", "1,2,3,4"), "expected X,Y or X,Y,DEGREES"),
    ):
        done = call("run", DEN, "--map", taught, "--out", tmp_path / "no", *words)
        assert isinstance(done.exception, TopomapError), words
        assert said in str(done.exception)
        assert "\n" not in str(done.exception)
    assert not (tmp_path / "no").exists()
    assert isinstance(call("run", DEN, "--start", "0").exception, TopomapError)


def test_the_formats_of_other_programs(taught: Path, tmp_path: Path) -> None:
    done = call("map", "export", taught, "--out", tmp_path)
    assert done.exit_code == 0, done.output
    topo = load_map(taught)
    held = json.loads((tmp_path / "map.json").read_text())
    assert [node["node"] for node in held["nodes"]] == topo.names
    assert held["places"] == {"desk": 5}
    features = json.loads((tmp_path / "map.geojson").read_text())["features"]
    assert len(features) == len(topo.nodes) + topo.graph.number_of_edges()
    assert (tmp_path / "map.g2o").read_text().count("VERTEX_SE2") == len(topo.nodes)
    assert (tmp_path / "map.tum").read_text().splitlines()
    assert (tmp_path / "map.png").read_bytes()[:4] == b"\x89PNG"
    assert "with a view" in call("map", "info", taught).output


def as_png(image: Image) -> bytes:
    """The image as PNG is usually packed, one channel."""
    return cv2.imencode(".png", image[:, :, 0], [cv2.IMWRITE_PNG_COMPRESSION, 9])[1].tobytes()


def test_a_small_map_is_small_and_leads_home(tmp_path: Path) -> None:
    summary = run(tmp_path, "--set", "stack.mapper.snapshots.view=90x12x4")
    topo = load_map(tmp_path / "run.topomap")
    assert topo.view == "90x12x4"
    images = [node.snapshot.encoded for node in topo.nodes if node.snapshot is not None]
    assert max(map(len, images)) < 450
    usual = sum(len(as_png(decode(image))) for image in images)
    assert sum(map(len, images)) < 0.95 * usual, "a small view is mostly runs of one tone"
    home, closures = summary["home"], summary["closures"]
    assert isinstance(home, dict)
    assert isinstance(closures, dict)
    assert home["within_0_3_m"]
    assert closures["false"] == 0
    size = (tmp_path / "run.topomap").stat().st_size / 1000
    distance = summary["distance_m"]
    assert isinstance(distance, float)
    assert size / distance * 100 < 120
