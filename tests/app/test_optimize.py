"""topomap optimize: anybody's pose graph in, poses, verdicts, picture, summary and report out."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from graphs import LAP, RingGraph, ring_graph, ring_text
from typer.testing import CliRunner

from topomap.app.optimize import default_folder, optimize
from topomap.cli.main import app
from topomap.core.errors import DataError
from topomap.datasets.g2o import read_graph
from topomap.evaluation.trajectory import ate

FILES = {"optimized.g2o", "poses.tum", "closures.csv", "map.png", "summary.json", "report.html"}
EXAMPLE = Path(__file__).parents[2] / "examples" / "graphs" / "ring.g2o"


def run(*words: str) -> str:
    result = CliRunner().invoke(app, ["optimize", *words])
    assert result.exit_code == 0, result.output
    return result.output


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "closures.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def kept(folder: Path, ring: RingGraph) -> tuple[int, int]:
    """How many true and false closures were accepted."""
    good = np.array([row["verdict"] == "accepted" for row in rows(folder)])
    return int((good & ~ring.false).sum()), int((good & ring.false).sum())


def poses_of(folder: Path) -> np.ndarray:
    return np.loadtxt(folder / "poses.tum")[:, 1:3]


def test_a_ring_with_false_closures_becomes_a_ring(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    ring = ring_graph(group=5)
    Path("some ring.g2o").write_text(ring_text(ring))
    said = run("some ring.g2o")
    out = Path("runs") / "some ring"
    assert {path.name for path in out.iterdir()} == FILES
    assert "\x1b" not in said
    assert str(out / "closures.csv") in said
    true, false = kept(out, ring)
    assert false == 0
    assert true >= 0.9 * (~ring.false).sum()
    assert ate(poses_of(out), ring.truth) < 0.3 * ate(ring.graph.dead_reckoning(), ring.truth)
    summary = json.loads((out / "summary.json").read_text())
    assert summary["closures"] == {"offered": 44, "accepted": true, "refused": 44 - true}
    assert (summary["graph"], summary["poses"], summary["chains"]) == ("some ring", 144, 1)
    assert summary["chi2"]["closures"] < 0.01 * summary["chi2"]["closures_at_dead_reckoning"]
    report = (out / "report.html").read_text()
    assert f"{true} of 44 accepted" in report
    assert summary["kept"] in report


def test_results_are_written_under_the_ids_and_in_the_order_of_the_file(tmp_path: Path) -> None:
    ring = ring_graph()
    ids = 1000 + 7 * np.arange(ring.graph.nodes)
    (tmp_path / "ids.g2o").write_text(ring_text(ring, ids))
    run(str(tmp_path / "ids.g2o"), "--out", str(tmp_path / "out"))
    told = rows(tmp_path / "out")
    assert [(int(row["i"]), int(row["j"])) for row in told] == list(
        zip(ids[ring.graph.i].tolist(), ids[ring.graph.j].tolist(), strict=True)
    )
    assert np.loadtxt(tmp_path / "out" / "poses.tum")[:, 0].tolist() == ids.tolist()
    again = read_graph(tmp_path / "out" / "optimized.g2o")
    accepted = [(int(row["i"]), int(row["j"])) for row in told if row["verdict"] == "accepted"]
    assert again.names.tolist() == ids.tolist()
    assert list(zip(again.names[again.i].tolist(), again.names[again.j].tolist(), strict=True)) == accepted
    assert all(row["reason"] for row in told)


@pytest.mark.parametrize("gaps", [(70,), (LAP - 1, 2 * LAP - 1)])
def test_gaps_and_several_chains_are_joined_by_closures(tmp_path: Path, gaps: tuple[int, ...]) -> None:
    ring = ring_graph(false=4).without(gaps)
    (tmp_path / "chains.g2o").write_text(ring_text(ring))
    run(str(tmp_path / "chains.g2o"), "--out", str(tmp_path / "out"))
    true, false = kept(tmp_path / "out", ring)
    assert false == 0
    assert true > 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["chains"] == 1 + len(gaps)
    written = (tmp_path / "out" / "optimized.g2o").read_text()
    assert not any(f"EDGE_SE2 {k} {k + 1} " in written for k in gaps)


def test_a_graph_without_closures_stays_dead_reckoning(tmp_path: Path) -> None:
    text = ring_text(ring_graph(false=0, laps=1))
    (tmp_path / "chain.g2o").write_text(text)
    run(str(tmp_path / "chain.g2o"), "--out", str(tmp_path / "out"))
    assert np.allclose(
        poses_of(tmp_path / "out"), read_graph(tmp_path / "chain.g2o").dead_reckoning()[:, :2], atol=1e-6
    )
    assert (tmp_path / "out" / "closures.csv").read_text() == "i,j,verdict,log_odds,reason\n"


def test_files_of_one_name_have_folders_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in ("a", "b"):
        Path(folder).mkdir()
        Path(folder, "ring.g2o").write_text(ring_text(ring_graph(false=0, laps=1)))
    run("a/ring.g2o")
    run("b/ring.g2o")
    run("a/ring.g2o")
    assert {path.name for path in Path("runs").iterdir()} == {"ring", "ring-2"}
    assert default_folder(Path("b/ring.g2o")) == Path("runs/ring-2")
    assert default_folder(Path("a/other.g2o")) == Path("runs/other")


def test_a_folder_that_cannot_be_written_is_told_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for out in (Path("/proc/none"), Path("/proc"), tmp_path / "file" / "below"):
        heard: list[float] = []
        with pytest.raises(DataError, match=f"{out}: the output folder can't be written"):
            optimize(EXAMPLE, out, lambda done, _, heard=heard: heard.append(done))
        assert heard == []


def test_the_example_that_ships_tells_its_dozen_false_ones(tmp_path: Path) -> None:
    heard: list[tuple[float, str]] = []
    optimize(EXAMPLE, tmp_path, lambda done, what: heard.append((done, what)))
    verdicts = [row["verdict"] for row in rows(tmp_path)]
    assert verdicts.count("accepted") == 32
    assert verdicts[32:] == ["refused"] * 12
    assert [done for done, _ in heard] == sorted(done for done, _ in heard)
    assert heard[-1][0] == 1.0
