"""The one strict loader: every mistake is one line that names the place, the value and what would be right."""

from __future__ import annotations

from pathlib import Path

import pytest

from sim2d import worlds
from sim2d.robot import SimRobot
from topomap.app.config import RunConfig, load_config, parse_config
from topomap.core.errors import ConfigError


def test_without_anything_the_defaults_stand() -> None:
    assert load_config() == RunConfig()


def test_a_file_changes_defaults_and_words_change_the_file(tmp_path: Path) -> None:
    path = tmp_path / "run.toml"
    path.write_text("[stack.mapper.snapshots]\nthreshold = 0.7\nmin_travel = 0.3\n")
    config = load_config(path, ["stack.mapper.snapshots.threshold=0.6", "sim.camera.codec=png"])
    assert config.stack.mapper.snapshots.threshold == 0.6
    assert config.stack.mapper.snapshots.min_travel == 0.3
    assert config.sim.camera.codec == "png"


def test_what_is_stored_reads_back_equal() -> None:
    config = load_config(None, ["stack.mapper.closing.offset.position_sigma=0.2"])
    assert parse_config(config.resolved(), "log") == config


@pytest.mark.parametrize(
    ("word", "says"),
    [
        ("stack.mapper.snapshots.treshold=1", r"unknown key stack.mapper.snapshots.treshold; known there: max_travel"),
        ("stak.mapper=1", r"unknown key stak; known there: log, sim, stack"),
        ("stack.mapper.snapshots.threshold=-1", r"stack.mapper.snapshots.threshold = -1: input should be greater"),
        ("stack.mapper.snapshots.threshold=nan", r"threshold = nan"),
        ("stack.mapper.snapshots.threshold=high", r"threshold = 'high': input should be a valid number"),
        ("sim.camera.codec=gif", r"sim.camera.codec = 'gif': input should be 'jpeg' or 'png'"),
        ("stack.mapper.snapshots.threshold", "expected section.key=value"),
        ("=1", "expected section.key=value"),
        ("sim.camera.codec.depth=1", "sim.camera.codec"),
    ],
)
def test_a_wrong_word_is_one_clear_line(word: str, says: str) -> None:
    with pytest.raises(ConfigError, match=says) as error:
        load_config(None, [word])
    assert str(error.value).startswith(f"--set {word}")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[stack", "not a TOML file"),
        ("stack = 3", "stack = 3"),
        ("[stack.mission]\nthen = 'dance'", "stack.mission.then = 'dance'"),
        ("[stack.mission]\nwhere = 3", "unknown key stack.mission.where; known there: do, goal_node, start, then"),
    ],
)
def test_a_wrong_file_is_one_clear_line_that_names_it(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "run.toml"
    path.write_text(text)
    with pytest.raises(ConfigError, match=says) as error:
        load_config(path)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"none\.toml: cannot be read"):
        load_config(tmp_path / "none.toml")


@pytest.mark.parametrize(
    ("word", "says"),
    [
        (
            "sim.kidnaps=[{at_s = 1, x = nan, y = 0}]",
            "sim.kidnaps.0.x = nan: no setting is NaN, infinite",
        ),
        ("sim.body.step=inf", "sim.body.step = inf: no setting is NaN"),
        (f"sim.camera.width=1{'0' * 400}", "sim.camera.width = a number of more digits than one can read"),
        ("stack.mapper.closing.same_place.memory=1e10", "no setting is NaN, infinite or beyond"),
        ("sim.driver.lateral_offset=1e6", "input should be less than or equal to 10"),
        (
            "sim.kidnaps=[{at_s = 1, x = 0, y = 0, colour = 3}]",
            "unknown key sim.kidnaps.0.colour; known there: along, at_s",
        ),
        ("sim.laser.rays=180", "sim.laser.rays=180: expected 720, a range for each column (sim.camera.width)"),
        ("sim.camera.light_changes=[{hour = 3, at_s = 1, at_hour = 2}]", "known there: at_lap, at_s, hour"),
        (f"sim.camera.light_changes={'[' * 5000}", "nested too deeply"),
    ],
)
def test_senseless_values_are_one_short_line(word: str, says: str) -> None:
    with pytest.raises(ConfigError) as wrong:
        load_config(None, [word])
    assert says in str(wrong.value)
    assert "\n" not in str(wrong.value)
    assert len(str(wrong.value)) < 700


def test_a_file_nested_too_deeply_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "deep.toml").write_text(f"a = {'[' * 5000}")
    (tmp_path / "long.toml").write_text(f"a = 1{'0' * 10_000}")
    for name, says in (("deep", "nested too deeply"), ("long", "not a TOML file")):
        with pytest.raises(ConfigError, match=says):
            load_config(tmp_path / f"{name}.toml")


def test_another_camera_has_as_many_ranges_as_columns() -> None:
    for words, rays in (
        (["sim.camera.width=180"], None),
        (["sim.camera.width=180", "sim.laser.rays=180"], 180),
        (["sim.laser.rays=90", "sim.laser.scanner=none"], 90),
    ):
        config = load_config(None, words)
        assert config.sim.laser.rays == rays
        reading = SimRobot(worlds.load("hall"), config.sim, 0).sense()
        assert reading is not None
        assert reading.ranges is None or reading.ranges.shape == (reading.rig.width,)
