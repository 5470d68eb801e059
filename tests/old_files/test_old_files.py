"""A log and a map that the first version of the program wrote still load, and every command takes them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from maps import STEP_NS, square
from typer.testing import CliRunner

from topomap.cli.main import app
from topomap.datasets.g2o import read_graph
from topomap.mapping.mapfile import load_map, to_bytes
from topomap.recording.run_reader import load_run

HERE = Path(__file__).parent
LOG, MAP = HERE / "run.mcap", HERE / "run.topomap"
FIRST_HOUSE = HERE.parent / "golden" / "first-house.mcap"
"""A log with the map of its own run; the two above are of different ones."""


def test_the_map_is_the_one_that_was_saved() -> None:
    """A square of 17 snapshots, closed, with a pose node inserted; its hash as the first version gave it."""
    topo, made = load_map(MAP), square()
    made.insert(7 * STEP_NS)
    assert topo.hash([]) == "c60a63db219487f6a0e6b43aa93dd4d5d3ec74f785c6b80befa1b8aac6632651" == made.hash([])
    assert topo.turns == []
    assert to_bytes(topo) == to_bytes(made)


def test_the_log_is_the_run_that_was_written() -> None:
    run = load_run(LOG)
    assert (run.world, run.seed, run.graph_hash, run.claimed, run.goal_node) == ("room", 3, "cafe", True, 0)
    assert len(run.stamps_ns) == 30
    assert [decision.candidate.evidence.measured()["gate"] for decision in run.decisions] == [1.5, 1.5]
    assert np.allclose(run.final[29], [0.1 * 29 + 0.5, 0.01 * 29**2 + 0.5, 0.02 * 29 + 0.5])
    assert run.truth is not None


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["info", str(LOG)], "/map/graph"),
        (["report", str(LOG), "--out", "OUT"], "report.html"),
        (["export", str(LOG), "--tum", "--out", "OUT"], "map.tum"),
        (["export", str(FIRST_HOUSE), "--tum", "--g2o", "--out", "OUT"], "map.g2o"),
        (["closures", str(LOG)], "1 closure candidates of room"),
        (["closures", str(LOG), "--explain", "1", "0", "--out", "OUT"], "both say so"),
        (["closures", str(LOG), "--evaluate", "--out", "OUT"], "precision"),
        (["closures", str(MAP), "--withdraw", "0", "16", "--out", "OUT/new.topomap"], "withdrawn: nodes 0 and 16"),
    ],
)
def test_every_command_takes_them(words: list[str], said: str, tmp_path: Path) -> None:
    done = CliRunner().invoke(app, [word.replace("OUT", str(tmp_path)) for word in words])
    assert done.exit_code == 0, done.output
    assert said in done.output


def test_what_is_written_of_them_is_whole(tmp_path: Path) -> None:
    for command in (["export", "--tum"], ["report"]):
        done = CliRunner().invoke(app, [command[0], str(LOG), *command[1:], "--out", str(tmp_path)])
        assert done.exit_code == 0, done.output
    done = CliRunner().invoke(app, ["export", str(FIRST_HOUSE), "--g2o", "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert read_graph(tmp_path / "map.g2o").nodes == len(load_map(FIRST_HOUSE.with_suffix(".topomap")).nodes)
    assert len((tmp_path / "truth.tum").read_text().splitlines()) == 2 + 30
    assert json.loads((tmp_path / "summary.json").read_text())["steps"] == 30
