"""topomap closures on a log: readings and map of a short simulated drive, with closures whose truth is known."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from logs.recorder import Recorder
from sim2d import worlds
from sim2d.robot import SimRobot
from topomap.app.config import load_config
from topomap.app.wiring import build_navigator
from topomap.cli.main import main
from topomap.core.evidence import Evidence
from topomap.core.geometry import Pose2
from topomap.core.records import Candidate, Decision, StepRecord, Verdict
from topomap.recording.encode import run_header
from topomap.recording.recorder import MapNow, RunRecorder

STEPS = 26


@dataclass(frozen=True)
class Trail:
    """A log, a second one of the same drive without the truth, and its pairs of query node and match."""

    log: Path
    blind: Path
    accepted: tuple[int, int]
    fooled: tuple[int, int]
    refused: tuple[int, int]


def claim(record: StepRecord, nodes: list[StepRecord], query: int, match: int) -> Candidate:
    """The candidate that the robot at `record`, the node `query`, stands exactly where `match` was taken."""
    scores = {"cost": 0.1 * (query - match), "ratio": 0.5}
    stamps = record.stamp_ns, nodes[match].stamp_ns
    return Candidate(
        stamps[0], match, stamps[1], Pose2(), np.eye(3) * 0.01, 1 - scores["cost"], query, Evidence.of(scores)
    )


def planted(records: list[StepRecord]) -> tuple[list[StepRecord], tuple[tuple[int, int], ...]]:
    """Give the newest node three closures: with itself (a true one), with the first node, with the second."""
    nodes = [r for r in records if r.change.added]
    newest, at = len(nodes) - 1, nodes[-1]
    made = [
        Decision(at.stamp_ns, claim(at, nodes, newest, newest), Verdict.PENDING, "waits for others"),
        Decision(at.stamp_ns, claim(at, nodes, newest, newest), Verdict.ACCEPTED, "3 closures agree"),
        Decision(at.stamp_ns, claim(at, nodes, newest, 0), Verdict.ACCEPTED, "it looked alike"),
        Decision(at.stamp_ns, claim(at, nodes, newest, 1), Verdict.REFUSED, "odometry contradicts it"),
    ]
    changed = [replace(r, change=replace(r.change, decisions=tuple(made) if r is at else ())) for r in records]
    return changed, ((newest, newest), (newest, 0), (newest, 1))


@pytest.fixture(scope="session")
def trail(tmp_path_factory: pytest.TempPathFactory) -> Trail:
    folder, config = tmp_path_factory.mktemp("trail"), load_config()
    robot, navigator = SimRobot(worlds.load("room-corridor"), config.sim, 0), build_navigator(config.stack)
    readings, truths, records = [], [], []
    for _ in range(STEPS):
        reading = robot.sense()
        assert reading is not None
        readings.append(reading)
        truths.append(robot.truth())
        records.append(navigator.step(reading)[1])
    changed, pairs = planted(records)
    header = run_header("trail", robot.rig, 0, config.resolved(), start=truths[0])
    for name, known in (("run.mcap", True), ("blind.mcap", False)):
        with Recorder(folder / name, header) as recorder:
            steps = RunRecorder(recorder, MapNow)
            for reading, record, truth in zip(readings, changed, truths, strict=True):
                steps.observe(reading, record, truth if known else None)
    return Trail(folder / "run.mcap", folder / "blind.mcap", *pairs)


def call(monkeypatch: pytest.MonkeyPatch, *words: object) -> int:
    monkeypatch.setattr(sys, "argv", ["topomap", "closures", *map(str, words)])
    with pytest.raises(SystemExit) as stopped:
        main()
    return int(stopped.value.code or 0)


def rows(capsys: pytest.CaptureFixture[str]) -> list[list[str]]:
    """The first five columns of the rows that were printed: time, query, match, verdict, truth."""
    lines = capsys.readouterr().out.splitlines()
    assert "closure candidates of trail" in lines[0]
    assert lines[1].split()[:5] == ["time", "[s]", "query", "match", "verdict"]
    assert int(lines[0].split()[0]) == len(lines[2:])
    return [line.split()[1:5] for line in lines[2:]]


def row(pair: tuple[int, int], verdict: str, truth: str) -> list[str]:
    return [str(pair[0]), str(pair[1]), verdict, truth]


def test_all_are_listed_by_match_with_verdict_and_truth(
    trail: Trail, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(monkeypatch, trail.log) == 0
    assert rows(capsys) == [
        row(trail.fooled, "accepted", "false"),
        row(trail.refused, "refused", "false"),
        row(trail.accepted, "accepted", "true"),
    ]


@pytest.mark.parametrize(("verdict", "kept"), [("accepted", 2), ("refused", 1), ("pending", 0), ("withdrawn", 0)])
def test_only_those_with_a_verdict(
    trail: Trail, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], verdict: str, kept: int
) -> None:
    """What was pending first is listed by where it ended."""
    assert call(monkeypatch, trail.log, "--verdict", verdict) == 0
    found = rows(capsys)
    assert len(found) == kept
    assert {line[2] for line in found} <= {verdict}


def test_only_false_ones_and_both_filters_together(
    trail: Trail, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(monkeypatch, trail.log, "--false") == 0
    assert rows(capsys) == [row(trail.fooled, "accepted", "false"), row(trail.refused, "refused", "false")]
    assert call(monkeypatch, trail.log, "--false", "--verdict", "accepted") == 0
    assert rows(capsys) == [row(trail.fooled, "accepted", "false")]


def test_a_limit_says_how_many_are_left(
    trail: Trail, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(monkeypatch, trail.log, "--limit", 1) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "2 more"


@pytest.mark.parametrize("by_time", [False, True])
def test_one_is_explained_with_its_history_and_a_picture(
    trail: Trail,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    by_time: bool,
) -> None:
    assert call(monkeypatch, trail.log) == 0
    seconds = capsys.readouterr().out.splitlines()[2].split()[0]
    query, match = (f"{seconds}s" if by_time else str(trail.accepted[0])), trail.accepted[1]
    assert call(monkeypatch, trail.log, "--explain", query, match, "--out", tmp_path / "why") == 0
    told = " ".join(capsys.readouterr().out.split())
    for part in (
        "score cost",
        "limit certainty",
        "│ truth │ true: 0.00 m apart",
        "pending: waits",
        "accepted: 3 closures",
    ):
        assert part in told
    picture = cv2.imread(str(next((tmp_path / "why").glob("closure-*.png"))))
    assert picture is not None
    assert picture.std() > 10, "it shows something"


def test_precision_and_recall_by_hand(
    trail: Trail, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Two accepted, one of them true; the only true candidate was accepted and is the most similar one."""
    assert call(monkeypatch, trail.log, "--evaluate", "--out", tmp_path) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "3 candidates, 1 true" in told
    assert "1 true, 1 false" in told
    assert "precision │ 0.500" in told
    assert "recall │ 1.000" in told
    assert "by similarity │ area 1.000" in told
    assert (tmp_path / "precision-recall.png").stat().st_size > 1000


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--explain", "999", "0"], "no candidate between '999' and node 0"),
        (["--explain", "0.3s", "0"], "no candidate between '0.3s' and node 0"),
        (["--explain", "later", "0"], "the query 'later' is neither a node (12) nor a time (41.5s)"),
        (["--explain", "1", "door"], "the match 'door' is no node"),
    ],
)
def test_an_unknown_pair_is_one_line(
    trail: Trail, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], words: list[str], says: str
) -> None:
    assert call(monkeypatch, trail.log, *words) == 2
    printed = capsys.readouterr()
    assert says in printed.err
    assert printed.err.count("\n") == 1


def test_without_truth_there_is_a_list_but_no_judgement(
    trail: Trail, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert call(monkeypatch, trail.blind) == 0
    assert {line[3] for line in rows(capsys)} == {"–"}
    assert call(monkeypatch, trail.blind, "--explain", *trail.accepted, "--out", tmp_path) == 0
    assert "│ truth" not in capsys.readouterr().out
    for word, says in (("--false", "the log holds no true poses"), ("--evaluate", "nothing to evaluate")):
        assert call(monkeypatch, trail.blind, word) == 2
        printed = capsys.readouterr()
        assert says in printed.err
        assert printed.err.count("\n") == 1
        assert not printed.out


def test_a_file_that_is_no_log_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "note.mcap").write_text("not a log")
    for name in ("note.mcap", "missing.mcap"):
        assert call(monkeypatch, tmp_path / name) == 2
        printed = capsys.readouterr()
        assert name in printed.err
        assert printed.err.count("\n") == 1
