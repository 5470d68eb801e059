"""Searches of robots set down anywhere: shares, the median way and how far what they said was off."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from topomap.app.kidnapped import draw
from topomap.bench.searches import HEADINGS, KEPT, Search, curve, kept_row, row, tally


def one(way: float, lost: list[float], wrong: list[bool], found: bool = True, right: bool = True) -> Search:
    return Search(found, right, way, np.array(lost), np.array(wrong))


SOME = [
    one(3.0, [0.9, 0.5, 0.01], [True, False, False]),
    one(12.0, [0.5, 0.3, 0.01], [True, False, False]),
    one(6.0, [0.9, 0.01], [True, True], right=False),
    one(35.0, [0.9, 0.5], [False, False], found=False, right=False),
]


def test_shares_are_of_all_starts_and_who_is_wrong_has_no_way() -> None:
    told = tally(SOME)
    assert (told.starts, told.soon.value, told.found.value, told.sure_and_wrong) == (4, 0.25, 0.5, 1)
    assert told.median_way == np.inf
    assert tally(SOME[:3]).median_way == 12.0
    assert tally(SOME[:2]).median_way == 7.5


def test_what_was_said_is_held_against_how_often_it_was_so() -> None:
    told = tally(SOME)
    assert [(one.steps, one.starts, one.said) for one in told.bins] == [
        (3, 3, pytest.approx(0.01)), (1, 1, 0.3), (3, 3, 0.5), (3, 3, pytest.approx(0.9))
    ]  # fmt: skip
    assert [one.wrong for one in told.bins] == pytest.approx([1 / 3, 0.0, 1 / 3, 2 / 3])
    off = 3 * (1 / 3 - 0.01) + 0.3 + 3 * (0.5 - 1 / 3) + 3 * (0.9 - 2 / 3)
    assert told.error == pytest.approx(off / 10)
    shown = curve(told)
    assert shown.count.tolist() == [3, 1, 3, 3]
    assert shown.true.tolist() == pytest.approx([1 / 3, 0.0, 1 / 3, 2 / 3])
    assert shown.error == told.error


def test_rows_fit_their_headings() -> None:
    told = tally(SOME)
    assert len(row(told)) == len(HEADINGS)
    kept = dict(zip(KEPT, kept_row("hall", 3, ["a=1", "b=2"], told), strict=True))
    assert kept["settings"] == "a=1 b=2"
    assert (kept["within 10 m"], kept["found"], kept["sure and wrong"]) == ("1", "2", "1")
    assert kept["lost: wrong (steps)"].startswith("0.010: 0.333 (3), 0.300: 0.000 (1)")


def test_the_curve_is_drawn(tmp_path: Path) -> None:
    path = draw({"examples/worlds/tree.toml": SOME, "hall": SOME[:2]}, tmp_path)
    assert path.read_bytes().startswith(b"\x89PNG")
