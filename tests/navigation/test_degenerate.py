"""Senses that fail and runs in which next to nothing happens: one clear line, or a clear result."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from played import Kept, Played, moved, taught
from typer.testing import CliRunner

from logs.recorder import Recorder
from sim2d.records import SimReading
from topomap.app.config import load_config
from topomap.app.folder import RunFolder
from topomap.app.runs import open_world, run_world
from topomap.app.wiring import build_navigator
from topomap.cli.main import app
from topomap.core.errors import DataError, ShapeError
from topomap.core.geometry import Pose2
from topomap.core.records import Candidate, Phase, Verdict
from topomap.mapping.mapper import Mapper
from topomap.navigation.runner import run
from topomap.recording.encode import run_header
from topomap.recording.recorder import MapNow, RunRecorder
from topomap.recording.run_reader import load_run

NAN = math.nan
WIDTH = 720


@pytest.fixture(scope="module")
def readings() -> list[SimReading]:
    return taught(24)


def drive(readings: list[SimReading], *settings: str) -> tuple[Mapper, Kept]:
    navigator, kept = build_navigator(load_config(None, settings).stack), Kept()
    run(Played(readings), navigator, (kept,))
    if kept.records:
        navigator.mapper.finish(kept.records[-1].stamp_ns)
    return navigator.mapper, kept


@pytest.mark.parametrize(
    ("broken", "message"),
    [
        (lambda r, before: replace(r, stamp_ns=before.stamp_ns), r"isn't later than the one before"),
        (lambda r, before: replace(r, stamp_ns=before.stamp_ns - 1), r"isn't later than the one before"),
        (lambda r, _: moved(r, forward=NAN), "holds NaN or infinite numbers"),
        (lambda r, _: moved(r, forward=1e300), "at most 1e.07 can be"),
        (lambda r, _: moved(r, left=math.inf), "holds NaN or infinite numbers"),
        (lambda r, _: moved(r, turn=NAN), "holds NaN or infinite numbers"),
        (lambda r, _: moved(r, covariance=np.full((3, 3), NAN)), "holds NaN or infinite numbers"),
        (lambda r, _: moved(r, covariance=np.eye(2)), r"covariance is \(2, 2\), not \(3, 3\)"),
        (lambda r, _: replace(r, ranges=r.ranges[1:]), "ranges are"),
        (lambda r, _: replace(r, image=r.image[:, 1:]), "recorded image is"),
    ],
)
@pytest.mark.parametrize("at", [1, 7])
def test_a_sense_that_fails_is_one_line_and_the_wheels_stop(
    readings: list[SimReading], at: int, broken: Callable[[SimReading, SimReading], SimReading], message: str
) -> None:
    robot = Played([*readings[:at], broken(readings[at], readings[at - 1])])
    with pytest.raises((DataError, ShapeError), match=message) as refused:
        run(robot, build_navigator(load_config().stack))
    assert "\n" not in str(refused.value)
    assert robot.stopped
    assert len(robot.commands) == at


def test_the_first_readings_increment_leads_nowhere_but_is_checked(readings: list[SimReading]) -> None:
    far, _ = drive([moved(readings[0], forward=5.0), *readings[1:3]])
    assert np.hypot(*far.map.poses[-1, :2]) < 0.5
    with pytest.raises(DataError, match="holds NaN"):
        drive([moved(readings[0], forward=NAN)])


def test_no_reading_at_all_is_a_run_of_no_steps() -> None:
    mapper, kept = drive([])
    assert not kept.records
    assert not mapper.map.nodes


@pytest.mark.parametrize("driven", [True, False])
def test_a_single_reading_is_a_map_of_one_node(readings: list[SimReading], driven: bool) -> None:
    mapper, kept = drive([replace(readings[0], driven=driven)])
    assert len(mapper.map.nodes) == 1
    assert np.array_equal(mapper.map.poses, np.zeros((1, 3)))
    assert kept.records[0].where.node == 0
    assert kept.records[0].travel.phase is (Phase.TEACH if driven else Phase.ARRIVED)


@pytest.mark.parametrize("value", [NAN, math.inf, None])
def test_where_nothing_was_measured_the_map_grows_and_the_distance_scale_is_unobserved(
    readings: list[SimReading], value: float | None
) -> None:
    ranges = None if value is None else np.full(WIDTH, value, np.float32)
    mapper, kept = drive([replace(r, ranges=ranges, driven=k < 20) for k, r in enumerate(readings)])
    assert len(mapper.map.nodes) > 3
    assert np.isfinite(mapper.map.poses).all()
    assert not mapper.optimisation.state.distance_scale.observed
    assert kept.records[-1].travel.phase is Phase.TRAVEL
    assert np.isfinite([kept.records[-1].command.forward, kept.records[-1].command.turn]).all()


def test_where_nothing_is_ever_recognised_the_map_is_a_chain(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("topomap.mapping.places.recognition.THRESHOLD", 0.01)
    mapper, kept = drive(taught(60), "stack.mapper.recognition.min_travel=1")
    assert any(r.change.place is not None for r in kept.records), "places were searched"
    assert not mapper.ledger.decisions
    assert not mapper.map.closures
    assert mapper.map.graph.number_of_edges() == len(mapper.map.nodes) - 1
    stamps, poses = mapper.map.trajectory()
    assert len(stamps) == 60
    assert np.isfinite(poses).all()


def test_a_log_of_one_reading_is_replayed_to_a_whole_run(tmp_path: Path, readings: list[SimReading]) -> None:
    config = load_config()
    header = run_header("one reading", readings[0].rig, config=config.resolved())
    with Recorder(tmp_path / "one.mcap", header) as recorder:
        run(Played(readings[:1]), build_navigator(config.stack), (RunRecorder(recorder, MapNow),))
    done = CliRunner().invoke(app, ["replay", str(tmp_path / "one.mcap"), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert "0.0 m in 1 steps" in done.output
    assert (tmp_path / "out" / "report.html").exists()


def test_what_the_last_solve_decides_reaches_the_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A closure that only the solve after the last step withdraws isn't reported as accepted."""
    candidate = Candidate(1, 0, 0, Pose2(), np.eye(3))

    def finish(mapper: Mapper, stamp_ns: int) -> None:
        mapper.track.node_at(stamp_ns)
        mapper.ledger.decide(stamp_ns, candidate, Verdict.WITHDRAWN, "the last solve can't fit it")

    monkeypatch.setattr(Mapper, "finish", finish)
    config, folder = load_config(), RunFolder.create(tmp_path / "out")
    robot = open_world("room-corridor", 0, config)
    taken = itertools.count()
    sense = robot.sense
    monkeypatch.setattr(robot, "sense", lambda: sense() if next(taken) < 12 else None)
    run_world(robot, 0, config, folder, lambda _: None)
    assert [d.reason for d in load_run(folder.log).decisions] == ["the last solve can't fit it"]
