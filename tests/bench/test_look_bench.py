"""The bench of looks: what separates is found, every world counts alike, and a small drive gives curve and weights."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from topomap.app.look_bench import plan, run_looks, write_looks
from topomap.app.sweep import variants
from topomap.bench.looks.fit import balanced, curves, fit
from topomap.bench.looks.survey import Row
from topomap.bench.pool import Store
from topomap.core.errors import DataError
from topomap.mapping.closures.looks import WITH_RIVALS, Weights, log_ratio

DEN = str(Path(__file__).parents[1] / "helpers" / "den.toml")


def drawn(weights: Weights, number: int = 4000, world: str = "made up") -> list[Row]:
    """Rows whose truth follows the weights, for prior odds of one."""
    rng = np.random.default_rng(0)
    rows = []
    for cost, rival, usual in rng.uniform([0.3, 0.5, 0.5], [0.9, 1.0, 1.2], (number, 3)).tolist():
        said = float(weights.none + weights.rival * np.log(rival / cost) + weights.usual * np.log(usual / cost))
        true = rng.uniform() < 1 / (1 + np.exp(-said))
        rows.append(Row(world, 0, cost, rival, usual, said, 0.0, 0.0, bool(true)))
    return rows


def test_the_fit_finds_what_the_rows_were_drawn_by() -> None:
    rows = drawn(Weights(-1.0, 4.0, 3.0))
    share = np.mean([row.true for row in rows])
    found = fit(rows)
    # true and false ones count alike, whatever their shares are
    assert found.none == pytest.approx(-1.0 - np.log(share / (1 - share)), abs=0.2)
    assert found.rival == pytest.approx(4.0, abs=0.5)
    assert found.usual == pytest.approx(3.0, abs=0.5)
    assert fit(rows, rivals=False).rival == 0.0


def test_every_world_counts_alike() -> None:
    rows = [*drawn(Weights(0.0, 3.0, 0.0), 300), *drawn(Weights(0.0, 3.0, 0.0), 60, "small")]
    weight = balanced(rows)
    for world in ("made up", "small"):
        for true in (True, False):
            own = [row.world == world and row.true is true for row in rows]
            assert weight[own].sum() == pytest.approx(1.0)


def test_looks_that_say_too_much_show_in_the_curve() -> None:
    rows = drawn(Weights(0.0, 3.0, 0.0))
    share = np.mean([row.true for row in rows])
    rows = [replace(row, looks=row.looks - float(np.log(share / (1 - share)))) for row in rows]
    boastful = [replace(row, looks=4 * row.looks) for row in rows]
    assert curves(rows)["all"].error < 0.03
    assert curves(boastful)["all"].error > 0.1


def test_a_small_drive_gives_curve_and_weights(tmp_path: Path) -> None:
    tasks = plan(
        [DEN],
        [0],
        ["sim.camera.width=180", "sim.camera.forward_column=90", "sim.laser.rays=180"],
        variants(["sim.driver.lateral_offset=[0, 0.1]"], None),
    )
    assert len(tasks) == 2
    done: list[int] = []
    rows = run_looks(tasks, Store(tmp_path / "kept"), 1, done.append)
    assert done == [1, 2]
    kept = Store(tmp_path / "kept")
    assert run_looks(tasks, kept, 1, done.append) == rows
    assert kept.hits == 2
    assert sum(row.true for row in rows) >= 3
    assert all(row.true == (row.distance <= 1.0 and abs(row.rotation) <= np.radians(20)) for row in rows)
    assert {row.looks for row in rows} == {log_ratio(WITH_RIVALS, row.cost, row.rival, row.usual) for row in rows}
    table, curve = write_looks(rows, tmp_path)
    assert json.loads(table.read_text())["true"] == sum(row.true for row in rows)
    assert curve.read_bytes().startswith(b"\x89PNG")


def test_where_all_are_true_there_is_a_curve_and_no_weights(tmp_path: Path) -> None:
    rows = [row for row in drawn(Weights(0.0, 3.0, 0.0), 200) if row.true]
    table, _ = write_looks(rows, tmp_path)
    said = json.loads(table.read_text())
    assert (said["with_rivals"], said["false"]) == (None, 0)


def test_a_drive_without_likenesses_is_one_line() -> None:
    with pytest.raises(DataError, match="no place looked like an older one"):
        run_looks([], Store(None), 1, lambda _: None)
