from __future__ import annotations

import re
from pathlib import Path

import pytest

from topomap.core.errors import DataError
from topomap.experiments import mission
from topomap.experiments.mission import mission_rows, mission_table

ROOT = Path(__file__).parents[2]
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
    assert (ROOT / "docs" / "THESIS.md").read_text(encoding="utf8") == mission_table()
