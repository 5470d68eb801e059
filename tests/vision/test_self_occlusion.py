"""What turns with the robot is found and filled; a world that only looks bare isn't."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from sim2d import worlds
from sim2d.robot import SimRobot
from topomap.app.config import load_config
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.recorded import Spans
from topomap.core.robot import Reading
from topomap.vision.occlusion.filled import columns_of, filled
from topomap.vision.occlusion.self_occlusion import ENOUGH, SelfOcclusion


@cache
def driven(world: str, *words: str) -> tuple[Reading, ...]:
    robot = SimRobot(worlds.load(world), load_config(None, [*words, "sim.driver.laps=1"]).sim, 7)
    return tuple(r for _ in range(400) if (r := robot.sense()) is not None and r.driven)


def found(readings: tuple[Reading, ...], before: Spans = ()) -> tuple[Spans, list[int]]:
    """What is known to be hidden in the end, and the steps in which that changed."""
    occlusion, changes = SelfOcclusion(before), []
    for k, reading in enumerate(readings):
        occlusion.see(Panorama.from_reading(reading), reading.motion.turn)
        changes += [k] if occlusion.changed else []
    return occlusion.spans, changes


def bars(degrees: float) -> str:
    return f"sim.camera.lens={{lenses=2,supports=3,support_deg={degrees}}}"


@pytest.mark.parametrize(("world", "wide"), [("room-corridor", 2.0), ("room-corridor", 12.0), ("hall", 6.0)])
def test_bars_of_a_mirror_are_found_where_they_are(world: str, wide: float) -> None:
    spans, changes = found(driven(world, bars(wide)))
    assert len(changes) in (1, 2)
    assert len(spans) == 3
    middles = sorted(math.degrees(start + extent / 2) % 360 for start, extent in spans)
    assert middles == pytest.approx([60, 180, 300], abs=0.6)
    assert [math.degrees(extent) for _, extent in spans] == pytest.approx([wide + 1.5] * 3, abs=1.1)


@pytest.mark.parametrize("world", ["room-corridor", "hall", "office-loop"])
@pytest.mark.parametrize("noise", [2.0, 12.0])
def test_a_camera_that_sees_all_is_left_alone(world: str, noise: float) -> None:
    assert found(driven(world, f"sim.camera.noise={noise}")) == ((), [])


def test_what_was_hidden_to_another_camera_is_seen_again() -> None:
    spans, changes = found(driven("hall"), ((1.0, 0.2),))
    assert (spans, len(changes)) == ((), 1)


@pytest.mark.parametrize("turn", [math.nan, 0.0, 0.4])
def test_an_odometry_that_reads_no_turn_or_a_wrong_one_hides_nothing(turn: float) -> None:
    along_a_wall = driven("room-corridor", bars(12.0))[:12] * ENOUGH
    wrong = tuple(replace(r, motion=replace(r.motion, turn=turn)) for r in along_a_wall)  # type: ignore[type-var]
    assert found(wrong) == ((), [])


def test_hidden_columns_fade_from_one_side_to_the_other_and_round_the_seam() -> None:
    whole = Panorama.from_reading(driven("room-corridor")[0])
    unit = TAU / whole.rig.width
    spans = (((whole.rig.width - 3 - 0.5) * unit, 7 * unit), (99.5 * unit, 2 * unit))
    assert columns_of(spans, whole.rig.width) == ((717, 7), (100, 2))
    image = filled(whole, spans).image.astype(float)
    untouched = np.setdiff1d(np.arange(4, 717), [100, 101])
    assert np.array_equal(image[:, untouched], whole.image[:, untouched])
    before, behind = whole.image[:, 716].astype(float), whole.image[:, 4].astype(float)
    assert np.abs(image[:, 0] - (before + behind) / 2).max() <= 0.5
    assert np.abs(image[:, 717] - (7 * before + behind) / 8).max() <= 0.5
    assert filled(whole, ()) is whole
    assert filled(whole, spans) is filled(whole, spans)


def test_a_view_of_other_width_has_all_columns_filled_that_a_span_touches() -> None:
    spans = ((99.5 * TAU / 720, 3 * TAU / 720),)
    assert columns_of(spans, 720) == ((100, 3),)
    assert columns_of(spans, 90) == ((12, 2),)
    assert columns_of(((0.0, TAU),), 90)[0][1] == 88, "two are left to fade between"
