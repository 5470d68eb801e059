from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from homing_fakes import Knowing, KnowingCompass, telling_recipe

from topomap.bench.homing import bench as homing_bench
from topomap.bench.homing.answers import Entry
from topomap.bench.homing.bench import BenchSettings, Table, bench, tasks
from topomap.bench.homing.contestant import Pairwise, compass, contestants
from topomap.bench.homing.field import HomeField, TurnsTask
from topomap.bench.homing.figures import method_figure, save, sheet
from topomap.bench.homing.rows import rows_of
from topomap.bench.homing.table import as_json, cells, title, unfit, write_table
from topomap.bench.pool import Store, workers
from topomap.core.errors import DataError

EXACT, TURNED, SILENT = (
    Pairwise("exact", Knowing()),
    Pairwise("turned", Knowing(bias=math.radians(50.0))),
    Pairwise("silent", Knowing(silent_beyond=0.2)),
)
FIXED = BenchSettings(starts=3)


def measured(
    *several: Pairwise, settings: BenchSettings = FIXED, store: Store | None = None, jobs: int = 1, seeds: int = 1
) -> Table:
    recipes = [telling_recipe(seed) for seed in range(seeds)]
    with workers(jobs, store or Store(None)) as hands:
        return bench(recipes, None, several, settings, hands, lambda: None)[0]


