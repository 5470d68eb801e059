from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from graphs import ring_graph, ring_text
from typer.testing import CliRunner

from topomap.app.bench import available, parse_point, parse_seeds, request, run_study
from topomap.app.graph_bench import find_graph
from topomap.app.views import WorldViews, world_arena, world_recipe
from topomap.bench.homing.bench import BenchSettings
from topomap.bench.pool import Store
from topomap.bench.pose_graphs.bench import OURS
from topomap.cli.main import app
from topomap.core.errors import DataError, TopomapError
from topomap.experiments.results import read_results
from topomap.mapping.graph_engine import GraphVerdicts, optimise_graph
from topomap.mapping.pose_graph import PoseGraph


@pytest.fixture(scope="module")
def arena():  # type: ignore[no-untyped-def]
    return world_arena("a1original", 0, ())


def test_the_same_pose_gives_the_same_view_whatever_was_asked_before(arena) -> None:  # type: ignore[no-untyped-def]
    views: WorldViews = arena.source
    first = views.view(*arena.home, 0.3)
    views.view(arena.home[0] + 0.1, arena.home[1], 1.0)
    again = views.view(*arena.home, 0.3)
    assert np.array_equal(first.image, again.image)
    assert first.ranges is not None
    assert np.array_equal(first.ranges, again.ranges, equal_nan=True)


def test_sensors_are_noisy_unless_switched_off(arena) -> None:  # type: ignore[no-untyped-def]
    quiet = WorldViews(arena.source.world, 0, noise=False).view(*arena.home, 0.0)
    noisy = arena.source.view(*arena.home, 0.0)
    difference = noisy.image.astype(float) - quiet.image
    assert 1.0 < difference.std() < 3.0
    assert np.nanstd(noisy.ranges - quiet.ranges) == pytest.approx(0.01, rel=0.3)


def test_ranges_and_image_turn_with_the_robot(arena) -> None:  # type: ignore[no-untyped-def]
    quiet = WorldViews(arena.source.world, 0, noise=False)
    ahead, turned = quiet.view(*arena.home, 0.0), quiet.view(*arena.home, np.pi / 2)
    assert np.allclose(ahead.rolled(-180).ranges, turned.ranges, atol=1e-3)
    assert np.abs(ahead.rolled(-180).image.astype(float) - turned.image).mean() < 1.0


def test_the_declared_grid_is_used(arena) -> None:  # type: ignore[no-untyped-def]
    assert len(arena.positions) == 170
    assert arena.spacing == pytest.approx(0.3)


def test_seeds_and_points_are_read_or_refused() -> None:
    assert parse_seeds("0-2,5") == [0, 1, 2, 5]
    assert parse_point("1.5,-2") == (1.5, -2.0)
    for wrong in ("", "a", "3-1", "1-"):
        with pytest.raises(DataError, match="expected numbers like 0-4"):
            parse_seeds(wrong)
    with pytest.raises(DataError, match="expected X,Y in metres"):
        parse_point("1")


@pytest.mark.parametrize(
    ("env", "methods", "compass", "message"),
    [
        ("atlantis", "all", "given", "unknown environment 'atlantis'; there are a1original"),
        ("ourlab", "magic", "given", "unknown homing method 'magic'"),
        ("ourlab", "all", "A9", "unknown compass 'A9'"),
        ("", "all", "given", "name an environment"),
    ],
)
def test_unknown_words_are_refused(env: str, methods: str, compass: str, message: str) -> None:
    with pytest.raises(TopomapError, match=message):
        request(env, [], methods, "0", None, BenchSettings(compass=compass))


def test_the_command_writes_tables_and_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TOPOMAP_CACHE", str(tmp_path / "cache"))
    words = ["bench", "homing", "--env", "a1original", "--methods", "area-centroid,alv", "--starts", "2",
             "--jobs", "1", "--out", str(tmp_path / "out")]  # fmt: skip
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    folder = tmp_path / "out" / "a1original-given"
    assert {p.name for p in folder.iterdir()} == {
        "table.json", "table.csv", "sheet.png", "area-centroid.png", "alv.png"
    }  # fmt: skip
    best = json.loads((folder / "table.json").read_text())["rows"][0]
    assert best["method"] == "area-centroid"
    assert best["mean"]["value"] < 3.0
    assert best["success"]["value"] == 1.0


def test_studies_that_are_listed_can_be_made(tmp_path: Path) -> None:
    assert "occluded-landmarks" in [study.name for study in available()]
    written = run_study("occluded-landmarks", "0", Store(None), 1, lambda _: None, tmp_path)
    values = json.loads(written[1].read_text())["values"]
    assert values["DELV"]["y"][0] < values["DELV"]["y"][-1]
    with pytest.raises(DataError, match="unknown study 'nope'; there are "):
        run_study("nope", "0", Store(None), 1, lambda _: None, tmp_path)


