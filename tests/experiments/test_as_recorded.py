from __future__ import annotations

import json

import numpy as np
import pytest

from topomap.bench.pool import Store, workers
from topomap.core.geometry import wrap
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.experiments import Lab
from topomap.experiments import as_recorded as module
from topomap.experiments.altered import Altered, Fade
from topomap.experiments.as_recorded import Misheaded, as_recorded
from topomap.experiments.pillars import Pillar, Room, painted, room_arena
from topomap.vision.arena import Arena, Recipe
from topomap.vision.homing.did import BLURRED, WHOLE, ImageDescent
from topomap.vision.homing.moment import Moment
from topomap.vision.homing.view_vector import ViewVector
from topomap.vision.image.compare import signature

AREA = Moment(2.0, "equal", "area")


def small(name: str, seed: int, _options: tuple[str, ...] = ()) -> Arena:
    room = Room([Pillar(2.0, 1.0, 0.3, (30, 90, 200))], 4.0, painted(np.random.default_rng(seed)))
    return room_arena(name, room, 0.8, 0.4)


def views(count: int) -> list[Panorama]:
    """Views from random places of one small room."""
    arena = small("room", 0)
    return [arena.source.view(x, y, 0.0) for x, y in np.random.default_rng(1).uniform(-0.8, 0.8, (count, 2))]


def test_every_panel_has_its_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("OFF", (3.0,)), ("STEPS", (0.1,)), ("SHARES", (0.5,)), ("MATCHED", ("moment-rgb",))):
        monkeypatch.setattr(module, name, value)
    with workers(1, Store(None)) as hands:
        found = as_recorded(Lab(lambda room, seed, _: Recipe(room, seed, small), (0,), hands, lambda: None, every=24))
    assert len(found.figure.axes) == 6
    assert json.dumps(found.values, allow_nan=False)
    assert isinstance(found.values, dict)
    assert [len(rows) for rows in found.values.values()] == [1, 4, 1] * 2


def test_a_misheaded_view_is_turned_and_its_goal_is_not() -> None:
    one, *others = views(40)
    method = Misheaded(AREA, 6.0)
    assert method.describe(one)[0] == AREA.describe(one)
    turns = [np.degrees(wrap(angle(t) - angle(p))) for p, t in map(method.describe, others)]
    assert np.std(turns) == pytest.approx(6.0, rel=0.4)
    assert abs(np.mean(turns)) < 3.0
    straight = Misheaded(AREA, 0.0)
    assert straight.home(straight.describe(one), straight.describe(others[0])) == AREA.home(
        AREA.describe(one), AREA.describe(others[0])
    )
    assert method.home(method.describe(one), method.describe(others[0])) == AREA.home(
        method.describe(one)[1], AREA.describe(others[0])
    )


def angle(vector: ViewVector) -> float:
    """Return where a moment's vector points [rad]."""
    return float(np.arctan2(vector.y, vector.x))


def test_colours_fade_to_equal_ones() -> None:
    (view,) = views(1)
    coloured, equal = Moment(2.0, "rgb"), Moment(2.0, "equal").describe(view)
    assert angle(Altered(coloured, Fade(0.0)).describe(view)) == pytest.approx(angle(equal), abs=1e-6)
    assert Altered(coloured, Fade(1.0)).describe(view) == coloured.describe(view)
    assert angle(coloured.describe(view)) != pytest.approx(angle(equal), abs=1e-2)


def test_whole_pixels_are_all_of_them() -> None:
    rig = Rig()
    image = np.full((rig.height, rig.width, 3), 90, np.uint8)
    image[10, 20] = 250
    view = Panorama(image, None, rig)
    assert signature(view, WHOLE).pixels.shape == (rig.height, rig.width)
    assert int((signature(view, WHOLE).pixels > 0.0).sum()) == 1
    assert int((signature(view, BLURRED).pixels > 0.0).sum()) > 1
    assert ImageDescent(WHOLE).origin.source != ImageDescent().origin.source