@pytest.fixture
def fake_compass(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(homing_bench, "compass", lambda name: KnowingCompass(math.radians(float(name))))


def test_the_table_says_what_the_methods_do() -> None:
    table = measured(TURNED, EXACT, SILENT, seeds=2)
    exact, silent, turned = (next(r for r in table.rows if r.method == n) for n in ("exact", "silent", "turned"))
    assert table.rows[0] is exact
    assert exact.places == 2 * 34
    assert exact.mean
    assert exact.mean.value == pytest.approx(0.0, abs=1e-6)
    assert exact.catchment
    assert exact.catchment.value == 1.0
    assert exact.success
    assert exact.success.value == 1.0
    assert exact.path_ratio is not None
    assert exact.path_ratio < 1.1
    assert turned.mean
    assert turned.mean.value == pytest.approx(50.0)
    assert turned.to_90
    assert turned.to_90.value == 1.0
    assert turned.behind
    assert (turned.behind.low, turned.behind.high) == pytest.approx((50.0, 50.0))
    assert silent.answered == pytest.approx(19 / 34)
    assert silent.above_90
    assert silent.above_90.value == pytest.approx(15 / 34)


def test_a_turned_view_is_aligned_by_what_the_compass_says(fake_compass: None) -> None:
    table = measured(EXACT, settings=BenchSettings(compass="0", starts=3))
    row = table.rows[0]
    assert row.mean
    assert row.mean.value < 1e-6
    assert row.success
    assert row.success.value == 1.0
    assert table.compass_error
    assert table.compass_error.value < 1e-6
    assert np.ptp(table.entries[0].grounds[0].turns.headings) > 3.0  # the views were turned at all


def test_an_error_of_the_compass_is_reported_and_turns_nothing_for_a_method_that_reads_bearings(
    fake_compass: None,
) -> None:
    table = measured(EXACT, settings=BenchSettings(compass="20", starts=0))
    assert table.compass_error
    assert table.compass_error.value == pytest.approx(20.0)
    assert table.rows[0].mean
    assert table.rows[0].mean.value < 1e-6


def test_a_method_without_need_of_a_compass_gets_the_views_as_they_are(fake_compass: None) -> None:
    own = Pairwise("own", Knowing(compass=False))
    table = measured(own, settings=BenchSettings(compass="90", starts=2))
    assert table.rows[0].mean
    assert table.rows[0].mean.value < 1e-6


def test_only_places_within_reach_count() -> None:
    assert measured(EXACT, settings=BenchSettings(starts=0, within=0.5)).rows[0].places == 4


def test_results_do_not_depend_on_the_number_of_processes() -> None:
    alone, together = measured(EXACT, TURNED, SILENT, seeds=2), measured(EXACT, TURNED, SILENT, seeds=2, jobs=2)
    for a, b in zip(alone.entries, together.entries, strict=True):
        assert a.name == b.name
        assert np.array_equal(a.errors(), b.errors())
        assert [w.path.tolist() for w, _ in a.walks()] == [w.path.tolist() for w, _ in b.walks()]


def test_a_second_call_measures_nothing_and_other_parameters_measure_anew(tmp_path: Path) -> None:
    first, again, other = Store(tmp_path), Store(tmp_path), Store(tmp_path)
    before = measured(EXACT, store=first)
    after = measured(EXACT, store=again)
    assert (first.hits, again.hits) == (0, 3)
    assert before.rows == after.rows  # even the milliseconds
    measured(Pairwise("exact", Knowing(bias=0.1)), store=other)
    assert other.hits == 2


def test_a_damaged_result_is_measured_anew(tmp_path: Path) -> None:
    measured(EXACT, store=Store(tmp_path))
    for path in list(tmp_path.glob("*/*.json")):
        path.write_bytes(path.read_bytes()[:20])
    store = Store(tmp_path)
    assert measured(EXACT, store=store).rows[0].places == 34
    assert store.hits == 0


def test_progress_counts_every_task() -> None:
    calls: list[None] = []
    with workers(1, Store(None)) as hands:
        bench([telling_recipe(0), telling_recipe(1)], None, [EXACT, TURNED], FIXED, hands, lambda: calls.append(None))
    assert len(calls) == tasks(2, 2)


def test_a_home_off_the_grid_is_refused() -> None:
    with workers(1, Store(None)) as hands, pytest.raises(DataError, match=r"no free grid position at 9,0; its grid"):
        bench([telling_recipe()], (9.0, 0.0), [EXACT], FIXED, hands, lambda: None)


def test_unknown_names_are_refused_with_what_there_is() -> None:
    with pytest.raises(DataError, match=r"unknown homing method 'nope'; there are .*min-warping"):
        contestants("min-warping,nope")
    with pytest.raises(DataError, match="unknown compass 'A9'; there are given, A1"):
        compass("A9")


def test_every_method_of_the_library_takes_part() -> None:
    from topomap.vision.homing import METHODS, POLICIES, REFERENCE_METHODS

    assert [one.name for one in contestants("all")] == [*METHODS, *REFERENCE_METHODS, *POLICIES]


def test_keys_tell_variants_apart() -> None:
    recipe = telling_recipe()
    keys = {TurnsTask(recipe, (0.0, 0.0), KnowingCompass(b)).key for b in (0.0, 0.1)}
    assert len(keys) == 2


def test_table_files_are_strict_json_and_csv(tmp_path: Path) -> None:
    table = measured(EXACT, TURNED)
    json_path, csv_path = write_table(table, tmp_path)
    found = json.loads(json_path.read_text())
    assert found == as_json(table)
    assert found["rows"][0]["mean"]["value"] == pytest.approx(0.0, abs=1e-6)
    lines = csv_path.read_text().splitlines()
    assert len(lines) == 3
    assert lines[0].startswith("method,places,mean,mean_low,mean_high,sd")
    assert cells(table.rows[0])[10] == "best"
    assert title(table) == "telling: 34 places, 1 seed, compass given"


def test_a_method_that_lacks_what_it_needs_is_named_and_not_drawn() -> None:
    table = measured(EXACT)
    entry = table.entries[0]
    lacking = HomeField(entry.fields[0].directions, entry.fields[0].ms, unfit="needs wings")
    row = rows_of([Entry("bird", entry.grounds, (lacking,))], FIXED.walking.reach, FIXED.draws)[0]
    spoilt = Table("telling", "given", (0,), (row,), (), None, None)
    assert unfit(spoilt) == {"needs wings": ["bird"]}


def test_pictures_are_the_same_bytes_every_time(tmp_path: Path) -> None:
    table = measured(EXACT, TURNED)
    one = save(method_figure(table, table.entries[0], table.rows[0]), tmp_path / "a.png").read_bytes()
    two = save(method_figure(table, table.entries[0], table.rows[0]), tmp_path / "b.png").read_bytes()
    assert one == two
    assert save(sheet(table), tmp_path / "sheet.png").stat().st_size > 5000
