from __future__ import annotations

import json

import numpy as np
import pytest

from topomap.bench.pool import Store, workers
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.experiments import Lab
from topomap.experiments import orderings as module
from topomap.experiments.altered import Altered, Smooth
from topomap.experiments.orderings import orderings
from topomap.experiments.pillars import Pillar, Room, painted, room_arena
from topomap.vision.arena import Arena, Recipe
from topomap.vision.homing.moment import Moment

RGB = Moment(2.0, "rgb")


def small(name: str, seed: int, _options: tuple[str, ...] = ()) -> Arena:
    room = Room([Pillar(2.0, 1.0, 0.3, (30, 90, 200))], 4.0, painted(np.random.default_rng(seed)))
    return room_arena(name, room, 0.8, 0.4)


def striped(width: int) -> Panorama:
    """Stripes of two colours, so many columns wide, with ranges that differ ahead and astern."""
    rig = Rig()
    image = np.full((rig.height, rig.width, 3), 90, np.uint8)
    image[:, (np.arange(rig.width) // width) % 2 == 0] = (200, 40, 40)
    ranges = 2.0 + np.cos(np.arange(rig.width) * np.pi * 2 / rig.width)
    return Panorama(image, ranges.astype(np.float32), rig)


def test_every_panel_has_its_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("STEPS", (0.1,)), ("SIGMAS", (8.0,)), ("WARPED", ()), ("SEEN", {"as taught": ()})):
        monkeypatch.setattr(module, name, value)
    with workers(1, Store(None)) as hands:
        found = orderings(Lab(lambda room, seed, _: Recipe(room, seed, small), (0,), hands, lambda: None, every=24))
    assert len(found.figure.axes) == 5
    assert json.dumps(found.values, allow_nan=False)
    assert isinstance(found.values, dict)
    assert {len(rows) for rows in found.values.values()} == {1, 3, 4}


def test_smoothing_takes_fine_stripes_their_weight_and_leaves_broad_ones() -> None:
    plain = striped(720)
    assert Altered(RGB, Smooth(8.0)).describe(plain).x == pytest.approx(RGB.describe(plain).x, rel=1e-3)
    assert Altered(RGB, Smooth(0.0)).describe(striped(4)).x == RGB.describe(striped(4)).x
    fine, soft = RGB.describe(striped(90)), Altered(RGB, Smooth(32.0)).describe(striped(90))
    assert (soft.x, soft.y) != pytest.approx((fine.x, fine.y), rel=1e-3)
