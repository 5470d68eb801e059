"""The same answers as before: a constant, a sign or a step that changes without being meant to shows here."""

from __future__ import annotations

import json
import math

import pytest
from answers import FILE, Figures, answers, names

GOLDEN: dict[str, dict[str, Figures]] = json.loads(FILE.read_text(encoding="utf8"))
CLOSE = 1e-4
"""Machines differ in the last digits of single precision, summed over a view."""


@pytest.mark.parametrize("name", names())
def test_it_answers_as_before(name: str) -> None:
    found, before = answers(name), GOLDEN[name]
    assert found.keys() == before.keys()
    for said, figures in found.items():
        assert len(figures) == len(before[said]), said
        for now, then in zip(figures, before[said], strict=True):
            assert (now is None) == (then is None), said
            if now is not None and then is not None:
                # bearings and rotations go round, and no distance, cost or confidence lies 2 pi from another one
                assert abs(math.remainder(now - then, math.tau)) < CLOSE * max(1.0, abs(then)), said


def test_nothing_is_left_of_methods_that_are_gone() -> None:
    assert set(GOLDEN) == set(names())
