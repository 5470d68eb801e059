"""Eye level is found where points show it, and nothing is said where they don't."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim2d import worlds
from sim2d.config import SimConfig
from sim2d.robot import SimRobot
from topomap.core.panorama import Panorama
from topomap.core.recorded import RecordedRig
from topomap.vision.eye_level import eye_level
from topomap.vision.tilt.upright import upright
from topomap.vision.tilt.verticals import lean_of

Pair = tuple[Panorama, Panorama, float]


def pairs(world: str, row: float, told: float, pitch: float = 0.0) -> list[Pair]:
    """Views 6 steps apart of a camera with eye level at `row`, whose rig says `told`, leaning forward [degrees]."""
    camera = {"horizon_row": row, "pitch_deg": pitch}
    config = SimConfig.model_validate({"camera": camera, "laser": {"scanner": "none"}})
    robot, made, before, turn = SimRobot(worlds.load(world), config, 3), [], None, 0.0
    for step in range(25):
        reading = robot.sense()
        assert reading is not None
        turn += reading.motion.turn
        if step % 6 == 0:
            rig = replace(RecordedRig.of(reading.rig), horizon_row=told)
            view = Panorama.from_recorded(reading.image, rig)
            if before is not None:
                made.append((before, view, turn))
            before, turn = view, 0.0
    return made


@pytest.mark.parametrize(("row", "told"), [(49.5, 49.5), (62.0, 49.5), (40.0, 80.0)])
def test_it_is_found_whatever_the_rig_says(row: float, told: float) -> None:
    found = eye_level(pairs("hall", row, told))
    assert found is not None
    assert found.row == pytest.approx(row, abs=1.0)


def test_noise_shows_nothing() -> None:
    rng, rig = np.random.default_rng(0), RecordedRig.cylinder(360, 60, 0.5)

    def view() -> Panorama:
        return Panorama.from_recorded(rng.integers(0, 256, (60, 360, 3), dtype=np.uint8), rig)

    assert eye_level([(view(), view(), 0.0) for _ in range(6)]) is None
    assert eye_level([]) is None


def test_the_same_view_twice_shows_nothing() -> None:
    (before, _, _), *_ = pairs("hall", 49.5, 49.5)
    assert eye_level([(before, before, 0.0)] * 4) is None


def test_a_leaning_camera_shows_it_once_its_lean_is_taken_out() -> None:
    leaning = pairs("room-corridor", 62.0, 49.5, pitch=3.0)
    said = lean_of(leaning[0][0])
    assert said is not None
    found = eye_level([(upright(a, said.lean), upright(b, said.lean), turn) for a, b, turn in leaning])
    assert found is not None
    assert found.row == pytest.approx(62.0, abs=1.5)
