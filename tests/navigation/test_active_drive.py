"""The active check in a simulated room: the robot homes to an undecided place by itself, and a replay agrees."""

from __future__ import annotations

from pathlib import Path

import pytest
from played import Kept, Played

from sim2d import worlds
from sim2d.records import SimReading
from sim2d.robot import SimRobot
from topomap.app.config import load_config
from topomap.app.wiring import build_navigator
from topomap.core.records import StepRecord, Verdict
from topomap.navigation.navigator import Navigator
from topomap.navigation.runner import run

DEN = Path(__file__).parent.parent / "helpers" / "den.toml"
STEPS = 145
# a short lesson, and an odometry that is never believed to name a place alone: every closure is undecided at first
CONFIG = load_config(
    None,
    (
        "sim.driver.laps=0.4",
        "stack.mapper.recognition.min_travel=1.5",
        "stack.mapper.closing.certainty=0.999999",
        "stack.active.on=true",
    ),
)


class Drive(SimRobot):
    """A simulated robot that keeps its readings and runs out of them."""

    def __init__(self) -> None:
        super().__init__(worlds.load(str(DEN)), CONFIG.sim, 0)
        self.readings: list[SimReading] = []

    def sense(self) -> SimReading | None:
        reading = super().sense() if len(self.readings) < STEPS else None
        if reading is not None:
            self.readings.append(reading)
        return reading


@pytest.fixture(scope="module")
def driven() -> tuple[Drive, Navigator, list[StepRecord]]:
    robot, navigator, kept = Drive(), build_navigator(CONFIG.stack), Kept()
    run(robot, navigator, (kept,))
    return robot, navigator, kept.records


def test_an_undecided_closure_is_accepted_by_what_homing_saw(
    driven: tuple[Drive, Navigator, list[StepRecord]],
) -> None:
    _, navigator, records = driven
    notes = [r.travel.note for r in records]
    assert "active check" in notes
    assert any(note.startswith("milestone reached") for note in notes), "the mission goes on"
    decisions = [d for r in records for d in r.change.decisions]
    assert {d.verdict for d in decisions} >= {Verdict.PENDING, Verdict.ACCEPTED}
    accepted = [d for d in decisions if d.verdict is Verdict.ACCEPTED]
    assert any("and an active check" in d.reason for d in accepted)
    assert any(d.candidate.evidence.active == 1.0 for d in accepted)
    assert len(navigator.mapper.map.closures) == len(accepted)


def test_a_replay_reaches_the_same_verdicts(driven: tuple[Drive, Navigator, list[StepRecord]]) -> None:
    robot, navigator, _ = driven
    again = build_navigator(CONFIG.stack)
    run(Played(robot.readings), again)
    assert again.mapper.graph_hash() == navigator.mapper.graph_hash()
