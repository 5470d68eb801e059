"""What the recorder writes of odd steps, what a reader makes of odd logs, and true poses: the same as before."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from kept import as_before

from logs import header as head
from logs import records as log
from logs import topics
from logs.errors import LogError
from logs.mcap_file import Item
from logs.reader import Gathered
from logs.recorder import Recorder
from logs.replay import _motion, decoded
from logs.schemas import codec
from topomap.core.errors import DataError
from topomap.core.evidence import Evidence
from topomap.core.geometry import Pose2
from topomap.core.recorded import RecordedRig
from topomap.core.records import (
    CalibrationState,
    Candidate,
    Command,
    Decision,
    Estimate,
    Goal,
    HomeVector,
    MapChange,
    Motion,
    MountLean,
    NodeAdded,
    Phase,
    PlaceMatch,
    StepRecord,
    Travel,
    Verdict,
    Where,
)
from topomap.core.run_data import TrueCalibration, Trust
from topomap.recording import decode, encode, run_reader, true_nodes
from topomap.recording.legs import milestones
from topomap.recording.recorder import FinalMap, MapNow, RunRecorder, _final, _rows
from topomap.recording.recover import recover_log
from topomap.recording.steps import read_steps

RIG = RecordedRig(8, 2, 0.5, 8 / math.tau, 0.6, 4, True)
PNG = bytes(cv2.imencode(".png", np.zeros((2, 8, 3), np.uint8))[1].tobytes())
STATE = CalibrationState(Estimate(1.04, 0.01, True), Estimate(1.0, 0.2, False), Estimate(0.003, 0.001, True))


class Written:
    """Stands for a log: keeps what is written."""

    def __init__(self) -> None:
        self.rows: list[str] = []
        self.checked: list[int] = []

    def check(self, stamp_ns: int) -> None:
        self.checked.append(stamp_ns)
        if stamp_ns < 0:
            raise LogError("no stamp")

    def write(self, stamp_ns: int, topic: str, record: object) -> None:
        self.rows.append(f"{stamp_ns} {topic} {record}".replace("\n", " "))

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        self.rows.append(f"attached {name} {media_type} {data!r}")

    def close(self) -> None:
        self.rows.append("closed")


def reading(k: int, ranges: bool = True, contact: bool = False) -> SimpleNamespace:
    far = np.array([1.0, 2.0, np.nan, 4.0, np.inf, 6.0, 7.0, 8.0], np.float32) if ranges else None
    return SimpleNamespace(stamp_ns=k, image=np.zeros((2, 8, 3), np.uint8), encoded=b"png", ranges=far, rig=RIG,
                           motion=Motion(0.1, 0.0, 0.2, np.eye(3), 0.25), contact=contact, driven=k < 2)  # fmt: skip


def decision(verdict: Verdict, query: int | None = 3) -> Decision:
    candidate = Candidate(7, 1, 2, Pose2(0.1, 0.2, 0.3), 0.5 * np.eye(3), 0.6, query, Evidence(0.3, looks=1.0))
    return Decision(8, candidate, verdict, "because")


def step(k: int, **told: object) -> StepRecord:
    change = MapChange(Pose2(1.0, 2.0, 0.5), 0.25, 0.75, **{name: told.pop(name) for name in list(told) if name in (
        "place", "added", "decisions", "solved", "calibration", "broken", "mended")})  # fmt: skip
    travel = told.pop("travel", Travel(Phase.TEACH))
    where = Where(Pose2(1.0, 2.5, 0.5), 4, 0.3, 0.125, event=str(told.pop("event", "")))
    return StepRecord(k, Pose2(0.5, 1.0, 0.25), change, where, Goal(Phase.TRAVEL, 5), travel, Command(0.25, -0.5),
                      told.pop("timings", {}))  # fmt: skip


def test_odd_steps_are_written_as_before() -> None:
    out = Written()
    nodes = tuple((10 + k, Pose2(k, 0.0, 0.0), k % 2 == 0) for k in range(25))
    now = MapNow(nodes, ((10, 11, "odometry"), (12, 14, "closure"), (11, 12, "odometry")))
    truths = iter([SimpleNamespace(stamp_ns=k, x=1 + k, y=2, heading=0.5, contact=k == 1) for k in range(9)])
    recorder = RunRecorder(out, lambda: now, SimpleNamespace(truth=lambda: next(truths)))  # type: ignore[arg-type]
    added = (NodeAdded(3, 5, Pose2(1.0, 0.0, 0.0), True, "far"),)
    home = HomeVector(0.5, None, 0.75)
    steps = [
        step(0), step(1, added=added, timings={"map": 1.5, "travel": 2.0}), step(2, calibration=STATE, solved=True),
        step(3, calibration=STATE, place=PlaceMatch(2, 0.5, 0.25)),
        step(4, calibration=replace(STATE, curvature=Estimate(0.5, 0.1, False))),
        step(5, travel=Travel(Phase.TRAVEL, 4, home, 0.5, 3, "begins"), event="found itself"),
        step(6, travel=Travel(Phase.TRAVEL, 4, replace(home, distance=1.5), 0.5, 3, "begins")),
        step(7, travel=Travel(Phase.TRAVEL, note=""), broken="slipped", mended="taken"),
        step(8, travel=Travel(Phase.TRAVEL, note="begins"), broken="slipped", event="slipped"),
        *(step(k, decisions=(decision(verdict, query),)) for k, (verdict, query) in enumerate(
            itertools.product(Verdict, (3, None)), start=9)),
        *(step(k) for k in range(17, 21)),
    ]  # fmt: skip
    for k, one in enumerate(steps):
        own = reading(k, ranges=k != 3, contact=k in (4, 5, 7))
        if k == 6:
            recorder.sensed(own, SimpleNamespace(stamp_ns=6, x=9.0, y=9.0, heading=0.0, contact=False))
        recorder.observe(
            own, one, None if k != 8 else SimpleNamespace(stamp_ns=8, x=0.0, y=0.0, heading=0.0, contact=True)
        )
        if k == 6:
            truths = iter(())
            recorder._source = None
    recorder.say("robot", "well")
    recorder.say("robot", "ill", error=True)
    recorder.finish(final(steps_per_s=None))
    recorder.finish(final(decisions=(decision(Verdict.WITHDRAWN),)))
    recorder.attach("a.map", "application/zip", b"zip")
    recorder.close()
    before = len(out.rows)
    with pytest.raises(LogError):
        recorder.sensed(reading(-1))
    recorder.say("robot", "still")
    assert out.rows[before:] == [f"20 {topics.TEXT} {log.Text(log.Level.WARNING, 'robot', 'still')}"]
    assert out.checked == [*range(21), -1]
    as_before("recorder steps", {"rows": out.rows})


def final(**told: object) -> FinalMap:
    usual: dict[str, object] = {
        "stamps_ns": np.array([0, 1, 2]), "poses": np.arange(9.0).reshape(3, 3), "nodes": ((1, 0, Pose2(), True),),
        "edges": ((1, 1, "odometry"),), "calibration": STATE, "graph_hash": "abc", "steps_per_s": 12.5,
    }  # fmt: skip
    return FinalMap(**(usual | told))  # type: ignore[arg-type]


def test_the_finished_map_is_written_as_before() -> None:
    rows = [str(_final(one)) for one in (
        final(), final(calibration=None, claimed=True, goal_node=3, topology_hash="t", fault="broke"),
        final(trust=Trust("kept", 1.5, 0.5), mount=MountLean(0.01, 0.02, 0.003, 0.004, True), claimed=False),
        final(trust=Trust("", None, None), mount=MountLean(0.0, 0.0, 0.003)))]  # fmt: skip
    now = MapNow(((5, Pose2(), True), (3, Pose2(), False)), ((5, 3, "odometry"), (3, 5, "closure")))
    rows += [str(_rows(now, kind).tolist()) for kind in ("odometry", "closure", "other")]
    truth = SimpleNamespace(x=1, y=2, heading=0.5)
    plan = SimpleNamespace(polylines=(np.eye(2),), circles=((1, 2, 3),), labels=((1, 2, "a"),))
    for header in (
        encode.run_header("w", RIG),
        encode.run_header("w", RIG, 3, {"a": 1}, {"b": "2"}, truth, TrueCalibration(1.1, 0.9, 0.01), plan, True),
    ):
        rows += [str(header), str(decode.plan(header)), str(decode.true_calibration(header))]
    for verdict in Verdict:
        rows.append(
            f"{encode.level(verdict)} {encode.sentence(decision(verdict))} {encode.sentence(decision(verdict, None))}"
        )
        assert str(decode.decision(encode.closure(decision(verdict)))) == str(decision(verdict))
    assert decode.calibration(encode.calibration(STATE)) == STATE
    assert np.abs(encode.points(reading(0)).points - [[1.0, 0.0]]).max() < 1e-6
    as_before("recorder finished", {"rows": rows})


def rows_of(**kinds: list[tuple[int, object]]) -> Gathered:
    """Messages by topic, as a log holds them."""
    found = {topic: list[Item]() for topic in run_reader.TOPICS}
    for name, records in kinds.items():
        topic = getattr(topics, name)
        found[topic] = [Item(topic, "", stamp, codec.encode(record)) for stamp, record in records]
    return Gathered(found)


def belief(k: int) -> log.Belief:
    return log.Belief(log.Pose(k, 0.0, 0.1), log.Pose(k, 1.0, 0.2), k, 0.3, 0.1)


def mission(travel: str, goal: int | None = None, milestone: int | None = None) -> log.Mission:
    return log.Mission("travel", goal, travel, milestone, 0, "")


def test_steps_are_those_that_were_logged_wholly() -> None:
    odometry = log.Odometry(0.1, 0.0, 0.2, (1.0,) * 9, 0.25, True, False, True)
    every = {
        "ODOMETRY": [(k, replace(odometry, driven=k > 1, contact=k == 2)) for k in range(6)],
        "BELIEF": [(k, belief(k)) for k in (0, 1, 2, 3, 5)],
        "DIFFERENCE": [(k, log.ImageDifference(0.5, math.nan if k > 3 else 0.1 * k, 0.25)) for k in (0, 1, 2, 4, 5)],
        "MISSION": [(k, mission("teach", k if k < 2 else None, k)) for k in (0, 1, 3, 4, 5)],
        "TRUTH": [(0, log.Truth(0, 1.0, 2.0, 3.0, False))],
        "TIMINGS": [(1, log.Timings((log.Score("map", 2.0),))), (5, log.Timings((log.Score("travel", 1.0),)))],
    }  # fmt: skip
    said = []
    for left_out in ("", "TRUTH", "TIMINGS", "BELIEF"):
        found = read_steps(rows_of(**{name: one for name, one in every.items() if name != left_out}))
        said.append(f"{found.stamps_ns.tolist()} {found.online.tolist()} {found.dead_reckoning.tolist()} "
                    f"{None if found.truth is None else found.truth.tolist()} {found.driven.tolist()} "
                    f"{found.contact.tolist()} {found.stage_ms} {found.difference('place').tolist()}")  # fmt: skip
        said.append(f"{run_reader._threshold(found)} {run_reader._goal(found, None)} {milestones(found.missions)}")
    as_before("recorder steps read", {"said": said})


def test_what_a_reader_makes_of_ends_is_as_before() -> None:
    def steps(*missions: log.Mission) -> SimpleNamespace:
        return SimpleNamespace(missions=missions, stamps_ns=np.arange(4), online=np.zeros((4, 3)))

    end = _final(final(claimed=True, goal_node=3, mount=MountLean(0.1, 0.2, 0.3, 0.4, True)))
    bare = _final(final())
    for one, goal, claimed in ((end, 3, True), (bare, 7, None), (None, 7, True)):
        made = steps(
            mission("teach", 5), mission("travel", 7, 4), mission("arrived", None, 4), mission("arrived", None, 2)
        )
        assert run_reader._goal(made, one) == goal
        assert run_reader._claimed(made, one) is claimed
        assert milestones(made.missions) == (4, 2)
    assert run_reader._claimed(steps(mission("teach")), None) is None
    assert run_reader._claimed(steps(mission("teach"), mission("failed")), None) is False
    assert run_reader._goal(steps(mission("teach")), None) is None
    assert run_reader._mount(end) == MountLean(0.1, 0.2, 0.3, 0.4, True)
    assert run_reader._mount(replace(end, sway=None, taken_out=None)) == MountLean(0.1, 0.2, 0.3, 0.0, False)
    for lacking in ("roll", "pitch", "lean_sigma"):
        assert run_reader._mount(replace(end, **{lacking: None})) is None
    assert run_reader._mount(None) is None
    found = run_reader._trajectory(steps(), replace(end, stamps_ns=(1, 3, 9)))
    assert found.tolist() == [[0, 0, 0], [0, 1, 2], [0, 0, 0], [3, 4, 5]]
    assert run_reader._trajectory(steps(), None).tolist() == np.zeros((4, 3)).tolist()
    run_reader._check_poses(np.full((1, 3), run_reader.FARTHEST * 0.999))
    for wrong in (run_reader.FARTHEST, -run_reader.FARTHEST, math.nan):
        with pytest.raises(ValueError, match="no numbers or farther"):
            run_reader._check_poses(np.zeros((1, 3)), np.array([[0.0, wrong, 0.0]]))
    assert len(read_steps(rows_of()).stamps_ns) == 0
    assert run_reader._threshold(read_steps(rows_of())) is None


def test_the_first_closures_views_are_those_before_it_and_its_match() -> None:
    file = SimpleNamespace(panorama=lambda stamp: PNG if stamp != 2 else None)
    steps = SimpleNamespace(stamps_ns=np.arange(0, 40))
    none = decision(Verdict.REFUSED)
    assert run_reader._first_closure(file, steps, (none,)) == ()
    for query in (7, 30):
        accepted = decision(Verdict.ACCEPTED)
        accepted = replace(accepted, candidate=replace(accepted.candidate, query_ns=query))
        found = run_reader._first_closure(file, steps, (none, accepted, decision(Verdict.ACCEPTED)))
        before = [f"{n} steps before" for n in run_reader.BEFORE if n <= query and query - n != 2]
        assert [label for label, _ in found] == [*before, "at the first closure"]
        assert all(image.shape == (2, 8, 3) for _, image in found)
    found = run_reader._first_closure(
        file, steps, (replace(accepted, candidate=replace(accepted.candidate, match_ns=5)),)
    )
    assert found[-1][0] == "its match, node 1"


def test_true_poses_are_written_and_read_as_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    truths = {9: (1.5, -2.0, 0.25), 3: (0.1, 0.2, 0.3)}
    text = true_nodes.truths_text(truths)
    assert text == "node,x_m,y_m,heading_rad\n3,0.1,0.2,0.3\n9,1.5,-2.0,0.25\n"
    path = true_nodes.truth_file(tmp_path / "run.topomap")
    assert path.name == "run.truth.csv"
    assert true_nodes.read_truths(path) == {}
    path.write_text(text)
    assert true_nodes.read_truths(path) == truths
    assert true_nodes.parse_truths(text + "4,nan,0,0\n5,0,inf,0\n", "x") == truths
    for wrong in ("", "a,b\n", text + "1,2\n", text + "a,1,2,3\n", text + "1,b,2,3\n", text.replace("node", "nodes")):
        with pytest.raises(DataError, match="x: not the true poses"):
            true_nodes.parse_truths(wrong, "x")
    monkeypatch.setattr(true_nodes, "LARGEST", len(text))
    assert true_nodes.read_truths(path) == truths
    monkeypatch.setattr(true_nodes, "LARGEST", len(text) - 1)
    with pytest.raises(DataError, match="are more than the true poses"):
        true_nodes.read_truths(path)
    path.write_bytes(b"\xff\xfe")
    monkeypatch.setattr(true_nodes, "LARGEST", 99)
    with pytest.raises(DataError, match="can't be read"):
        true_nodes.read_truths(path)


def test_earlier_nodes_true_poses_are_those_of_the_logs_attachment() -> None:
    nodes = (SimpleNamespace(node=3, stamp_ns=30), SimpleNamespace(node=4, stamp_ns=40))
    text = true_nodes.truths_text({3: (1.0, 2.0, 3.0)}).encode()
    for content, found in ((text, {30: [1.0, 2.0, 3.0]}), (None, {}), (b"", {})):
        said = run_reader._earlier(SimpleNamespace(attachment=lambda name, c=content: c), nodes)
        assert {stamp: pose.tolist() for stamp, pose in said.items()} == found


def test_a_log_is_recovered_and_what_was_wrong_is_said(tmp_path: Path) -> None:
    path, target = tmp_path / "a.mcap", tmp_path / "b.mcap"
    header = head.Header("w", head.Rig(8, 2, 0.5, 1.0, 0.6, 4, True))
    with Recorder(path, header, "none") as recorder:
        recorder.write(1, topics.COMMAND, log.Command(0.1, 0.2))
    assert recover_log(path, target) == ("1 messages saved, 0 damaged records left out", "")
    with pytest.raises(DataError, match="can't be written"):
        recover_log(path, target)
    path.write_bytes(path.read_bytes()[:-30])
    told, wrong = recover_log(path, tmp_path / "c.mcap")
    assert told == "1 messages saved, 0 damaged records left out"
    assert wrong.startswith("cut off: ")


def test_images_and_covariances_that_are_none_are_refused() -> None:
    assert decoded(PNG).shape == (2, 8, 3)
    for data in (PNG[:30], b"rubbish", b""):
        with pytest.raises(LogError, match="can't be decoded"):
            decoded(data)
    with pytest.raises(LogError, match="has 8 numbers, not 9"):
        _motion(log.Odometry(0.1, 0.0, 0.2, (1.0,) * 8, 0.25, True, False, True))
