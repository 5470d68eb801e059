"""A lost robot turns round where the map says its places part sooner that way, and goes on where they don't."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from maps import STEP_NS, increments, snapshot

from topomap.core.arrays import FloatArray
from topomap.core.geometry import Pose2
from topomap.core.records import Hypothesis, Where
from topomap.mapping.graph import Node, TopoMap
from topomap.mapping.mapper import Mapper
from topomap.navigation.search import search_way
from topomap.navigation.search.deliberation import Choice, Deliberation
from topomap.navigation.search.parting import Parting
from topomap.navigation.search.search_way import AGAIN, STOPS, STUCK, SearchWay
from topomap.navigation.search.stops import MOST, SPACING, Stops, stops_from

CLEARLY, HALF, NOTHING = 3.0, 2.0, 0.0


def route(turns: dict[int, float], nodes: int) -> TopoMap:
    """Snapshots half a metre apart along a drive that turns by so much [rad] on its way to some of them."""
    topo = TopoMap()
    topo.add(Node(0, 0.0, snapshot(0)), None)
    for k in range(1, nodes):
        topo.add(Node(5 * k * STEP_NS, 0.5 * k, snapshot(k)), increments(5 * (k - 1), 5, turns.get(k, 0.0) / 5))
    return topo


def straight() -> TopoMap:
    """20 m along x."""
    return route({}, 41)


class Told:
    """What each node says against each rival."""

    def __init__(self, says: Callable[[int], list[float]]) -> None:
        self._says = says
        self.asked: list[int] = []

    def against(self, node: int) -> FloatArray:
        self.asked.append(node)
        return np.array(self._says(node))


def chosen(topo: TopoMap, here: Pose2, told: Told, weights: tuple[float, ...] = (0.4,), seen: float = 0.0) -> Choice:
    """The choice; seen [m]: as far around as everything was seen."""
    ways = stops_from(topo, np.arange(len(topo.nodes)), here)
    known = np.array([topo.pose(stop.node).distance(here) < seen for stop in ways.stops], bool)
    thinking = Deliberation(ways, np.array(weights), cast(Parting, told), known)
    for _ in range(MOST):
        if (choice := thinking.step(STOPS)) is not None:
            return choice
    raise AssertionError("never settled")


def where_sides_part(left: float, right: float) -> Callable[[int], list[float]]:
    """Nodes of `straight` at most `left` and at least `right` [m] along it speak clearly."""
    return lambda node: [CLEARLY if not left < 0.5 * node < right else NOTHING]


def test_stops_lie_apart_along_both_ways_to_their_ends() -> None:
    ways = stops_from(straight(), np.arange(41), Pose2(8.0, 0.2, 0.0))
    assert sorted(np.abs(ways.bearings).round(0).tolist()) == [0.0, 3.0]
    assert min(stop.node for stop in ways.stops) <= 1
    assert max(stop.node for stop in ways.stops) >= 39
    assert [stop.way for stop in ways.stops] == sorted(stop.way for stop in ways.stops)
    for stop in ways.stops:
        assert stop.way == pytest.approx(abs(0.5 * stop.node - 8.0), abs=0.3)
        assert stop.path[-1] == stop.node
        assert (stop.node > 16) == (abs(ways.bearings[stop.direction]) < 1.0)
    beside = np.diff(sorted(0.5 * stop.node for stop in ways.stops))
    assert beside.min() >= SPACING


def test_a_branch_is_a_way_of_its_own_and_what_was_driven_twice_is_not() -> None:
    # along x to a corner, left, back to the corner, and on to the other side
    topo = route({10: math.pi / 2, 20: math.pi}, 42)
    corner = topo.pose(10)
    ways = stops_from(topo, np.arange(42), Pose2(corner.x, corner.y, 0.0))
    assert len(ways.bearings) == 3
    places = [(stop.direction, round(topo.pose(stop.node).x), round(topo.pose(stop.node).y)) for stop in ways.stops]
    assert len(set(places)) >= len(places) - 3


def test_what_came_behind_a_break_is_no_way() -> None:
    ways = stops_from(straight(), np.arange(30), Pose2(8.0, 0.0, 0.0))
    assert max(stop.node for stop in ways.stops) == 29


def test_it_turns_round_where_the_places_part_sooner_behind() -> None:
    told = Told(where_sides_part(6.0, 18.0))
    choice = chosen(straight(), Pose2(8.0, 0.0, 0.0), told)
    assert choice.why.startswith("turns round: its 2 places part after 2 m behind, not before 6 m ahead")
    assert list(choice.path) == sorted(choice.path, reverse=True)
    assert choice.path[-1] <= 12
    assert len(told.asked) < 16  # settled before it has looked at all of them


@pytest.mark.parametrize(("left", "right"), [(1.0, 10.0), (6.0, 11.0), (6.9, 8.9), (-1.0, 99.0)])
def test_it_goes_on_where_they_part_ahead_or_about_as_soon_or_nowhere(left: float, right: float) -> None:
    choice = chosen(straight(), Pose2(8.0, 0.0, 0.0), Told(where_sides_part(left, right)))
    assert choice.path == ()
    assert choice.why.startswith("goes on: its 2 places part ")
    assert ("nowhere within" in choice.why) == (right > 20.0)


def test_one_view_alone_parts_nothing_but_at_a_dead_end() -> None:
    here = Pose2(8.0, 0.0, 0.0)
    odd = chosen(straight(), here, Told(lambda node: [CLEARLY if node == 11 else NOTHING]))
    assert odd.path == ()
    followed = chosen(straight(), here, Told(lambda node: [{11: CLEARLY, 9: HALF}.get(node, NOTHING)]))
    assert followed.why.startswith("turns round: its 2 places part after 2 m behind")
    assert chosen(straight(), here, Told(lambda node: [CLEARLY if node < 2 else NOTHING])).why.startswith("turns round")


def test_the_likelier_rival_decides() -> None:
    def says(node: int) -> list[float]:
        return [CLEARLY if node < 11 else NOTHING, CLEARLY if node > 21 else NOTHING]

    here = Pose2(8.0, 0.0, 0.0)
    assert chosen(straight(), here, Told(says), (0.4, 0.05)).why.startswith("turns round: its 3 places")
    assert chosen(straight(), here, Told(says), (0.05, 0.4)).path == ()


def test_where_it_has_been_it_expects_nothing_new() -> None:
    told = Told(where_sides_part(6.0, 14.0))
    assert chosen(straight(), Pose2(8.0, 0.0, 0.0), told, seen=9.0).path == ()
    assert not set(told.asked) & set(range(32))


def test_without_a_map_around_it_goes_on() -> None:
    assert Deliberation(
        Stops((), np.zeros(0)), np.ones(1), cast(Parting, Told(lambda _: [0.0])), np.zeros(0, bool)
    ).step(3) == Choice((), "goes on: the map has no way from its likeliest place")


def a_mapper(topo: TopoMap) -> Mapper:
    track = SimpleNamespace(raw=Pose2(3.0, 1.0, 0.5), travel=100.0)
    nodes = np.arange(len(topo.nodes))
    recognition = SimpleNamespace(nodes=lambda: nodes)
    return cast(Mapper, SimpleNamespace(track=track, map=topo, recognition=recognition, located=len(nodes)))


def between_two(x: float = 8.0, other: float = 14.0) -> Where:
    rival = Hypothesis(28, Pose2(other, 0.0, 0.0), 0.4)
    return Where(Pose2(x, 0.0, 0.0), 16, 0.1, 0.5, (rival,))


def begun() -> SearchWay:
    """A search that has driven its first stretch."""
    way, mapper = SearchWay(), a_mapper(straight())
    mapper.track.travel -= 1.5
    assert way.step(between_two(), mapper) == (None, "")
    return way


def drive(way: SearchWay, mapper: Mapper, where: Where, steps: int, speed: float = 0.0) -> tuple[float | None, str]:
    """Let it choose for so many steps of `speed` [m]; return the last bearing and all that was said."""
    said, bearing = [], None
    for _ in range(steps):
        bearing, why = way.step(where, mapper)
        said.append(why)
        mapper.track.raw = mapper.track.raw @ Pose2(speed, 0.0, 0.0)
        mapper.track.travel += speed
    return bearing, "".join(said)


@pytest.fixture
def parting_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    """The left end of the map, up to 6 m, tells any two places apart."""
    monkeypatch.setattr(search_way, "Parting", lambda *_: Told(lambda node: [CLEARLY if node < 12 else NOTHING]))


@pytest.mark.usefixtures("parting_behind")
def test_it_heads_along_the_chosen_way_by_odometry_until_its_end() -> None:
    way, mapper = begun(), a_mapper(straight())
    bearing, said = drive(way, mapper, between_two(), 12)
    assert said.count("turns round") == 1
    assert bearing is not None
    bearing, _ = way.step(between_two(), mapper)
    assert bearing is not None
    assert abs(bearing) == pytest.approx(math.pi, abs=0.01)
    mapper.track.raw = mapper.track.raw @ Pose2(0.0, 0.0, math.pi)
    bearing, _ = drive(way, mapper, between_two(), 5, 0.1)
    assert bearing == pytest.approx(0.0, abs=0.01)
    bearing, _ = drive(way, mapper, between_two(), 30, 0.1)
    assert bearing is None  # there it is


@pytest.mark.usefixtures("parting_behind")
def test_it_leaves_a_way_that_it_doesnt_get_on_with() -> None:
    way, mapper = begun(), a_mapper(straight())
    assert drive(way, mapper, between_two(), 12)[0] is not None
    assert drive(way, mapper, between_two(), STUCK + 1)[0] is None


@pytest.mark.usefixtures("parting_behind")
def test_it_chooses_rarely_and_anew_where_another_place_counts() -> None:
    way, mapper = begun(), a_mapper(straight())
    drive(way, mapper, between_two(), 12)
    still = Where(Pose2(8.0 + 1.5, 0.0, 0.0), 16, 0.1, 0.5, (Hypothesis(31, Pose2(15.5, 0.0, 0.0), 0.4),))
    mapper.track.raw, mapper.track.travel = mapper.track.raw @ Pose2(1.5, 0.0, 0.0), 101.5
    assert drive(way, mapper, still, 12)[1] == ""
    assert drive(way, mapper, between_two(9.5, 3.0), 12)[1] != ""
    mapper.track.travel += AGAIN
    assert drive(way, mapper, between_two(9.5, 3.0), 12)[1] != ""


@pytest.mark.usefixtures("parting_behind")
def test_who_may_be_anywhere_or_has_no_rival_chooses_nothing() -> None:
    way, mapper = begun(), a_mapper(straight())
    anywhere = Where(Pose2(8.0, 0.0, 0.0), 16, 0.1, 0.8, (Hypothesis(28, Pose2(14.0, 0.0, 0.0), 0.1),))
    assert drive(way, mapper, anywhere, 12) == (None, "")
    assert drive(way, mapper, Where(Pose2(8.0, 0.0, 0.0), 16, 0.1, 0.4), 12) == (None, "")


@pytest.mark.usefixtures("parting_behind")
def test_before_its_first_stretch_it_chooses_nothing() -> None:
    assert drive(SearchWay(), a_mapper(straight()), between_two(), 12) == (None, "")
