from __future__ import annotations

import re
from pathlib import Path

import pytest

from topomap.core.errors import DataError
from topomap.experiments import STUDIES, mission
from topomap.experiments.mission import MissionRow, mission_rows, mission_table
from topomap.experiments.mission_results import Homing, _grids
from topomap.experiments.results import read_results

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "docs" / "results"
FIGURES = {"2": 25, "3": 36, "4": 35, "5": 51, "A": 11}
TABLES = {"3": 6, "4": 2, "5": 4}


def named(item: str) -> set[str]:
    """The figures and tables an item names, ranges written out."""
    found: set[str] = set()
    for part in (p.strip() for p in item.split(",")):
        chapter, _, last = part.replace("Table ", "").partition(".")
        first, _, end = last.partition("-")
        if end:
            end = end.rpartition(".")[2]
        numbers = range(int(first), int(end or first) + 1) if first.isdigit() else []
        found |= {f"{'Table ' if 'Table' in part else ''}{chapter}.{n}" for n in numbers}
    return found


def test_every_figure_and_table_of_the_thesis_has_a_row() -> None:
    there = set().union(*(named(row.item) for row in mission_rows()))
    assert there >= {f"{c}.{n}" for c, most in FIGURES.items() for n in range(1, most + 1)}
    assert there >= {f"Table {c}.{n}" for c, most in TABLES.items() for n in range(1, most + 1)}


def test_every_test_that_a_row_names_is_there() -> None:
    for row in mission_rows():
        if row.test == "-":
            assert row.ours.startswith(("illustration:", "open:")), row.item
            continue
        file, _, name = row.test.partition("::")
        found = list((ROOT / "tests").rglob(file))
        assert found, row.test
        assert not name or any(re.search(rf"def {name}\b", path.read_text()) for path in found), row.test


def test_a_row_with_an_empty_cell_or_an_unknown_name_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    for line, said in (("9.9 | x | - | - |  | y", "empty cell"), ("9.9 | x | method no-such | - | y | z", "no method")):
        monkeypatch.setattr(mission, "ROWS", line)
        with pytest.raises(DataError, match=said):
            mission_rows()


def test_the_document_is_what_the_command_writes() -> None:
    assert (ROOT / "docs" / "THESIS.md").read_text(encoding="utf8") == mission_table(RESULTS)


def test_no_row_sends_the_reader_away_to_find_out() -> None:
    for row in mission_rows():
        assert not row.ours.startswith(("open:", "run the stud")), row.item


def test_a_row_is_open_as_long_as_the_figures_it_points_to_are_not_kept(tmp_path: Path) -> None:
    row = MissionRow("9.9", "x", "-", "-", "y", "see The studies: delv and tilt, more")
    assert mission.standing(row, tmp_path).ours.startswith("open: not run yet: study delv, study tilt, study more; see")
    (tmp_path / "studies.csv").write_text("study,series\ndelv,a\ntilt,b\nmore,c\n")
    assert mission.standing(row, tmp_path) == row
    spaced = MissionRow("9.9", "x", "-", "-", "y", "see Milestone spacing")
    assert mission.standing(spaced, tmp_path).ours.startswith("open: not run yet: spacing.csv")


def test_every_study_that_a_row_points_to_is_one() -> None:
    for row in mission_rows():
        for several in mission.POINTS.findall(row.ours):
            assert {name.strip() for name in re.split(r", | and ", several)} <= set(STUDIES), row.item


def test_figures_in_braces_are_those_that_are_kept() -> None:
    homing = Homing(read_results(RESULTS / "homing.csv"))
    row = MissionRow("9.9", "x", "-", "-", "y", "ours {ourlab given did}")
    assert mission.measured(row, homing).ours == f"ours {homing.said('ourlab', 'given', 'did')}"
    with pytest.raises(DataError, match="has no row ourlab,A6,no-such"):
        mission.measured(MissionRow("9.9", "x", "-", "-", "y", "{ourlab A6 no-such}"), homing)


def test_a_broken_file_of_figures_is_refused(tmp_path: Path) -> None:
    broken = tmp_path / "a.csv"
    broken.write_text("# topomap x\na,b\n1\n")
    with pytest.raises(DataError, match=r"a\.csv: 1: 1 cells under 2 headings"):
        read_results(broken)
    with pytest.raises(DataError, match="can't be read"):
        read_results(tmp_path / "none.csv")


def test_methods_that_are_equally_good_stand_in_order_of_their_names() -> None:
    names = [f"method-{k:02d}" for k in range(30)]
    row = {"environment": "grid", "within": "0.1", "mean": "3.4", "low": "1.0", "high": "5.8", "n": "4"}
    lines = _grids([{"method": name, **row} for name in names])
    assert [line.split("`")[1] for line in lines[2:]] == names
