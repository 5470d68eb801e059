"""Many journeys over one taught map, judged by the truth."""

from __future__ import annotations

import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import get_type_hints

import numpy as np
import pytest

from sim2d.streams import stream
from topomap.app.disturbed import Disturbance
from topomap.app.journey_bench import LessonTask, plan, write
from topomap.app.journeys import FAR, Taught, _drawn_goal, journeys, teach
from topomap.bench.journey_table import KEPT, kept_rows, rows
from topomap.bench.journeys import Ending, Journey, Trip, Watched, tally
from topomap.bench.kept import from_plain, to_plain
from topomap.core.errors import DataError

HELPERS = Path(__file__).parent.parent / "helpers"


@pytest.fixture(scope="module")
def taught() -> Taught:
    return teach(str(HELPERS / "den.toml"), 0, 0, ["sim.driver.laps=0.35"])


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
    assert [row[1:3] for row in table] == [("none", "2"), ("turned", "1"), ("black", "1"), ("", "4")]
    assert table[2][-1] == "1 no senses"


def told(**values: object) -> Journey:
    """A journey that went well, with other values."""
    plain = {
        "trip": Trip("den", 0, 0, (), "none", 0, 0), "claimed": True, "over": True, "error": 0.1,
        "planned": 2.0, "ratio": 1.1, "speed": 0.3, "standing": 0.1, "collisions": 1, "misled": 0, "seconds": 9.0,
        "last": "goal reached",
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

    wrong = iter([False, True, True, True, False, False])
    watched = Watched(truth, lambda where: next(wrong))
    for k in range(6):
        where = SimpleNamespace(event="", lost=0.2 if k % 3 == 2 else 0.0)
        record = SimpleNamespace(travel=SimpleNamespace(note=f"n{k}"), where=where, change=SimpleNamespace(mended=""))
        watched.observe(SimpleNamespace(stamp_ns=k * 250_000_000), record)
    judged = watched.judged(Trip("den", 0, 0, (), "carried", 0, 0), True, True, (3.3, 0.4), 0.6)
    assert judged.error == pytest.approx(0.4)
    assert judged.ratio == pytest.approx(0.5)  # the jump of 3 m isn't driven
    assert judged.speed == pytest.approx(0.3 / 1.25)
    assert judged.standing == pytest.approx(0.25)
    assert judged.collisions == 2
    assert judged.misled == 2  # the third of the wrong ones said that it wasn't sure
    assert judged.last.endswith("n5")


def test_how_a_journey_that_was_given_up_is_classed() -> None:
    said = {
        "gave up on the way to node 0: no way through": Ending.BLOCKED,
        "no route from node 3 to node 0: the map is in two parts": Ending.BLOCKED,
        "gave up on the way to node 0: the goal isn't recognised": Ending.UNRECOGNISED,
        "ranges lost: going on slowly, by contact; gave up on the way to node 0: lost": Ending.LOST,
        "lost: gave up after looking around for 30 m": Ending.LOST,
        "no arrival after 900 steps and 3 plans": Ending.LATE,
        "the camera shows nothing: the view is all of one tone": Ending.SENSES,
        "something else": Ending.OTHER,
    }
    assert {last: told(claimed=False, last=last).ending for last in said} == said
    assert told(claimed=False, over=False, last="lost (0.60): looks around").ending is Ending.CUT_OFF
    assert (told().ending, told(error=0.31).ending) == (Ending.HOME, Ending.FALSE)


def test_every_journey_is_a_row_told_apart_by_its_first_cells() -> None:
    trips = [Trip("den", 0, 0, ("a.b=1", "c=2"), kind, number, 0) for kind in ("none", "moved") for number in (0, 1)]
    kept = kept_rows([told(trip=trip) for trip in trips])
    assert all(len(row) == len(KEPT) for row in kept)
    assert len({row[:7] for row in kept}) == 4
    assert dict(zip(KEPT, kept[3], strict=True))["ending"] == "home"
    assert dict(zip(KEPT, kept[3], strict=True))["settings"] == "a.b=1 c=2"


def test_words_of_a_command_line(tmp_path: Path) -> None:
    den = str(HELPERS / "den.toml")
    asked = plan(f"{den}, hall", [0, 1, 2], [0, 4], "turned,none", 3, "any", [])
    assert asked[0].kinds == ("none", "turned")
    assert (len(asked), asked[0].travels) == (2 * 3 * 2, 2 * 3)
    assert len({task.key for task in asked}) == len(asked)
    with pytest.raises(DataError, match="--kinds upside down: there are all, none, turned, moved"):
        plan("hall", [0], [0], "upside down", 1, "0", [])
    with pytest.raises(DataError, match="--worlds: name one"):
        plan("", [0], [0], "all", 1, "0", [])
    with pytest.raises(DataError, match="--goal -1: expected the number of a node, or any"):
        plan("hall", [0], [0], "none", 1, "-1", [])
    path = write([told()], tmp_path / "out")
    assert json.loads(path.read_text())[0]["error"] == 0.1


def test_results_come_back_from_the_store_as_they_were() -> None:
    made = (told(), told(claimed=False, notes=("1 (0.0 0.0): lost",)))
    assert from_plain(get_type_hints(LessonTask.perform)["return"], json.loads(json.dumps(to_plain(made)))) == made


def test_goals_that_are_drawn_are_views_far_off_and_the_same_each_time(taught: Taught) -> None:
    found = [_drawn_goal(taught, stream(0, f"goal {k} none")) for k in (0, 1, 2, 3, 0)]
    assert found[0] == found[4]
    topo = taught.mapper.map
    assert all(node == 0 or topo.length(node, topo.chain[-1]) >= FAR for node in found)
    assert all(topo.nodes[node].snapshot is not None for node in found)


def test_a_goal_that_the_map_hasnt_is_one_line(taught: Taught) -> None:
    with pytest.raises(DataError, match=r"--goal 900: the map of .* has [0-9]+ nodes, from 0 on"):
        next(journeys(taught, 900, [Disturbance()]))


def test_places_of_the_lesson_lie_apart(taught: Taught) -> None:
    places = taught.places()
    assert places[0, :2] == pytest.approx(taught.end()[:2])
    assert np.hypot(*np.diff(places[:, :2], axis=0).T).min() >= 0.25
