"""Recordings with nothing to close, nothing but lies, or hardly anything at all: a clear result each."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from drives import laps, write_recording
from test_tuc import HEAD
from typer.testing import CliRunner

from topomap.cli.main import app
from topomap.core.records import Decision, Verdict
from topomap.core.run_data import RunData
from topomap.datasets.tuc.mapping import map_tuc
from topomap.datasets.tuc.recording import read_tuc
from topomap.mapping.closures.chance import probability


def drive() -> list[str]:
    """The rows of three laps without their loop candidates."""
    return [row for row in laps()[0].splitlines() if row.startswith("odom2")]


def mapped(folder: Path, rows: list[str]) -> RunData:
    return map_tuc(read_tuc(write_recording(folder, "\n".join(rows) + "\n")))


def last(run: RunData) -> list[Decision]:
    """The standing decision of every candidate."""
    return list({(d.candidate.query_ns, d.candidate.match_ns): d for d in run.decisions}.values())


def lies(seed: int, count: int) -> list[str]:
    """Candidates between places that lie far apart."""
    rng = np.random.default_rng(seed)
    truth = np.array([row.split()[2:4] for row in laps()[1].splitlines()], float)
    pairs = rng.integers(0, len(truth), (6 * count, 2))
    apart = np.hypot(*(truth[pairs[:, 0]] - truth[pairs[:, 1]]).T) > 4
    return [f"loop {max(p)} {min(p)} 0.8" for p in pairs[apart][:count].tolist()]


def test_without_candidates_the_command_writes_odometry_and_a_report(tmp_path: Path) -> None:
    write_recording(tmp_path, HEAD + "odom2 2 0.4 0 0 1 1 1\n")
    done = CliRunner().invoke(app, ["map", "tuc", str(tmp_path), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    closures = json.loads((tmp_path / "out" / "summary.json").read_text())["closures"]
    assert (closures["proposed"], closures["accepted"]) == (0, 0)
    assert (tmp_path / "out" / "report.html").exists()


@pytest.mark.parametrize(("seed", "count"), [(0, 30), (1, 100), (2, 200)])
def test_where_every_candidate_is_false_none_is_believed(tmp_path: Path, seed: int, count: int) -> None:
    run = mapped(tmp_path, drive() + lies(seed, count))
    assert len(last(run)) > 0.9 * count
    assert {d.verdict for d in last(run)} <= {Verdict.REFUSED, Verdict.WITHDRAWN}
    assert all(d.reason for d in run.decisions)
    assert np.allclose(run.final, run.dead_reckoning, atol=1e-6)


def test_true_candidates_are_believed_among_false_ones(tmp_path: Path) -> None:
    true = [f"loop {n} {n - 160} 0.8" for n in range(160, 480, 8)]
    run = mapped(tmp_path, drive() + true + lies(0, 100))
    accepted = [d.candidate for d in last(run) if d.verdict is Verdict.ACCEPTED]
    assert len(accepted) == len(true)
    assert {c.query_ns - c.match_ns for c in accepted} == {160 * 10**9}


@pytest.mark.parametrize("velocity", ["0.4", "0"])
def test_one_moment_is_one_node(tmp_path: Path, velocity: str) -> None:
    run = mapped(tmp_path, [f"odom2 1 {velocity} 0 0 1 1 1"] * 2 + ["loop 1 1 1"])
    assert len(run.nodes) == 1
    assert np.array_equal(run.final, np.zeros((2, 3)))


def test_repeated_rows_change_nothing(tmp_path: Path) -> None:
    rows = drive() + [f"loop {n} {n - 160} 0.8" for n in range(160, 480, 8)]
    once, twice = mapped(tmp_path, rows), mapped(tmp_path, [row for row in rows for _ in range(2)])
    assert np.allclose(twice.final[::2], once.final, atol=1e-9)
    assert {d.verdict for d in last(twice)} == {Verdict.ACCEPTED}


def test_candidates_at_unknown_stamps_are_refused_with_the_reason(tmp_path: Path) -> None:
    run = mapped(tmp_path, [*drive(), "loop 99999 3 0.5", "loop 3 -5 0.5", "loop 8e9 7e9 1"])
    assert [d.reason for d in last(run)] == ["a stamp lies outside the recording"] * 3
    assert np.allclose(run.final, run.dead_reckoning)


def test_an_odometer_that_stands_still(tmp_path: Path) -> None:
    run = mapped(tmp_path, [*(f"odom2 {n} 0 0 0 0 0 0" for n in range(10)), "loop 9 0 1"])
    assert np.array_equal(run.final, np.zeros((10, 3)))
    assert "it says nothing" in last(run)[0].reason


def test_the_probability_of_chance_by_hand() -> None:
    """On a straight drive of 100 m two random places lie within 1 m with probability 0.0199."""
    travelled = np.linspace(0, 100, 1001)
    poses = np.column_stack([travelled, np.zeros((1001, 2))])
    assert probability(0, 10, poses, travelled, 1.0, 0.0) == 1.0
    assert probability(1, 1, poses, travelled, 1.0, 0.0) == pytest.approx(0.0199, abs=0.002)
    assert probability(2, 2, poses, travelled, 1.0, 0.0) == pytest.approx(0.0199**2, abs=1e-4)
    assert probability(1, 1, poses, travelled, 1.0, 5.0) < 1e-3, "places apart on a line are never near"
