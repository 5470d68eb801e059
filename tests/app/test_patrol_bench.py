"""Patrols over a saved map: each leg judged by the truth, and what is left when one is given up."""

from __future__ import annotations

import itertools
import json
import math
from pathlib import Path

import pytest
from typer.testing import CliRunner

from topomap.app.patrol_bench import PatrolTask, goals, plan, write
from topomap.app.session_bench import OTHER, drive
from topomap.bench.journeys import Ending
from topomap.bench.patrols import HEAD, Patrol, row, total
from topomap.cli.main import app
from topomap.core.errors import DataError
from topomap.mapping.mapfile import save_map

HELPERS = Path(__file__).parents[1] / "helpers"
DEN, RING = str(HELPERS / "den.toml"), str(HELPERS / "ring_with_doors.toml")
LAP = ("sim.driver.laps=1",)
BEYOND, BEFORE = (8.5, 3.5), (0.95, 4.0)  # metres: beyond two shut doors, and in the corridor between them


@pytest.fixture(scope="module")
def made() -> Patrol:
    return PatrolTask(DEN, 0, 4, LAP, ()).perform()


def test_each_leg_leads_to_the_goal_that_was_drawn_for_it(made: Patrol) -> None:
    topo = drive(DEN, 0, LAP).map
    drawn = goals(topo, OTHER, 4)
    assert [leg.trip.goal for leg in made.legs] == drawn
    assert [leg.trip.number for leg in made.legs] == [0, 1, 2, 3]
    assert all(leg.home and leg.error < 0.15 for leg in made.legs)
    # every leg but the first, whose start isn't told, is about as long as the map's way from goal to goal
    assert all(0.8 < leg.ratio < 1.6 for leg in made.legs[1:] if leg.planned > 1.0)
    assert made.way == pytest.approx(sum(leg.planned * leg.ratio for leg in made.legs), rel=0.01)
    assert made.map.nodes >= len(topo.nodes)
    assert made.map.false == 0


def test_no_goal_follows_itself_and_all_have_views() -> None:
    topo = drive(DEN, 0, LAP).map
    drawn = goals(topo, 1, 200)
    assert all(a != b for a, b in itertools.pairwise(drawn))
    assert set(drawn) == {name for name, node in zip(topo.names, topo.nodes, strict=True) if node.snapshot is not None}


def test_rows_and_legs_are_kept(made: Patrol, tmp_path: Path) -> None:
    cells = dict(zip(HEAD, row(made), strict=True))
    assert (cells["world"], cells["legs"], cells["made"], cells["reached"], cells["false"]) == (
        "den",
        "4",
        "4",
        "4",
        "0",
    )
    assert dict(zip(HEAD, total([made, made]), strict=True))["legs"] == "8"
    kept = json.loads(write([made], tmp_path).read_text())
    assert [len(kept[0]["legs"]), kept[0]["legs"][3]["trip"]["number"]] == [4, 3]
    with pytest.raises(DataError, match="--worlds"):
        plan(" ,", [0], 4, LAP, ())


@pytest.mark.slow
def test_a_goal_behind_a_shut_door_is_given_up_and_the_next_one_is_reached(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = drive(RING, 0, ())
    names = known.map.names
    asked = [min(names, key=lambda name: math.dist(known.truths[name][:2], place)) for place in (BEYOND, BEFORE)]
    monkeypatch.setattr("topomap.app.patrol_bench.goals", lambda *_: asked)
    save_map(known.map, tmp_path / "map.topomap")
    shut = tmp_path / "shut.toml"
    shut.write_text(Path(RING).read_text().replace("opens_s = 0.0", "opens_s = 1e6"))
    task = PatrolTask(str(shut), 0, 2, (), ('stack.mission.start="0"',))
    legs, after = task._patrol(tmp_path / "map.topomap", known.truths)
    assert [leg.trip.goal for leg in legs] == asked
    assert not legs[0].claimed
    assert legs[0].ending in (Ending.BLOCKED, Ending.LOST), legs[0].last  # a shut door ahead may make it doubt itself
    assert legs[1].home, legs[1].last
    assert after.false == 0


def test_a_route_that_cannot_be_driven_is_one_line(tmp_path: Path) -> None:
    words = ("--worlds", "room-corridor", "--set", "sim.driver.laps=1", "--legs", "1", "--jobs", "1", "--fresh")
    done = CliRunner().invoke(app, ["bench", "patrols", *words, "--out", str(tmp_path)])
    assert isinstance(done.exception, DataError)
    assert str(done.exception).startswith("room-corridor: the driver has been stuck")
