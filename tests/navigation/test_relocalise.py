"""A lost robot looks around: it takes the wheels, drives where there is room, and ends in time."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from played import taught

from topomap.core.arrays import Float32Array
from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import Command, Goal, Phase, Where
from topomap.mapping.mapper import Mapper, MapperSettings
from topomap.navigation.manoeuvres.relocalise import WAY, Relocalise, free_bearing
from topomap.navigation.pilot import Pilot, PilotSettings
from topomap.navigation.search.search_way import SearchWay
from topomap.vision.registry import aligner

GOAL = Goal(Phase.TRAVEL, 0)


def a_mapper() -> Mapper:
    """A mapper that has seen nothing yet."""
    return Mapper(MapperSettings(), aligner("min-warping"))


def where(lost: float) -> Where:
    return Where(Pose2(), 0, 0.5, lost)


def view(ranges: Float32Array | None) -> Panorama:
    return replace(Panorama.from_reading(taught(1)[0]), ranges=ranges)


def corridor(ahead: float) -> Float32Array:
    """Ranges between two walls 1 m aside, with something so far ahead and nothing behind."""
    angle = np.arange(720) * math.tau / 720
    walls = 1.0 / np.maximum(np.abs(np.sin(angle)), 1e-3)
    front = np.where(np.cos(angle) > 0, ahead / np.maximum(np.cos(angle), 1e-3), 50.0)
    return np.minimum(walls, front).astype(np.float32)


def lost_step(manoeuvre: Relocalise, mapper: Mapper, lost: float, contact: bool = False) -> Command | None:
    done = manoeuvre.step(view(corridor(9.0)), contact, where(lost), GOAL, mapper)
    return None if done is None else done[0]


def test_it_leaves_the_wheels_alone_unless_the_robot_is_lost_on_a_journey() -> None:
    manoeuvre, mapper = Relocalise(Pilot(PilotSettings())), a_mapper()
    assert manoeuvre.step(view(None), False, where(0.9), Goal(Phase.TEACH), mapper) is None
    assert lost_step(manoeuvre, mapper, 0.4) is None
    assert lost_step(manoeuvre, mapper, 0.6) is not None
    assert lost_step(manoeuvre, mapper, 0.2) is not None  # not before it is sure again
    assert lost_step(manoeuvre, mapper, 0.04) is None
    assert lost_step(manoeuvre, mapper, 0.2) is None


def test_it_drives_on_where_there_is_room_and_turns_back_at_an_end() -> None:
    assert free_bearing(corridor(9.0)) == 0.0
    assert abs(free_bearing(corridor(0.5))) == pytest.approx(math.pi)
    command = lost_step(Relocalise(Pilot(PilotSettings())), a_mapper(), 1.0)
    assert command is not None
    assert 0.2 < command.forward <= 0.3


def test_after_a_contact_it_backs_off_and_goes_another_way_though_it_still_touches() -> None:
    manoeuvre, mapper = Relocalise(Pilot(PilotSettings())), a_mapper()
    ahead = lost_step(manoeuvre, mapper, 1.0)
    assert ahead is not None
    assert abs(ahead.turn) < 0.2
    commands = [lost_step(manoeuvre, mapper, 1.0, contact=True) for _ in range(8)]
    assert all(command is not None and command.forward < 0.0 for command in commands[:6])
    assert commands[7] is not None
    assert abs(commands[7].turn) > 0.5  # away from where it was touched


def test_it_gives_up_after_its_way_and_stops() -> None:
    manoeuvre, mapper = Relocalise(Pilot(PilotSettings())), a_mapper()
    assert lost_step(manoeuvre, mapper, 1.0) != Command()
    mapper.track.travel = WAY + 0.1
    done = manoeuvre.step(view(corridor(9.0)), False, where(1.0), GOAL, mapper)
    assert done is not None
    assert done[0] == Command()
    assert done[1].phase is Phase.FAILED
    assert "gave up" in done[1].note
    # the next goal of a patrol has a search of its own
    assert lost_step(manoeuvre, mapper, 1.0) != Command()


def test_it_takes_the_way_that_was_chosen_and_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    manoeuvre, mapper = Relocalise(Pilot(PilotSettings())), a_mapper()
    monkeypatch.setattr(SearchWay, "step", lambda *_: (math.pi, "turns round: its 2 places part after 4 m behind"))
    done = manoeuvre.step(view(corridor(9.0)), False, where(0.6), GOAL, mapper)
    assert done is not None
    assert (done[0].forward, abs(done[0].turn)) == (0.0, PilotSettings().turn_rate)
    assert done[1].note == "lost (0.60): turns round: its 2 places part after 4 m behind"
