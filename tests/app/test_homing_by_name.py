"""Any method of the registry, by setting alone, and any object from Python drives the robot home."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from played import Played, taught
from typer.testing import CliRunner

from sim2d import worlds
from sim2d.robot import SimRobot
from topomap.app.config import StackConfig, load_config, parse_config
from topomap.app.wiring import build_navigator
from topomap.cli.main import app
from topomap.core.errors import ConfigError, DataError
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector, Phase
from topomap.navigation.runner import run
from topomap.navigation.traveller import TravelSettings
from topomap.vision.homing import METHODS, Needs

DEN = str(Path(__file__).parent.parent / "helpers" / "den.toml")
SHORT = ("sim.driver.laps=0.35",)


@dataclass(eq=True)  # equal by value and thus without a hash, as a user's own class may be
class Openness:
    """Homes by the mean vector of the ranges, and counts how often it is asked."""

    asked: int = 0
    needs = Needs(compass=True, ranges=True)
    claims_homing = True

    def describe(self, panorama: Panorama) -> complex:
        assert panorama.ranges is not None
        angles = np.arange(len(panorama.ranges)) * math.tau / len(panorama.ranges)
        return complex(np.nanmean(panorama.ranges * np.exp(1j * angles)))

    def home(self, current: complex, goal: complex) -> HomeVector:
        self.asked += 1
        way = current - goal
        return HomeVector(math.atan2(way.imag, way.real))


def homed(stack: StackConfig, steps: int = 500) -> tuple[Phase, float, int]:
    """Teach a short way through the den, travel back; return how it ended, the distance to the start, legs driven."""
    robot = SimRobot(worlds.load(DEN), load_config(None, SHORT).sim, 0)
    navigator, places, notes = build_navigator(stack), [], []

    class Limited:
        def sense(self) -> object:
            places.append((robot.truth().x, robot.truth().y))
            return robot.sense() if len(places) <= steps else None

        act, stop = robot.act, robot.stop

    class Watch:
        def observe(self, reading: object, record: object) -> None:
            notes.append(record.travel)

    run(Limited(), navigator, (Watch(),))
    legs = sum(travel.note in ("milestone reached", "goal reached") for travel in notes)
    return notes[-1].phase, math.dist(places[-1], places[0]), legs


NAMES = ("dtw-unifying", "moment-area", "area-centroid", "epipolar", "auto", "min-warping", "bipolar-masks", "did")


@pytest.mark.parametrize("name", NAMES)
def test_a_name_in_the_settings_brings_the_robot_home(name: str) -> None:
    phase, off, legs = homed(load_config(None, (*SHORT, f"stack.travel.homing={name}")).stack)
    assert phase is Phase.ARRIVED
    assert off < 0.3
    assert legs >= 2


def test_a_policy_moves_and_looks_its_way_home() -> None:
    phase, off, legs = homed(load_config(None, (*SHORT, "stack.travel.homing=run-down")).stack, 2500)
    assert phase is Phase.ARRIVED
    assert off < 0.4
    assert legs >= 2


def test_another_aligner_by_name() -> None:
    aligners = (f"stack.{part}.aligner=visual-compass" for part in ("travel", "mapper"))
    words = (*SHORT, *aligners, "stack.travel.homing=dtw-wing")
    phase, off, _ = homed(load_config(None, words).stack)
    assert phase is Phase.ARRIVED
    assert off < 0.3


def test_an_object_of_ones_own_drives_the_robot() -> None:
    own = Openness()
    stack = load_config(None, SHORT).stack
    phase, off, _ = homed(stack.model_copy(update={"travel": TravelSettings(homing=own)}))
    assert own.asked > 30
    assert phase is Phase.ARRIVED
    assert off < 0.3


def test_an_object_of_the_registrys_class_does_what_its_name_does() -> None:
    stack = load_config(None, SHORT).stack
    by_name = homed(stack.model_copy(update={"travel": TravelSettings(homing="acv")}))
    assert by_name == homed(stack.model_copy(update={"travel": TravelSettings(homing=replace(METHODS["acv"]))}))


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        (
            "travel.homing",
            "min-wraping",
            r"unknown homing method 'min-wraping'; there are .*dtw-unifying.*did.*run",
        ),
        ("travel.homing", "visual-compass", r"unknown homing method 'visual-compass'.*rearrangement"),
        ("travel.aligner", "A6", r"unknown aligner 'A6'; there are visual-compass, .*min-warping"),
        ("mapper.aligner", "own", r"unknown aligner 'own'; there are visual-compass, .*min-warping"),
    ],
)
def test_a_wrong_name_is_one_line_that_lists_the_known_ones(key: str, value: str, says: str, tmp_path: Path) -> None:
    word = f"stack.{key}={value}"
    with pytest.raises(ConfigError, match=rf"stack\.{key} = '{value}': {says}") as error:
        load_config(None, [word])
    assert "\n" not in str(error.value)
    done = CliRunner().invoke(app, ["run", DEN, "--set", word, "--out", str(tmp_path / "out")])
    assert isinstance(done.exception, ConfigError)  # which main() turns into one line and exit code 2
    assert not (tmp_path / "out").exists()


def test_what_fits_no_protocol_and_what_does_not_fit_together_is_refused() -> None:
    with pytest.raises(ValueError, match="is no homing method: it needs needs and claims_homing"):
        TravelSettings(homing=object())
    with pytest.raises(ValueError, match="is no aligner: it has no method align"):
        TravelSettings(aligner=object())
    with pytest.raises(ConfigError, match="'rearrangement' is its own aligner"):
        load_config(None, ["stack.travel.homing=rearrangement", "stack.travel.aligner=given"])


def test_a_log_of_ones_own_method_says_so_and_replays_with_another() -> None:
    config = load_config()
    travel = TravelSettings(homing=Openness())
    stored = config.model_copy(update={"stack": config.stack.model_copy(update={"travel": travel})}).resolved()
    assert stored["stack"]["travel"]["homing"] == "Openness(asked=0)"
    with pytest.raises(ConfigError, match=r"^log: stack.travel.homing = 'Openness\(asked=0\)': unknown homing method"):
        parse_config(stored, "log")
    assert parse_config(stored, "log", ["stack.travel.homing=min-warping"]) == config


def test_a_robot_without_what_the_method_needs_is_told_so_at_its_first_view() -> None:
    readings = [replace(reading, ranges=None) for reading in taught(3)]
    robot = Played(readings)
    with pytest.raises(DataError, match="needs measured ranges"):
        run(robot, build_navigator(load_config(None, ["stack.travel.homing=area-centroid"]).stack))
    assert not robot.commands
    assert robot.stopped