def test_options_of_the_views_are_understood_or_refused() -> None:
    arena = world_arena("cylinders", 0, ("gain=0.6", "goal:gain=1", "noise=off"))
    lit, goal = arena.source.view(*arena.home, 0.0), arena.goal_source.view(*arena.home, 0.0)
    assert np.abs(lit.image.astype(float) - goal.image).mean() > 1.0
    for wrong in ("hour=25", "houre=3", "hour"):
        with pytest.raises(DataError, match="view option"):
            world_recipe("cylinders", 0, (wrong,))


def test_the_identity_of_a_world_knows_its_code() -> None:
    assert len(world_recipe("ourlab", 0).identity) == 128


def test_an_unknown_pose_graph_is_one_clear_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TOPOMAP_DATA", "/somewhere")
    with pytest.raises(DataError, match="no pose graph 'nowhere': neither a file nor /somewhere/pose-graphs/nowhere"):
        find_graph("nowhere")
    monkeypatch.delenv("TOPOMAP_DATA")
    with pytest.raises(DataError, match="set TOPOMAP_DATA to the folder of recorded data"):
        find_graph("intel")


def test_graphs_are_files_recorded_ones_or_examples_of_gtsam(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "pose-graphs").mkdir()
    for path in (tmp_path / "own.g2o", tmp_path / "pose-graphs" / "intel.g2o"):
        path.write_text("")
    monkeypatch.setenv("TOPOMAP_DATA", str(tmp_path))
    assert find_graph(str(tmp_path / "own.g2o")) == tmp_path / "own.g2o"
    assert find_graph("intel") == tmp_path / "pose-graphs" / "intel.g2o"
    assert find_graph("w100").name == "w100.graph"


def test_bench_graphs_writes_table_and_a_picture_a_kind(tmp_path: Path) -> None:
    ring = ring_graph(laps=2, false=0)
    (tmp_path / "own.g2o").write_text(ring_text(ring))
    words = ["bench", "graphs", "--graphs", str(tmp_path / "own.g2o"), "--kinds", "random,groups-5", "--shares", "0,.5",
             "--seeds", "0", "--peers", "DCS", "--limit", "30", "--out", str(tmp_path / "out")]  # fmt: skip
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    names = {"graphs.json", "graphs.csv", "graphs-random.png", "graphs-groups-5.png"}
    assert {path.name for path in (tmp_path / "out").iterdir()} == names
    whole = json.loads((tmp_path / "out" / "graphs.json").read_text())
    told = [(cell["kind"], cell["false_share"], cell["method"]) for cell in whole["cells"]]
    cases = (("none", 0.0), ("random", 0.5), ("groups-5", 0.5))
    assert told == [(kind, share, method) for kind, share in cases for method in ("topomap", "DCS")]
    assert result.output.count("falls short: ") == len(whole["short"])
    for line in whole["short"]:
        assert f"falls short: {line}" in result.output


def test_bench_graphs_that_is_interrupted_keeps_its_rows_and_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TOPOMAP_CACHE", str(tmp_path / "cache"))
    (tmp_path / "own.g2o").write_text(ring_text(ring_graph(laps=2, false=0)))
    kept, asked = tmp_path / "graphs.csv", []
    words = ["bench", "graphs", "--graphs", str(tmp_path / "own.g2o"), "--kinds", "random", "--shares", "0,.5,.8",
             "--seeds", "0", "--peers", "none", "--out", str(tmp_path / "out"), "--keep", str(kept)]  # fmt: skip

    def interrupted(graph: PoseGraph) -> GraphVerdicts:
        asked.append(len(graph.i))
        if len(asked) == 2:
            raise KeyboardInterrupt
        return optimise_graph(graph)

    monkeypatch.setattr("topomap.bench.pose_graphs.bench.optimise_graph", interrupted)
    assert CliRunner().invoke(app, words).exit_code != 0
    assert [(row["share"], row["contestant"]) for row in read_results(kept).rows] == [("0", OURS), ("0", "odometry")]
    assert CliRunner().invoke(app, words).exit_code == 0
    assert len(asked) == 4  # one, the interrupted one again, and the last
    assert [row["share"] for row in read_results(kept).rows if row["contestant"] == OURS] == ["0", "0.5", "0.8"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--shares", "0,1"], "--shares 0,1: expected numbers from 0 to below 1"),
        (["--shares", "half"], "--shares half: expected numbers"),
        (["--kinds", "evil"], "no kind 'evil': there are random, close, "),
        (["--peers", "Cauchy"], "no peer 'Cauchy': there are DCS, "),
        (["--graphs", "nowhere"], "no pose graph 'nowhere'"),
        (["--graphs", "w100", "--out", "/proc/none"], "/proc/none: the output folder can't be written"),
    ],
)
def test_bench_graphs_refuses_in_one_line(words: list[str], message: str, tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["bench", "graphs", "--out", str(tmp_path), *words])
    assert isinstance(result.exception, TopomapError)
    assert message in str(result.exception)
    assert "\n" not in str(result.exception)
