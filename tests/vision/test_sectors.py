"""Two views compared direction by direction."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sceneries import WIDTH, scenery, seen, with_people

from topomap.core.geometry import TAU, wrap
from topomap.vision.image.compare import ARRIVAL, signature
from topomap.vision.image.sectors import REACH, SECTORS, agreement, correlations

HOME = scenery(0)


def test_the_same_view_is_the_same_in_all_directions_and_another_one_in_none() -> None:
    assert agreement(seen(HOME), seen(HOME), 0.0).sectors == SECTORS
    assert agreement(seen(scenery(99)), seen(HOME), 0.0).sectors == 0


@pytest.mark.parametrize("hidden", [[2, 3, 7], [0, 1, 2, 3, 8, 9, 10]])
def test_what_is_hidden_then_or_now_leaves_the_other_directions_as_they_were(hidden: list[int]) -> None:
    left = SECTORS - len(hidden)
    # the blur of a signature carries a little of what is hidden beyond its edges
    assert left - 2 <= agreement(seen(with_people(HOME, hidden)), seen(HOME), 0.0).sectors <= left
    assert left - 2 <= agreement(seen(HOME), seen(with_people(HOME, hidden)), 0.0).sectors <= left


def test_a_view_turned_by_other_than_is_expected_is_found_within_reach() -> None:
    columns = 30
    turned = np.roll(HOME, columns, axis=1)
    # what lies thirty columns on was seen by a robot that is turned by as many
    angle = next(a for a in (columns * TAU / WIDTH, -columns * TAU / WIDTH)
                 if agreement(seen(turned), seen(HOME), a).sectors == SECTORS)  # fmt: skip
    near = agreement(seen(turned), seen(HOME), wrap(angle + REACH / 2))
    assert near.sectors >= SECTORS - 1
    assert abs(wrap(near.rotation - angle)) < 0.03
    assert agreement(seen(turned), seen(HOME), wrap(angle + 4 * REACH)).sectors <= 2


def test_where_there_is_nothing_to_see_nothing_agrees() -> None:
    blank = HOME.copy()
    blank[:, : WIDTH // 2] = 127
    pixels = signature(seen(blank), ARRIVAL).pixels.astype(np.float64)
    alike = correlations(pixels[None], pixels)[0]
    middle = alike[1 : SECTORS // 2 - 1]  # the blur carries something into the outer ones
    assert np.abs(middle).max() == 0.0
    assert alike[SECTORS // 2 + 1 : -1].min() == pytest.approx(1.0)
    assert not math.isnan(alike.sum())
