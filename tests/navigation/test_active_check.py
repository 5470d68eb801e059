"""The active check: what falls votes, what rises is refused, what is stopped or says nothing goes on waiting."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, Candidate, HomeVector, Verdict
from topomap.core.rig import Rig
from topomap.mapping.closures.ledger import Ledger
from topomap.mapping.mapper import Mapper
from topomap.navigation.manoeuvres import active_check
from topomap.navigation.manoeuvres.active_check import ActiveCheck, ActiveSettings
from topomap.navigation.pilot import Pilot, PilotSettings

RIG = Rig(width=72, height=2, horizon_row=0.5, focal=72 / math.tau)


@dataclass(frozen=True)
class Ahead:
    """Says that the goal lies straight ahead."""

    confidence: float = 1.0

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        return Alignment(0.0, 0.0, HomeVector(0.0, None, self.confidence))


@dataclass
class Field:
    """A robot that moves as it is told, a ledger with one pending candidate, and what the mapper is told."""

    pending_at: float = 0.0
    ledger: Ledger = field(default_factory=Ledger)
    told: list[tuple[bool, str]] = field(default_factory=list)
    way: float = 0.0

    def __post_init__(self) -> None:
        candidate = Candidate(9, 0, 1, Pose2(), np.eye(3), query=1)
        self.ledger.decide(9, candidate, Verdict.PENDING, "waits")

    def mapper(self) -> Mapper:
        track = SimpleNamespace(travel=self.way, turn=0.0, pose=Pose2())
        nodes = [SimpleNamespace(travel=0.0, snapshot=None), SimpleNamespace(travel=self.pending_at, snapshot=None)]
        topo = SimpleNamespace(nodes=nodes, pose=lambda node: Pose2())
        view_cache = SimpleNamespace(panorama=lambda node: view())
        tell = lambda candidate, agrees, reason: self.told.append((agrees, reason))  # noqa: E731
        return cast(
            Mapper, SimpleNamespace(track=track, map=topo, view_cache=view_cache, ledger=self.ledger, testify=tell)
        )


def view(room: float = 9.0) -> Panorama:
    """A view with so much room ahead [m], and plenty elsewhere."""
    ranges = np.full(72, 9.0, np.float32)
    ranges[[*range(-6, 7)]] = room
    return Panorama(np.zeros((2, 72, 3), np.uint8), ranges, RIG)


@pytest.fixture
def homed(monkeypatch: pytest.MonkeyPatch) -> Callable[..., tuple[Field, list[str]]]:
    """Home through a field of differences by way; returns the field and the notes of the steps."""

    def home(
        difference: Callable[[float], float],
        settings: ActiveSettings | None = None,
        room: float = 9.0,
        confidence: float = 1.0,
        contact_at: int = -1,
        pending_at: float = 0.0,
    ) -> tuple[Field, list[str]]:
        place, notes = Field(pending_at), []
        monkeypatch.setattr(active_check, "aligned_difference", lambda *_: difference(place.way))
        check = ActiveCheck(settings or ActiveSettings(on=True), Pilot(PilotSettings()), Ahead(confidence))
        for step in range(200):
            done = check.step(view(room), step == contact_at, place.mapper())
            if done is None:
                break
            place.way += done[0].forward * 0.25
            notes.append(done[1].note)
        return place, notes

    return home


def test_a_difference_that_falls_is_a_vote(homed: Callable[..., tuple[Field, list[str]]]) -> None:
    place, notes = homed(lambda way: 0.8 - way)
    assert [agrees for agrees, _ in place.told] == [True]
    assert "active check: homing" in place.told[0][1]
    assert place.way < 0.6, "it stops when it has seen enough"
    assert notes[0] == "active check"


def test_a_difference_that_rises_refuses(homed: Callable[..., tuple[Field, list[str]]]) -> None:
    place, _ = homed(lambda way: 0.5 + way)
    assert [agrees for agrees, _ in place.told] == [False]
    assert place.way == pytest.approx(0.6, abs=0.06)


@pytest.mark.parametrize(
    "difference", [lambda way: 0.6, lambda way: 0.6 - 0.1 * way, lambda way: 0.6 + 0.2 * math.sin(20 * way)]
)
def test_what_neither_falls_nor_rises_says_nothing(
    homed: Callable[..., tuple[Field, list[str]]], difference: Callable[[float], float]
) -> None:
    place, notes = homed(difference)
    assert not place.told
    assert "undecided" in notes[-1]


@pytest.mark.parametrize(
    ("trouble", "says"),
    [
        ({"room": 0.3}, "something stands in the way"),
        ({"contact_at": 3}, "contact"),
        ({"confidence": 0.0}, "no home vector"),
    ],
)
def test_what_is_stopped_says_nothing_even_if_the_difference_rose(
    homed: Callable[..., tuple[Field, list[str]]], trouble: dict[str, object], says: str
) -> None:
    place, notes = homed(lambda way: 0.5 + way, **trouble)
    assert not place.told
    assert "undecided" in notes[-1]
    assert says in notes[-1]


def test_a_check_that_takes_too_long_says_nothing(
    homed: Callable[..., tuple[Field, list[str]]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(active_check, "STEPS", 3)
    place, notes = homed(lambda way: 0.5 + way)
    assert not place.told
    assert "undecided" in notes[-1]


def test_each_candidate_is_checked_once_and_none_far_behind_or_when_off(
    homed: Callable[..., tuple[Field, list[str]]],
) -> None:
    _, notes = homed(lambda way: 0.6)
    assert sum("undecided" in note for note in notes) == 1
    assert homed(lambda way: 0.8 - way, pending_at=-2.0)[1] == []
    assert homed(lambda way: 0.8 - way, ActiveSettings())[1] == []


@dataclass
class Asked:
    """Sees no way home from the place itself, and keeps what rotations it was told to expect."""

    priors: list[float | None] = field(default_factory=list)

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        self.priors.append(prior)
        return Alignment(prior or 0.0, 0.0, HomeVector(0.0, None, float(len(self.priors) > 1)))


def test_the_rotation_that_is_expected_follows_the_robot_and_the_snapshot_beside(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(active_check, "aligned_difference", lambda *_: 0.5)
    candidate = Candidate(9, 0, 1, Pose2(0.0, 0.0, 0.3), np.eye(3), query=1)
    headings = {0: 0.1, 1: 0.7}
    place = Field()
    place.ledger = Ledger()
    place.ledger.decide(9, candidate, Verdict.PENDING, "waits")
    mapper = place.mapper()
    for node in mapper.map.nodes:
        node.snapshot = "a view"  # type: ignore[misc,assignment]
    mapper.map.pose = lambda node: Pose2(0.0, 0.0, headings[node])  # type: ignore[method-assign]
    mapper.track.pose, mapper.track.turn = Pose2(0.0, 0.0, 0.9), 0.05  # type: ignore[misc]
    asked = Asked()
    check = ActiveCheck(ActiveSettings(on=True), Pilot(PilotSettings()), asked)
    for _ in range(3):
        check.step(view(), False, mapper)
    # 0.3 from the claim, turned by 0.9 - 0.7 since, of which this step's 0.05 comes on top; then seen from node 1
    at_match = 0.3 + 0.2 - 0.05 + 0.05
    beside = at_match + 0.05 + (0.1 - 0.7)
    assert asked.priors == pytest.approx([at_match, beside, beside + 0.05])
