"""Many journeys over one taught map, judged by the truth."""

from __future__ import annotations

import json
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from topomap.app.config import load_config
from topomap.app.disturbed import Disturbance
from topomap.app.journey_bench import request, rows, write
from topomap.app.journeys import Taught, journeys, teach
from topomap.bench.journeys import Journey, Watched, tally
from topomap.core.errors import DataError

HELPERS = Path(__file__).parent.parent / "helpers"


@pytest.fixture(scope="module")
def taught() -> Taught:
    return teach(str(HELPERS / "den.toml"), 0, 0, load_config(None, ["sim.driver.laps=0.35"]))


def test_every_journey_begins_with_the_map_as_it_was_taught(taught: Taught) -> None:
    before = taught.mapper.graph_hash()
    plain, again, turned, black = journeys(
        taught, 0, [Disturbance(), Disturbance(), Disturbance("turned"), Disturbance("black")]
    )
    assert taught.mapper.graph_hash() == before
    assert plain.home
    assert again.home
    assert plain.error < 0.1
    assert turned.claimed == turned.home
    assert not black.claimed
    assert "the camera shows nothing" in black.last
    table = rows([plain, again, turned, black])
    assert [row[1:3] for row in table] == [("none", "2"), ("turned", "1"), ("black", "1")]


def told(**values: object) -> Journey:
    """A journey that went well, with other values."""
    plain = {
        "world": "den", "kind": "none", "goal": 0, "claimed": True, "error": 0.1, "planned": 2.0, "ratio": 1.1,
        "speed": 0.3, "standing": 0.1, "collisions": 1, "seconds": 9.0, "last": "goal reached",
    }  # fmt: skip
    return Journey(**{**plain, **values})


def test_a_claim_farther_off_than_30_cm_is_false_and_counts_as_no_homecoming() -> None:
    made = [told(), told(error=0.31), told(claimed=False), told(claimed=False, error=5.0)]
    assert [one.home for one in made] == [True, False, False, False]
    assert [one.false for one in made] == [False, True, False, False]
    counted = tally(made)
    assert (counted.journeys, counted.home.value, counted.false, counted.collisions) == (4, 0.25, 1, 4)
    assert counted.ratio == pytest.approx(1.1)
    assert math.isnan(tally(made[1:]).ratio)


def test_way_speed_standing_and_collisions_are_the_truths() -> None:
    places = iter([(0, 0), (0, 0), (0.1, 0), (0.2, 0), (3.2, 0), (3.3, 0)])
    touches = iter([True, True, False, True, True, False])

    def truth() -> SimpleNamespace:
        x, y = next(places)
        return SimpleNamespace(x=x, y=y, contact=next(touches))

    watched = Watched(truth)
    for k in range(6):
        record = SimpleNamespace(travel=SimpleNamespace(note=f"n{k}"), where=SimpleNamespace(event=""))
        watched.observe(SimpleNamespace(stamp_ns=k * 250_000_000), record)
    judged = watched.judged("den", "carried", 0, True, (3.3, 0.4), 0.6)
    assert judged.error == pytest.approx(0.4)
    assert judged.ratio == pytest.approx(0.5)  # the jump of 3 m isn't driven
    assert judged.speed == pytest.approx(0.3 / 1.25)
    assert judged.standing == pytest.approx(0.25)
    assert judged.collisions == 2
    assert judged.last.endswith("n5")


def test_words_of_a_command_line(tmp_path: Path) -> None:
    asked = request("room-corridor, hall", "0-2", "0,4", "turned,none", 3, 0, [])
    assert asked.kinds == ("none", "turned")
    assert asked.steps == 2 * 3 * 2 * 2 * 3
    with pytest.raises(DataError, match="--kinds upside down: there are all, none, turned, moved"):
        request("hall", "0", "0", "upside down", 1, 0, [])
    with pytest.raises(DataError, match="--worlds: name one"):
        request("", "0", "0", "all", 1, 0, [])
    path = write([told()], tmp_path / "out")
    assert json.loads(path.read_text())[0]["error"] == 0.1


def test_places_of_the_lesson_lie_apart(taught: Taught) -> None:
    places = taught.places()
    assert places[0, :2] == pytest.approx(taught.end()[:2])
    assert np.hypot(*np.diff(places[:, :2], axis=0).T).min() >= 0.25
