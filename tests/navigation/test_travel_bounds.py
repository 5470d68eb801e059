"""What travelling decides at its bounds and on either side of them: the same as before."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest
from homing_fakes import TellingViews
from kept import as_before
from maps import square

from topomap.core.errors import TopomapError
from topomap.core.geometry import Pose2
from topomap.core.records import Alignment, Command, Goal, HomeVector, Hypothesis, Phase, PlaceMatch, Travel, Where
from topomap.navigation import homeward, journey, remedies, traveller
from topomap.navigation.arrival import ELSEWHERE, MINIMUM_BELOW, NEAR, RISE, SAME, SURE, TURNED, Arrival, Claim, doubt
from topomap.navigation.course import AHEAD, BACK, JUMP, Course
from topomap.navigation.edge_costs import (
    MEMORY_S,
    SHUT_RADIUS,
    SHUT_S,
    Shut,
    _carried,
    _closed,
    _price,
    distance_to,
    edges_of,
)
from topomap.navigation.goal_met import BARE, goal_met
from topomap.navigation.homeward import DOCK, Homeward
from topomap.navigation.journey import PLANS, SET_BACK, Journey
from topomap.navigation.pilot import Pilot, PilotSettings
from topomap.navigation.progress import RECOVERED, STRETCH, Progress
from topomap.navigation.recovery import Recovery, Remedy, Trouble
from topomap.navigation.remedies import ABOUT_STEPS, BACK_STEPS, WAIT_STEPS, Remedies
from topomap.navigation.senses import Health
from topomap.navigation.sight import Sight
from topomap.navigation.steering import GATE, LOST, heading_for, map_sigma, share_of_view, view_sigma
from topomap.navigation.traveller import LOST_STEPS, OFF_STEPS, SOUGHT, STAND_STEPS, UNSEEN, Traveller, TravelSettings
from topomap.vision.aligned_homing import AlignedHoming

PILOT = Pilot(PilotSettings())
NEXT = math.nextafter


THE_MAP = square(8)


def around(bound: float) -> tuple[float, float, float]:
    """Just below, at, and just above."""
    return NEXT(bound, -math.inf), bound, NEXT(bound, math.inf)


def where(lost: float = 0.0, pose: Pose2 | None = None, rivals: tuple[Hypothesis, ...] = ()) -> Where:
    return Where(pose or Pose2(0.2, 0.05, 0.1), 0, 0.5, lost, rivals)


def rows(curve: list[float]) -> list[bool]:
    arrival = Arrival()
    return [arrival.update(one) for one in curve]


def test_an_arrival_at_its_bounds() -> None:
    assert [rows([one])[0] for one in around(SAME)] == [True, False, False]
    for low, met in zip(around(MINIMUM_BELOW), (True, False, False), strict=True):
        assert rows([0.9, low, 0.9, 0.9])[-1] is met
        assert rows([low] * 7)[-2:] == [False, met]  # it rests
    assert rows([0.5, 0.5 * RISE, 0.5 * RISE, 0.5 * RISE]) == [False] * 4
    assert rows([0.5, 0.6, 0.5 * RISE, 0.6, 0.6]) == [False, False, False, False, True]


def test_who_but_turns_passes_nothing() -> None:
    """Before a goal 0.33 m behind it a robot turned, saw it now more and now less alike, and called it reached."""
    arrival = Arrival()
    assert not any(arrival.update(0.42 + 0.02 * (k % 3), moved=False) for k in range(30))
    assert arrival.update(0.9 * SAME, moved=False), "the place itself is there at once"
    came = [arrival.update(0.44) for _ in range(7)]
    assert came[-1], "passed in driving it counts as ever"
    moved, sight = [], Sight(9, 9, TellingViews().view(0.0, 0.0, 0.0), 0.0)
    for x, turn in ((0.0, 0.0), (0.0, 0.3), (0.015, 0.6), (0.03, 0.9), (0.03, 1.2), (0.06, 1.2)):
        moved.append(sight.has_moved(Pose2(x, 0.0, turn)))
    assert moved == [True, False, False, True, False, True]
    for place, off, counts in ((9, 0.4, False), (9, homeward.PASSED - 1e-9, True), (4, 0.4, True)):
        goal = THE_MAP.pose(place)
        sensed, made = now(0.0, goal @ Pose2(off, 0.0, 1.0)), j_at(4.5 if place == 9 else 2.0)
        sight = Sight(place, place, sensed.senses.panorama, 0.0)
        made.sight, made.last = sight, place - 1
        assert sight.has_moved(sensed.mapper.track.raw)
        made.sight = sight
        assert Homeward._counts(made, sight, sensed) is counts, (place, off)


def test_what_is_doubted_at_its_bounds() -> None:
    goal, found = Pose2(1.0, 0.0, 0.0), []
    for lost, x, weight, away, turned in itertools.product(
        around(SURE), (1.0 - NEAR + 1e-9, 1.0 - NEAR - 1e-9), around(SURE), (ELSEWHERE, ELSEWHERE + 1e-9), (0.0, TURNED)
    ):
        rival = Hypothesis(3, Pose2(1.0 + away, 0.0, 0.0), weight)
        found.append(doubt(Claim(goal, turned, 0.3, where(lost, Pose2(x, 0.0, 0.0), (rival,)))))
    for other, away in itertools.product(around(0.3), around(ELSEWHERE)):
        found.append(doubt(Claim(goal, 0.0, 0.3, where(0.0, goal), PlaceMatch(7, other, 0.0), away)))
    for turned in (-TURNED - 1e-9, -TURNED, TURNED, TURNED + 1e-9, 6.2):
        found.append(doubt(Claim(goal, turned + 0.2, 0.3, where(0.0, Pose2(1.0, 0.0, 0.2)))))
    as_before("travel doubts", {"why": found})


def test_a_course_is_followed_at_its_bounds() -> None:
    topo = square(8)
    course, told = Course(topo, list(range(20))), []
    for x, y in ((0.2, 0.1), (1.0, -0.3), (2.6, 0.2), (3.9, 0.4), (1.0, 2.0), (-3.0, 0.5), (4.2, 3.0), (0.0, 0.0)):
        told += [course.follow(Pose2(x, y, 0.3)), course.along, course.left]
        told += [course.point(ahead).x for ahead in (-1.0, 0.0, 0.7, 50.0)] + [course.point(0.7).y]
        for after, beyond in itertools.product((-1, 3, 19), (0.0, 0.5, 1.5)):
            found = course.next_milestone(after, beyond)
            told.append(-1 if found is None else found)
    course.reach(5)
    told += [course.along, course.length, float(course.next_milestone(-1, 0.5) or 0)]
    straight = Course(topo, [0, 1, 2, 3, 4])
    for along, x in itertools.product((0.0, BACK, 1.0, AHEAD), (0.0, BACK, 1.0, AHEAD, 1.9)):
        straight.along = along
        told += [straight.follow(Pose2(x, 0.0, 0.0)), straight.along]
    folded = Course(topo, [0, 1, 2, 3, 2, 1, 0])  # as far along either way
    for along, y in itertools.product((0.3, 1.6, 2.9), (0.0, JUMP, JUMP + 0.1)):
        folded.along = along
        told += [folded.follow(Pose2(0.4, y, 0.0)), folded.along]
    alone = Course(topo, [7])
    told += [alone.follow(Pose2(1.0, 1.0, 0.0)), alone.along, alone.length, float(alone.next_milestone(-1, 0.0) or -1)]
    as_before("travel course", {"told": told})


def test_what_failures_and_shut_places_cost_at_their_bounds() -> None:
    second = 10**9
    told = [_price(*one, int(since * second)) for one in ((0, 0), (3, 0), (0, 1), (2, 2))
            for since in (0, SHUT_S - 1, SHUT_S, SHUT_S + 600, MEMORY_S - 1, MEMORY_S, MEMORY_S + 9)]  # fmt: skip
    a, b = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 1.0]]), np.array([[2.0, 0.0], [0.0, 0.0], [1.0, 3.0]])
    for point in ((1.0, 1.0), (-1.0, 0.0), (3.0, 0.5), (1.0, 2.0)):
        told += distance_to(np.array(point), a, b).tolist()
    for y, since in itertools.product(around(SHUT_RADIUS), (0, int(SHUT_S * second) - 1, int(SHUT_S * second))):
        told += _closed(a, b, (Shut(1.0, -y, 5),), 5 + since).astype(float).tolist()
    topo = square()
    told += _carried(topo, edges_of(topo)).astype(float).tolist()
    as_before("travel prices", {"told": np.minimum(told, 1e6)})


def test_what_is_between_the_course_and_the_view_at_its_bounds() -> None:
    told = [view_sigma(c) for c in np.linspace(0.0, 1.0, 21)]
    told += [min(map_sigma(d, lost), 9.0) for d in (0.0, 0.1, 1.0, 5.0) for lost in (0.0, 0.3, *around(LOST), 0.9)]
    here, milestone, ahead = Pose2(0.1, -0.2, 0.4), Pose2(1.0, 0.3, 0.0), Pose2(0.7, 0.5, 0.0)
    bearing, distance = here.bearing_to(milestone), here.distance(milestone)
    for c, lost, least, off in itertools.product((0.0, 0.3, 1.0), (0.0, 0.4, *around(LOST)), (0.0, 0.3), (0.2, -1.4)):
        home = HomeVector(bearing + off, None, c)
        told += [
            share_of_view(home, bearing, distance, lost, least),
            heading_for(here, milestone, ahead, home, lost, least),
        ]
    gate = GATE * math.hypot(map_sigma(distance, 0.0), view_sigma(0.5))
    for off in (gate - 1e-9, gate + 1e-9):
        told.append(share_of_view(HomeVector(bearing - off, None, 0.5), bearing, distance, 0.0))
    as_before("travel steered", {"told": told})


def test_what_touches_the_body_blocks_only_what_leads_nearer_to_it() -> None:
    told = list[float]()
    directions = np.array([0.0, 0.5, math.pi / 2, 3.0])
    for ahead, away in itertools.product((0, 9, 18, 30), (0.0, 0.1, 0.259, 0.261, 0.75, 0.899, 0.9)):
        ranges = np.full(72, 5.0, np.float32)
        ranges[ahead] = away
        told += np.minimum(PILOT._room(directions, ranges), 9.0).tolist()
        told += [PILOT.steer(bearing, ranges).turn for bearing in (0.0, 0.3, 1.2, 1.3)]
    assert PILOT._room(np.zeros(1), np.zeros(72, np.float32))[0] == math.inf
    as_before("travel room", {"told": told})


def test_progress_and_remedies_at_their_bounds() -> None:
    told: list[float] = []
    for lefts in ((9.0, 9.0 - STRETCH, 8.7, 8.7 - STRETCH, 7.0, 5.0), (3.0, 3.0 - RECOVERED, 1.4, 1.0)):
        for begin in ("trouble", "renew", "both", ""):
            progress = Progress()
            for k, left in enumerate(lefts):
                if k == 1 and begin in ("trouble", "both"):
                    progress.trouble()
                if (k == 1 and begin == "renew") or (k == 2 and begin == "both"):
                    progress.renew()
                told += [progress.update(left), progress.idle, min(progress.best, 99.0)]
            progress.trouble()
            told += [progress.update(lefts[-1] - RECOVERED), progress.update(lefts[-1] - RECOVERED - 1e-9)]
    recovery, said = Recovery(), list[str]()
    for trouble in Trouble:
        said += [recovery.next(trouble) for _ in range(8)]
    recovery.made_progress()
    said.append(recovery.next(Trouble.BLOCKED))
    as_before("travel progress", {"told": told, "said": said})


def j_at(place: float = 0.0, **more: object) -> Journey:
    made = Journey(9, Course(THE_MAP, list(range(10))), 0, **more)
    made.course.along = place
    return made


def now(lost: float = 0.0, pose: Pose2 | None = None, **senses: object) -> SimpleNamespace:
    view = TellingViews().view(0.2, 0.05, 0.1)
    sensed = SimpleNamespace(stamp_ns=7 * 10**9, panorama=view, turn=0.05, ranges=None, contact=False, place=None,
                             health=Health())  # fmt: skip
    for name, value in senses.items():
        setattr(sensed, name, value)
    track = SimpleNamespace(raw=Pose2(), travel=0.0, turn=0.0)
    return SimpleNamespace(senses=sensed, where=where(lost, pose), ranges=None, mapper=SimpleNamespace(
        map=THE_MAP, track=track, view_cache=SimpleNamespace(panorama=lambda node: TellingViews().view(0.0, 0.0, 0.0))
    ))  # fmt: skip


def test_remedies_end_at_their_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(remedies, "free_bearing", lambda ranges: 0.3)
    ranges, said = np.full(36, 3.0, np.float32), list[str]()
    for remedy, most in ((Remedy.WAIT, WAIT_STEPS), (Remedy.RELOCALISE, ABOUT_STEPS), (Remedy.RETRACE, BACK_STEPS),
                         (Remedy.TURN, 40), (Remedy.LOOK, 0)):  # fmt: skip
        for pose in (Pose2(3.0, 0.2, 0.1), Pose2(1.1, 0.0, 0.0)):
            made, sensed = j_at(2.0), now(0.0, pose)
            sensed.ranges = ranges
            tried = Remedies(PILOT, 0.8)
            tried.begin(made, remedy)
            commands = [tried.step(made, sensed) for _ in range(most + 3)]
            count = sum(one is not None for one in commands)
            assert count <= most or remedy is Remedy.TURN
            said.append(f"{remedy} {count} {commands[0]}")
            sensed.ranges = None
            tried.begin(made, remedy)
            said.append(f"{tried.step(made, sensed)}")
    as_before("travel remedies", {"said": said})


def test_a_journey_keeps_count_at_its_bounds() -> None:
    assert [j_at(steps=s, budget=10).over_budget(2) for s in (20, 21)] == [False, True]
    assert [j_at(plans=p, budget=10).over_budget(1) for p in (PLANS, PLANS + 1)] == [False, True]
    assert [j_at(last=k).legs_left for k in (-1, 0, 4, 9)] == [10, 9, 5, 0]
    for along, last in ((1.0, 4), (2.0 - SET_BACK, 4), (2.0 - SET_BACK - 1e-6, 3), (0.1, 1)):
        made = j_at(along, last=4, sight="a view")
        made.step_back()
        assert made.last == (last if along != 1.0 else 3)
        assert (made.sight is None) == (made.last != 4)
    made, topo = Journey(9, Course(square(8), list(range(10))), 0), square(8)
    made.course.along = 1.1
    for ahead in (0.4, 0.35, 99.0, -9.0):
        made.shut_ahead(topo, ahead, 5)
    failed = [(row.a, row.b, row.failed) for row in topo.experience]
    as_before("travel shut", {"places": [(s.x, s.y) for s in made.shut], "failed": failed})


def test_a_plan_begins_a_journey_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    made, here = j_at(1.0, last=4, steps=70, plans=2, sought=9), now()
    made.goal = 6
    made.plan(here)
    length = made.course.length
    assert (made.last, made.sought, made.plans, made.left_ns, made.sight) == (-1, 0, 3, 7 * 10**9, None)
    assert made.budget == 70 + journey.STEPS_MORE + round(journey.STEPS_PER_M * length)
    here.where = Where(Pose2(), None, 0.5, 0.0)
    with pytest.raises(TopomapError, match="the map is empty"):
        made.plan(here)
    with pytest.raises(TopomapError, match="no node 99"):
        Journey.begin(99, now())


class Looks:
    """What a method finds, as it is told to."""

    def __init__(self, home: HomeVector, rotation: float = 0.0) -> None:
        self.home, self.rotation = home, rotation

    def align(self, *_: object) -> Alignment:
        return Alignment(self.rotation, 0.5, self.home)


def test_home_is_headed_for_at_its_bounds() -> None:
    way = Homeward(AlignedHoming(Looks(HomeVector(0.2, None, 0.7))), PILOT, 0.4)
    told: list[float] = []
    for along, lost, slow, place in itertools.product(
        (1.0, 4.5 - DOCK, 4.0), (0.0, 0.4, *around(LOST), 0.9), (False, True), (9, 4)
    ):
        made, sensed = j_at(along), now(lost, Pose2(along, 0.1, 0.2), health=Health(slow=slow))
        made.sight = Sight(place, place, sensed.senses.panorama, 0.1)
        told.append(way._speed_for(made, sensed))
        told.append(way._may_be_there(made, made.sight, sensed))
        look = SimpleNamespace(home=HomeVector(0.4, None, 0.6), difference=0.0, rotation=0.25)
        for look.difference, look.rotation in itertools.product(
            (0.3, 0.6, 0.7, 0.8, 0.9), (0.25, 1.9, *(0.2 + homeward.NEAR_TURN * s for s in (0.99, 1.01)))
        ):
            told.append(way._bearing(made, made.sight, look, sensed))
        for x, y in way._aims(made, sensed, 0.3):
            told += [x, y]
    as_before("travel headed", {"told": told})


def test_a_milestone_is_left_behind_at_its_bounds() -> None:
    way, said = Homeward(AlignedHoming(Looks(HomeVector(0.2, None, 0.7))), PILOT, 0.4), list[str]()
    for lost, ahead, least, place in itertools.product(
        around(LOST), (homeward.PASSED + 1e-9, homeward.PASSED - 1e-9, -2.0), (0.3, 0.9), (4, 9)
    ):
        made = j_at(0.5 * place - ahead)
        made.sight = Sight(place, place, TellingViews().view(0.0, 0.0, 0.0), 0.1)
        made.sight.least = least
        note = way._advance(made, now(lost))
        said.append(f"{note or '-'} {made.unseen} {made.last} {made.sight is None}")
    as_before("travel advanced", {"said": said})


def test_a_goal_is_met_at_its_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    said = list[str]()
    for lost, weight, x, seen, node in itertools.product(
        (0.0, *around(SURE)), (0.0, *around(SURE)), (4.5 - BARE + 1e-9, 4.5 - BARE - 1e-9), (0.3, 0.9), (9, 8)
    ):
        sensed = now(lost, Pose2(x, 0.0, 0.0))
        sensed.where = where(lost, Pose2(x, 0.0, 0.0), (Hypothesis(30, Pose2(0.0, 4.0, 0.0), weight),))
        made = j_at(4.0)
        topo = sensed.mapper.map
        topo_pose = topo.pose(9)
        sensed.where = where(lost, Pose2(topo_pose.x + x - 4.5, topo_pose.y, topo_pose.heading), sensed.where.rivals)
        made.sight = Sight(9, node, sensed.senses.panorama, 0.0)
        made.sight.least = seen
        look = SimpleNamespace(there=seen < 0.5, rotation=0.0, difference=0.2)
        said.append(str(goal_met(made, made.sight, look, sensed)))
    as_before("travel met", {"said": said})


def test_troubles_begin_at_their_bounds() -> None:
    said = list[str]()
    drives = Traveller(TravelSettings(), AlignedHoming(Looks(HomeVector(0.2, None, 0.7))))
    for lost, lost_for, sought, idle, unseen in itertools.product(
        around(LOST), (0, LOST_STEPS), (0, SOUGHT, SOUGHT + 1), (0, 48, 49), (0, UNSEEN)
    ):
        made = j_at(1.0, lost_for=lost_for, sought=sought, unseen=unseen)
        made.progress.idle = idle
        found = drives._trouble(made, now(lost))
        said.append(f"{found} {made.lost_for}")
        made.remedy = Remedy.WAIT
        assert drives._trouble(made, now(lost)) is None
    as_before("travel troubles", {"said": said})


def test_the_belief_is_followed_and_one_elsewhere_for_a_while_plans_anew() -> None:
    drives = Traveller(TravelSettings(), AlignedHoming(Looks(HomeVector(0.2, None, 0.7))))
    said = list[str]()
    for lost, y, astray in itertools.product(
        around(LOST), (0.2, 1.5 - 1e-9, 1.5 + 1e-9), (0, OFF_STEPS - 1, OFF_STEPS)
    ):
        made = j_at(1.0, astray_for=astray)
        drives._follow(made, now(lost, Pose2(1.5, -y, 0.0)))
        said.append(f"{made.astray_for} {made.plans} {made.progress.idle} {made.progress.best:.3f}")
    made = j_at(1.0)
    made.recovery.next(Trouble.LOST)
    made.progress.update(9.0)
    made.progress.trouble()
    drives._follow(made, now(0.0, Pose2(3.0, 0.0, 0.0)))
    said.append(str(made.recovery.next(Trouble.LOST)))
    as_before("travel followed", {"said": said})


def test_without_senses_it_stands_so_long_and_gives_up() -> None:
    drives = Traveller(TravelSettings(), AlignedHoming(Looks(HomeVector(0.2, None, 0.7))))
    blind, goal = now(health=Health(stop="dark")), Goal(Phase.TRAVEL, 5)
    told = [drives.step(blind.senses, blind.where, goal, blind.mapper) for _ in range(STAND_STEPS + 1)]
    assert [travel.note for _, travel in told] == ["dark"] + [""] * (STAND_STEPS - 1) + ["dark"]
    assert [travel.phase for _, travel in told] == [Phase.TRAVEL] * STAND_STEPS + [Phase.FAILED]
    assert {command for command, _ in told} == {Command()}
    assert drives._journey is None
    assert drives.step(blind.senses, blind.where, Goal(Phase.TEACH), blind.mapper) == (Command(), Travel(Phase.TEACH))


def test_what_is_tried_is_said_and_without_another_way_the_place_is_open_again(monkeypatch: pytest.MonkeyPatch) -> None:
    drives = Traveller(TravelSettings(), AlignedHoming(Looks(HomeVector(0.2, None, 0.7))))
    said, made = list[str](), j_at(1.0, lost_for=3, sought=4, sight="a view")
    for _ in range(7):
        command, travel = drives._help(made, Trouble.BLOCKED, now())
        said.append(f"{command} {travel.phase} {travel.note} {len(made.shut)} {made.plans}")
    assert (made.lost_for, made.sought, made.sight) == (0, 0, None)

    def none(self: Journey, _: object) -> None:
        raise TopomapError("no way")

    monkeypatch.setattr(traveller.Journey, "plan", none)
    assert drives._replan(made, now()) == "no way through: no way"
    assert made.shut == ()
    as_before("travel helped", {"said": said})
