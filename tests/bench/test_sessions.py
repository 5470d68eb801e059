"""Maps of several drives judged by the truth."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from maps import RIG, increments
from typer.testing import CliRunner

from topomap.app.session_bench import Driven, MergeTask, _pruned, plan
from topomap.bench.sessions import GROWTH_HEAD, MERGE_HEAD, Growth, MapFigures, figures, growth_row
from topomap.cli.main import app
from topomap.core.encoded import encode
from topomap.core.errors import DataError
from topomap.core.geometry import Pose2
from topomap.mapping.graph import Node, Snapshot, TopoMap
from topomap.mapping.optimizer.problem import ClosureEdge

DEN = str(Path(__file__).parents[1] / "helpers" / "den.toml")
PLACES = 20
SPOT = np.diag([0.01, 0.01, 0.001])
VIEW = Snapshot(encode(np.zeros((RIG.height, RIG.width, 3), np.uint8)), None, RIG)


def twice_along(closed: dict[int, int]) -> tuple[TopoMap, dict[int, tuple[float, float, float]]]:
    """A line of PLACES metres driven twice from its beginning, a node a metre; closures of second to first pass."""
    topo = TopoMap()
    truths = {}
    for k in range(2 * PLACES):
        topo.add(Node(5 * k * 250_000_000, float(k), VIEW), increments(5 * (k - 1), 5, 0.0) if k else None)
        truths[k] = (float(k % PLACES), 0.0, 0.0)
    topo.poses[:] = [truths[k] for k in range(2 * PLACES)]
    for later, first in closed.items():
        topo.close(ClosureEdge(first, later, Pose2(), SPOT))
    return topo, truths


def test_a_place_seen_again_is_closed_by_a_true_closure_within_a_metre_of_way() -> None:
    topo, truths = twice_along({25: 5, 35: 15})
    found = figures(topo, truths)
    assert (found.nodes, found.closures, found.false, found.possible) == (2 * PLACES, 2, 0, PLACES)
    assert found.recall == pytest.approx(6 / PLACES)  # 24 to 26 and 34 to 36
    assert found.ate == pytest.approx(0.0, abs=1e-9)


def test_a_false_closure_is_counted_and_closes_nothing() -> None:
    topo, truths = twice_along({25: 5, 35: 13})
    found = figures(topo, truths)
    assert (found.false, found.recall) == (1, pytest.approx(3 / PLACES))
    turned = {**truths, 25: (5.0, 0.0, math.radians(21.0))}
    assert figures(topo, turned).false == 2


def test_without_another_pass_there_is_no_recall() -> None:
    topo, truths = twice_along({})
    away = {k: (x + 100.0 * (k >= PLACES), y, h) for k, (x, y, h) in truths.items()}
    assert math.isnan(figures(topo, away).recall)


def test_no_two_columns_have_one_name() -> None:
    """Rows that are added later to a kept table are put in its columns by their names."""
    assert len(set(MERGE_HEAD)) == len(MERGE_HEAD)
    assert len(set(GROWTH_HEAD)) == len(GROWTH_HEAD)


def test_growth_is_what_a_lap_adds_on_average() -> None:
    one = Growth("den", 0, (), (100, 101, 104), (1000, 1000, 1010), MapFigures(104, 9, 0, 50, 0.9, 0.02))
    assert one.by_nodes == pytest.approx(0.02)
    assert growth_row(one)[4:8] == ("100 to 104", "1 to 1", "+2.00 %", "+0.50 %")


def test_a_number_that_went_has_no_true_place_any_more(tmp_path: Path) -> None:
    """Another drive's node gets the number, and lies elsewhere."""
    topo, truths = twice_along({25: 5, 35: 15})
    left = _pruned(Driven(topo, truths), tmp_path / "a.topomap")
    assert len(left.map.names) < len(topo.names)
    assert set(left.truths) == set(left.map.names)


def test_two_drives_of_a_room_are_merged_and_a_map_is_gone_on_with(tmp_path: Path) -> None:
    file = tmp_path / "kept.csv"
    words = ["bench", "sessions", "--worlds", DEN, "--laps", "1", "--jobs", "1", "--fresh", "--keep", str(file)]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, f"{done.output} {done.exception!r}"
    merged = file.read_text().splitlines()[-1].split(",")
    assert merged[:2] == ["den", "0"]
    assert merged[7:9] == ["0", "0"], "none is false"
    assert float(merged[-1]) < 0.1
    grown = file.with_stem("kept-growth").read_text().splitlines()[-1].split(",")
    assert grown[3] == "1"
    assert float(grown[6].split()[0]) <= 2.0


def test_what_can_not_be_driven_by_parts_of_a_lap_is_said() -> None:
    assert plan(DEN, [0, 1], 0, []) == [MergeTask(DEN, 0, ()), MergeTask(DEN, 1, ())]
    assert len(plan(DEN, [0, 1], 3, [])) == 4
    with pytest.raises(DataError, match="--worlds: name one"):
        plan("", [0], 1, [])
    with pytest.raises(DataError, match=r"its laps must be whole, not 0\.8"):
        plan("room-corridor", [0], 1, [])
