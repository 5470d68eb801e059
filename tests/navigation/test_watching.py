"""A taught robot on known ground: its belief holds the view against earlier passes, not against what it stores now."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from topomap.core.arrays import IntArray
from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import MapChange, Motion, Verdict
from topomap.mapping.mapper import Mapper
from topomap.navigation.localiser import localiser
from topomap.navigation.localiser.localiser import Localiser
from topomap.navigation.localiser.mixture import Mixture

LAP, BACK = 40, 8  # snapshots of a lap of a ring, and how many of the last ones can't be seen again yet
ANGLES = 2 * np.pi * np.arange(LAP) / LAP
RING = np.column_stack([12.0 * np.cos(ANGLES), 12.0 * np.sin(ANGLES), ANGLES])
NOTHING = SimpleNamespace(pose=Pose2(), difference=0.1, broken="", decisions=[])
CLOSED = SimpleNamespace(pose=Pose2(), difference=0.1, broken="", decisions=[SimpleNamespace(verdict=Verdict.ACCEPTED)])


class Snapshots:
    """The mapper's snapshots, one a step."""

    def __init__(self, count: int) -> None:
        self._count = count

    def __len__(self) -> int:
        return self._count

    def nodes(self) -> IntArray:
        return np.arange(self._count)

    def old_nodes(self, travel: float) -> IntArray:
        return np.arange(max(0, int(travel) + 1 - BACK))


def around(step: int, aside: slice = slice(0)) -> Mapper:
    """The mapper after so many steps on the ring, those of `aside` far beside it."""
    poses = RING[np.arange(step + 1) % LAP]
    poses[aside, 1] += 40.0
    track = SimpleNamespace(pose=Pose2(*poses[-1].tolist()), motion=Motion(1.0, 0.0, 0.0, np.zeros((3, 3)), 0.25))
    topo = SimpleNamespace(
        poses=poses,
        pose=lambda node: Pose2(*poses[node].tolist()),
        chain=list(range(step + 1)),
        nodes=[SimpleNamespace(travel=float(k)) for k in range(step + 1)],
    )
    return cast(
        Mapper,
        SimpleNamespace(
            catchment=0.0,
            recognition=Snapshots(step + 1), map=topo, track=track, handled=False, doubted=False,
            left_behind=max(0, step + 1 - BACK), located=step + 1,
        ),
    )  # fmt: skip


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many snapshots, of the first ones, the belief was asked to look at, step by step."""
    looks = list[int]()

    class Belief:
        stretches, likeness, lost, proven = 9, 0.2, 0.0, False

        def __init__(self, mixture: Mixture, topo: object) -> None:
            self.mixture = mixture

        def see(self, panorama: Panorama, mapper: Mapper, first: int) -> None:
            looks.append(first)

        follow = move = staticmethod(lambda *_: None)
        hypotheses = staticmethod(lambda *_: ())

    monkeypatch.setattr(localiser, "Belief", Belief)
    return looks


def watched(
    steps: range, asked: list[int], one: Localiser, change: SimpleNamespace = CLOSED, aside: slice = slice(0)
) -> list[int]:
    """Return what the belief was asked to look at in these steps of a lesson."""
    before = len(asked)
    for step in steps:
        one.update(cast(Panorama, None), around(step, aside), cast(MapChange, change), driven=True)
    return asked[before:]


def test_new_ground_is_not_watched(asked: list[int]) -> None:
    assert watched(range(LAP), asked, Localiser()) == []


def test_a_second_lap_is_held_against_the_first_alone(asked: list[int]) -> None:
    one = Localiser()
    watched(range(LAP), asked, one)
    looked = watched(range(LAP, 2 * LAP - BACK), asked, one)
    assert len(looked) > LAP / 2
    # of the first lap all that was left behind, and of the second nothing
    assert max(looked) <= LAP


def test_what_a_pass_stored_before_its_first_closure_belongs_to_it(asked: list[int]) -> None:
    one = Localiser()
    watched(range(LAP), asked, one)
    watched(range(LAP, LAP + 15), asked, one, NOTHING, slice(LAP, None))  # the track has drifted off
    looked = watched(range(LAP + 15, LAP + 25), asked, one)
    assert len(looked) == 10
    assert max(looked) <= LAP


def test_what_a_pass_stored_is_known_once_it_has_left(asked: list[int]) -> None:
    one = Localiser()
    left = slice(LAP + 10, LAP + 14)
    watched(range(LAP + 14), asked, one, CLOSED, left)
    assert max(watched(range(2 * LAP, 2 * LAP + 10), asked, one, CLOSED, left)) == LAP + 14
