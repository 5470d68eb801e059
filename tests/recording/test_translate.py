"""A run through translator and log comes back as the arrays of the study."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from google.protobuf.json_format import MessageToDict
from kept import as_before
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from numpy.typing import NDArray

from logs import records as log
from logs import topics
from logs.reader import LogReader
from logs.recorder import Recorder
from logs.replay import ReplayRobot
from logs.schemas.foxglove import decode_text
from topomap.core.errors import DataError
from topomap.core.evidence import Evidence
from topomap.core.geometry import Pose2
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
    NodeAdded,
    Phase,
    PlaceMatch,
    Plan,
    StepRecord,
    Travel,
    Verdict,
    Where,
)
from topomap.core.robot import Reading, Robot, TruthSource
from topomap.core.run_data import TrueCalibration
from topomap.recording import true_nodes
from topomap.recording.encode import run_header
from topomap.recording.recorder import FinalMap, MapNow, RunRecorder
from topomap.recording.run_reader import PartialLogWarning, load_run
from topomap.recording.true_nodes import parse_truths, read_truths

EPOCH, STEP, STEPS = 1_700_000_000_000_000_000, 250_000_000, 30
STATE = CalibrationState(Estimate(1.04, 0.01, True), Estimate(1.0, 0.2, False), Estimate(0.003, 0.001, True))
PLAN = Plan((np.array([[0.0, 0.0], [4.0, 0.0]]),), ((1.0, 1.0, 0.3),), ((2.0, 2.0, "door"),))
CLOSED_AT = 24  # the step whose panorama closed the loop with node 0


@dataclass(frozen=True)
class SomeRig:
    width: int = 72
    height: int = 10
    horizon_row: float = 4.5
    focal: float = 11.46
    camera_height: float = 0.6
    forward_column: int = 36
    clockwise: bool = True


@dataclass(frozen=True)
class SomeReading:
    stamp_ns: int
    image: NDArray[np.uint8]
    encoded: bytes
    ranges: NDArray[np.float32] | None
    motion: Motion
    rig: SomeRig
    contact: bool
    driven: bool


@dataclass(frozen=True)
class SomeTruth:
    stamp_ns: int
    x: float
    y: float
    heading: float
    contact: bool = False


def _stamp(step: int) -> int:
    return EPOCH + step * STEP


def _pose(step: int) -> Pose2:
    return Pose2(0.1 * step, 0.01 * step * step, 0.02 * step)


def _reading(step: int) -> SomeReading:
    rng = np.random.default_rng(step)
    image = rng.integers(0, 255, (10, 72, 3), dtype=np.uint8)
    encoded = cv2.imencode(".png", image[:, :, ::-1])[1].tobytes()
    motion = Motion(0.1, 0.001 * step, 1 / 3, rng.random((3, 3)), 0.25)
    ranges = rng.random(72).astype(np.float32)
    ranges[5] = np.nan
    return SomeReading(_stamp(step), image, encoded, ranges, motion, SomeRig(), step == 3, step < 20)


def _decision(verdict: Verdict, step: int) -> Decision:
    covariance = np.arange(9.0).reshape(3, 3)
    relative = Pose2(0.1, 0.2, 1 / 7)
    scores = Evidence.of({"gate": 1.5, "margin": float("inf")})
    query = CLOSED_AT - (verdict is Verdict.PENDING)  # what waits was seen before what is accepted
    candidate = Candidate(_stamp(query), 0, _stamp(0), relative, covariance, 0.9, 1, scores)
    return Decision(_stamp(step), candidate, verdict, "both say so")


def _change(step: int) -> MapChange:
    added: tuple[NodeAdded, ...] = ()
    decisions: tuple[Decision, ...] = ()
    if step in (0, CLOSED_AT):
        node = 0 if step == 0 else 1
        added = (NodeAdded(node, _stamp(step), _pose(step), step == 0, "the view changed"),)
    if step in (25, 26):
        decisions = (_decision(Verdict.PENDING if step == 25 else Verdict.ACCEPTED, step),)
    return MapChange(
        pose=_pose(step),
        difference=float("nan") if step == 0 else 0.01 * step,
        threshold=0.3,
        place=PlaceMatch(0, 0.4, 0.1) if step > 10 else None,
        added=added,
        decisions=decisions,
        solved=step == 26,
        calibration=STATE if step == 26 else None,
    )


def _record(step: int) -> StepRecord:
    home = step >= 27
    travel = Travel(
        Phase.TRAVEL if home else Phase.TEACH,
        milestone=(1 if step == 27 else 0) if home else None,
        home=HomeVector(0.5, None, 0.8) if home else None,
        difference=0.2 if home else float("nan"),
        legs_left=1,
        note="turned back" if home else "",
    )
    return StepRecord(
        stamp_ns=_stamp(step),
        dead_reckoning=Pose2(0.2 * step, 0.0, 0.1),
        change=_change(step),
        where=Where(_pose(step), 0 if step else None, 0.1, 0.0),
        goal=Goal(Phase.TRAVEL if home else Phase.TEACH, 0 if home else None),
        travel=travel,
        command=Command(0.3, -0.1),
        timings={"vision": 1.5},
    )


def _map() -> MapNow:
    nodes = ((0, _pose(0), True), (1, _pose(CLOSED_AT), False))
    return MapNow(nodes, ((0, 1, "odometry"), (1, 0, "closure")))


def _final() -> FinalMap:
    poses = np.array([_pose(step).array() + 0.5 for step in range(STEPS)])
    nodes = ((0, _stamp(0), Pose2(0.5, 0.5, 0.5), True), (1, _stamp(CLOSED_AT), Pose2(1.0, 2.0, 3.0), False))
    edges = ((0, 1, "odometry"), (1, 0, "closure"))
    stamps = np.array([_stamp(step) for step in range(STEPS)])
    return FinalMap(stamps, poses, nodes, edges, STATE, "cafe", 61.5, True, 0)


def _truth(step: int) -> SomeTruth:
    return SomeTruth(_stamp(step), 1.0 + 0.1 * step, 2.0, 1 / 3 - step)


def _write(path: Path, finish: bool = True, final: FinalMap | None = None) -> None:
    header = run_header(
        "room",
        SomeRig(),
        seed=3,
        config={"sim": {"noise": 0.02}},
        versions={"topomap": "0.1.0"},
        start=_truth(0),
        true_calibration=TrueCalibration(1.04, 0.95, None),
        plan=PLAN,
    )
    with Recorder(path, header) as recorder:
        run = RunRecorder(recorder, _map)
        for step in range(STEPS):
            run.observe(_reading(step), _record(step), _truth(step))
        if finish:
            run.finish(final or _final())
            run.attach("map.zip", "application/zip", b"the map")


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("run") / "run.mcap"
    _write(path)
    return path


def test_a_run_comes_back(path: Path) -> None:
    run = load_run(path)
    steps = range(STEPS)
    assert (run.world, run.seed, run.config) == ("room", 3, {"sim": {"noise": 0.02}})
    assert run.versions == {"topomap": "0.1.0"}
    assert run.stamps_ns.tolist() == [_stamp(step) for step in steps]
    np.testing.assert_array_equal(run.online, [_pose(step).array() for step in steps])
    np.testing.assert_array_equal(run.dead_reckoning, [[0.2 * step, 0.0, 0.1] for step in steps])
    np.testing.assert_array_equal(run.final, _final().poses)
    assert run.truth is not None
    np.testing.assert_array_equal(run.truth, [[t.x, t.y, t.heading] for t in map(_truth, steps)])
    assert run.driven is not None
    assert run.driven.tolist() == [step < 20 for step in steps]
    assert run.contact is not None
    assert np.flatnonzero(run.contact).tolist() == [3]
    assert (run.goal_node, run.claimed, run.milestones) == (0, True, (1, 0))
    assert (run.graph_hash, run.steps_per_s, run.threshold) == ("cafe", 61.5, 0.3)
    assert not run.replayed


def test_differences_come_back(path: Path) -> None:
    run = load_run(path)
    assert run.difference is not None
    assert run.place_difference is not None
    assert run.homing_difference is not None
    np.testing.assert_array_equal(run.difference[1:], [0.01 * step for step in range(1, STEPS)])
    assert np.isnan(run.difference[0])
    assert np.isfinite(run.place_difference).sum() == STEPS - 11
    assert np.isfinite(run.homing_difference).sum() == 3


def test_map_closures_and_calibration_come_back(path: Path) -> None:
    run = load_run(path)
    assert [(n.node, n.stamp_ns, n.snapshot) for n in run.nodes] == [
        (0, _stamp(0), True),
        (1, _stamp(CLOSED_AT), False),
    ]
    np.testing.assert_array_equal(run.nodes[1].pose, [1.0, 2.0, 3.0])
    assert run.edges == ((0, 1, "odometry"), (1, 0, "closure"))
    assert [decision.verdict for decision in run.decisions] == [Verdict.PENDING, Verdict.ACCEPTED]
    found, wanted = run.decisions[1], _decision(Verdict.ACCEPTED, 26)
    np.testing.assert_array_equal(found.candidate.covariance, wanted.candidate.covariance)
    same = replace(found.candidate, covariance=wanted.candidate.covariance)
    assert (same.relative, same.evidence) == (wanted.candidate.relative, wanted.candidate.evidence)
    assert (found.reason, found.stamp_ns, same.query, same.match_ns) == ("both say so", _stamp(26), 1, EPOCH)
    assert run.calibration == STATE
    assert run.true_calibration == TrueCalibration(1.04, 0.95, None)
    np.testing.assert_array_equal(run.plan.polylines[0], PLAN.polylines[0])
    assert (run.plan.circles, run.plan.labels) == (PLAN.circles, PLAN.labels)


def test_the_first_closures_panoramas_are_the_recorded_ones(path: Path) -> None:
    shown = load_run(path).first_closure
    assert [label for label, _ in shown] == [
        "20 steps before",
        "10 steps before",
        "at the first closure",
        "its match, node 0",
    ]
    for (_, image), step in zip(shown, (4, 14, 24, 0), strict=True):
        np.testing.assert_array_equal(image, _reading(step).image)


def test_a_replay_fits_the_contract_and_senses_the_same(path: Path) -> None:
    replay = ReplayRobot(path)
    robot: Robot = replay
    source: TruthSource = replay
    for step in range(STEPS):
        found, wanted = robot.sense(), _reading(step)
        assert found is not None
        _same(found, wanted)
        truth = source.truth()
        assert truth is not None
        assert (truth.x, truth.heading) == (_truth(step).x, _truth(step).heading)
        robot.act(Command())
    assert robot.sense() is None


def _same(found: Reading, wanted: Reading) -> None:
    assert (found.stamp_ns, found.encoded, found.driven) == (wanted.stamp_ns, wanted.encoded, wanted.driven)
    np.testing.assert_array_equal(found.image, wanted.image)
    assert found.ranges is not None
    assert wanted.ranges is not None
    assert found.ranges.tobytes() == wanted.ranges.tobytes()
    assert found.motion.covariance.tobytes() == wanted.motion.covariance.tobytes()
    assert (found.motion.left, found.motion.turn) == (wanted.motion.left, wanted.motion.turn)
    assert found.rig.focal == wanted.rig.focal


def test_viewers_see_the_map_and_the_frames(path: Path) -> None:
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        rows = [(c.topic, m.log_time, p) for _, c, m, p in reader.iter_decoded_messages()]
    stamps = [stamp for _, stamp, _ in rows]
    assert stamps == sorted(stamps)
    graphs = [(stamp, p) for topic, stamp, p in rows if topic == topics.GRAPH]
    assert [stamp for stamp, _ in graphs] == [_stamp(0), _stamp(CLOSED_AT), _stamp(26), _stamp(STEPS - 1)]
    assert [len(g.entities[0].lines) for _, g in graphs] == [2, 2, 2, 2]
    frames = [p for topic, _, p in rows if topic == topics.TRANSFORMS]
    assert len(frames) == STEPS
    assert [(t.parent_frame_id, t.child_frame_id) for t in frames[5].transforms] == [
        ("world", "map"),
        ("map", "odom"),
        ("odom", "base_link"),
    ]
    start, odom, body = frames[5].transforms
    assert (start.translation.x, start.translation.y) == (1.0, 2.0)
    half = 2 * np.arctan2(odom.rotation.z, odom.rotation.w)
    x = odom.translation.x + np.cos(half) * body.translation.x - np.sin(half) * body.translation.y
    assert x == pytest.approx(_pose(5).x)
    texts = [p.message for topic, _, p in rows if topic == topics.TEXT]
    assert "node 1 with node 0 accepted: both say so" in texts
    assert texts.count("turned back") == 1
    assert texts.count("contact") == 1, "said when it begins"


def test_what_the_last_solve_withdrew_is_in_the_log(tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", run_header("room", SomeRig())) as recorder:
        run = RunRecorder(recorder, _map)
        for step in range(STEPS):
            run.observe(_reading(step), _record(step))
        run.finish(replace(_final(), decisions=(_decision(Verdict.WITHDRAWN, STEPS - 1),)))
    verdicts = [decision.verdict for decision in load_run(tmp_path / "run.mcap").decisions]
    assert verdicts == [Verdict.PENDING, Verdict.ACCEPTED, Verdict.WITHDRAWN]


def test_what_is_wrong_with_the_odometry_is_a_warning_once(tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", run_header("room", SomeRig())) as recorder:
        run, record = RunRecorder(recorder, _map), _record(0)
        change, where = replace(record.change, broken="carried away"), replace(record.where, event="carried away")
        run.observe(_reading(0), replace(record, change=change, where=where))
        run.observe(_reading(1), replace(_record(1), change=replace(_change(1), mended="the odometry leapt")))
    with LogReader(tmp_path / "run.mcap") as reader:
        said = [decode_text(item.data) for item in reader.items(topics.TEXT)]
    wrong = [(text.level, text.message) for text in said if text.name == "odometry"]
    assert wrong == [(log.Level.WARNING, "carried away"), (log.Level.WARNING, "the odometry leapt")]


def test_the_drawn_edges_are_the_maps_own(tmp_path: Path) -> None:
    """Node 3 was inserted between 0 and 1: 2 and 3 aren't joined, and what was withdrawn isn't drawn."""
    at = [Pose2(), Pose2(2.0), Pose2(3.0), Pose2(1.0)]
    edges = ((0, 3, "odometry"), (3, 1, "odometry"), (1, 2, "odometry"), (0, 2, "closure"))
    now = MapNow(tuple((k, pose, True) for k, pose in enumerate(at)), edges)
    with Recorder(tmp_path / "run.mcap", run_header("room", SomeRig())) as recorder:
        run = RunRecorder(recorder, lambda: now)
        run.observe(_reading(0), _record(0))
        run.observe(_reading(26), _record(26))
    drawn = _drawn(tmp_path / "run.mcap")
    assert sorted(drawn) == sorted({at[a].x, at[b].x} for a, b, _ in edges)


def test_the_last_drawing_is_the_finished_map(path: Path) -> None:
    assert _drawn(path) == [{0.5, 1.0}, {0.5, 1.0}]


def _drawn(path: Path) -> list[set[float]]:
    """The x of both ends of each line of the last drawing."""
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        drawing = [p for _, c, _, p in reader.iter_decoded_messages(topics=[topics.GRAPH])][-1]
    ends = [point.x for line in drawing.entities[0].lines for point in line.points]
    return [set(pair) for pair in zip(ends[::2], ends[1::2], strict=True)]


def test_a_cut_off_run_falls_back_on_what_was_believed(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    _write(path, finish=False)
    content = path.read_bytes()
    path.write_bytes(content[: int(0.6 * len(content))])
    run = load_run(path)
    assert 8 < len(run.stamps_ns) < STEPS
    np.testing.assert_array_equal(run.final, run.online)
    assert (run.graph_hash, run.edges, run.claimed, run.goal_node) == ("", (), None, None)
    assert [node.node for node in run.nodes] == [0]
    assert run.first_closure == ()


def test_an_unfinished_journey_was_not_claimed(tmp_path: Path) -> None:
    _write(tmp_path / "run.mcap", finish=False)
    run = load_run(tmp_path / "run.mcap")
    assert (run.claimed, run.goal_node, run.calibration) == (False, 0, STATE)


def test_the_goal_that_the_end_names_is_the_goal(tmp_path: Path) -> None:
    for said, goal in ((1, 1), (None, 0)):
        _write(tmp_path / "run.mcap", final=replace(_final(), goal_node=said))
        assert load_run(tmp_path / "run.mcap").goal_node == goal


def test_true_poses_are_those_under_the_right_columns() -> None:
    found = parse_truths("node,x_m,y_m,heading_rad\n3,1.5,2,0.25\n4,nan,0,0\n", "a.csv")
    assert found == {3: (1.5, 2.0, 0.25)}
    for text in ("node,x_m,heading_rad,y_m\n3,1,2,3\n", "3,1,2,3\n", "", "node,x_m,y_m,heading_rad\n3,1,2\n"):
        with pytest.raises(DataError, match=r"a.csv: not the true poses of a map"):
            parse_truths(text, "a.csv")


@pytest.mark.parametrize("value", [math.nan, math.inf, -1e308])
def test_a_pose_that_no_robot_has_is_a_data_error(value: float, tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", run_header("room", SomeRig())) as recorder:
        run = RunRecorder(recorder, _map)
        for step in range(3):
            record = _record(step)
            run.observe(_reading(step), replace(record, dead_reckoning=Pose2(value if step == 1 else 0.0)))
    with pytest.raises(DataError, match=r"holds values that no run writes .*poses that are no numbers"):
        load_run(tmp_path / "run.mcap")


def test_what_is_no_log_is_a_data_error(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    with pytest.raises(DataError, match="No such file"):
        load_run(path)
    path.write_bytes(b"hello there")
    with pytest.raises(DataError, match="not an MCAP file"):
        load_run(path)
    Recorder(path, run_header("room", SomeRig())).close()
    with pytest.raises(DataError, match="no whole step"):
        load_run(path)


def test_the_truth_is_asked_for_where_it_is_not_given(tmp_path: Path) -> None:
    class Source:
        def truth(self) -> SomeTruth:
            return _truth(0)

    with Recorder(tmp_path / "run.mcap", run_header("room", SomeRig())) as recorder:
        RunRecorder(recorder, _map, Source()).observe(_reading(0), _record(0))
    with LogReader(tmp_path / "run.mcap") as reader:
        assert next(reader.records(topics.TRUTH, log.Truth))[1].heading == 1 / 3


def test_a_reading_is_on_record_before_its_step_and_only_once(tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", run_header("room", SomeRig())) as recorder:
        run, first, second = RunRecorder(recorder, _map), _reading(0), _reading(1)
        run.sensed(first, _truth(0))
        run.observe(first, _record(0))
        run.sensed(second, _truth(1))
        run.say("disk", "nearly full")
        run.say("fault", "the stack gave up", error=True)
    with LogReader(tmp_path / "run.mcap") as log_file:
        readings = [stamp for stamp, _ in log_file.records(topics.ODOMETRY, log.Odometry)]
        steps = [stamp for stamp, _ in log_file.records(topics.BELIEF, log.Belief)]
        said = [decode_text(item.data) for item in log_file.items(topics.TEXT)]
    assert (readings, steps) == ([_stamp(0), _stamp(1)], [_stamp(0)])
    assert said[-2] == log.Text(log.Level.WARNING, "disk", "nearly full")
    assert said[-1] == log.Text(log.Level.ERROR, "fault", "the stack gave up")


def test_a_fault_and_the_hash_of_the_topology_come_back(tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", run_header("room", SomeRig())) as recorder:
        run = RunRecorder(recorder, _map)
        run.observe(_reading(0), _record(0))
        run.finish(replace(_final(), fault="the camera is gone", topology_hash="beef"))
    found = load_run(tmp_path / "run.mcap")
    assert (found.fault, found.topology_hash, found.log_state, found.log_note) == (
        "the camera is gone", "beef", "whole", "",
    )  # fmt: skip


def test_a_run_that_was_cut_off_is_a_warning(tmp_path: Path, path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[:-30])
    with pytest.warns(PartialLogWarning, match="cut off"):
        assert load_run(cut).log_state == "cut off"


def told(value: object) -> list[str]:
    """Every number and word of a decoded message, in order, with its name; pictures and clouds by their length."""
    if isinstance(value, dict):
        return [f"{name} {one}".rstrip() for name, inner in value.items() for one in told(inner)]
    if isinstance(value, list):
        return [one for inner in value for one in told(inner)]
    return [f"{value:.6g}" if isinstance(value, float) else str(value)[:40]]


def test_every_message_is_as_before(path: Path) -> None:
    steps = {_stamp(step) for step in (0, 3, CLOSED_AT, 25, 26, 27, STEPS - 1)}
    found: dict[str, list[str]] = {}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            if message.log_time in steps:
                words = told(MessageToDict(decoded))
                found.setdefault(f"{channel.topic} {schema.name}", []).extend(words)
    as_before("log", found)


def test_a_truth_that_some_steps_lack_is_none_there(tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", run_header("room", SomeRig())) as recorder:
        run = RunRecorder(recorder, _map)
        for step in range(3):
            run.observe(_reading(step), _record(step), _truth(step) if step != 1 else None)
    truth = load_run(tmp_path / "run.mcap").truth
    assert truth is not None
    assert np.isnan(truth).tolist() == [[False] * 3, [True] * 3, [False] * 3]


def test_a_large_map_is_drawn_after_some_steps_only(tmp_path: Path) -> None:
    """A tenth of its nodes must have come by: here two steps, though each changes the map."""
    now = MapNow(tuple((k, Pose2(k), True) for k in range(20)))
    with Recorder(tmp_path / "run.mcap", run_header("room", SomeRig())) as recorder:
        run = RunRecorder(recorder, lambda: now)
        for step in range(7):
            run.observe(_reading(step), replace(_record(step), change=replace(_change(step), solved=True)))
    with LogReader(tmp_path / "run.mcap") as reader:
        drawn = [item.stamp_ns for item in reader.file.items((topics.GRAPH,))]
    assert drawn == [_stamp(0), _stamp(2), _stamp(4), _stamp(6)]


def test_a_warning_points_at_who_asked(tmp_path: Path, path: Path) -> None:
    (tmp_path / "cut.mcap").write_bytes(path.read_bytes()[:-30])
    with pytest.warns(PartialLogWarning) as caught:
        load_run(tmp_path / "cut.mcap")
    assert caught[0].filename == __file__


def test_true_poses_of_a_huge_file_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "true.csv").write_text("node,x_m,y_m,heading_rad\n0,1.0,2.0,0.5\n")
    assert len(read_truths(tmp_path / "true.csv")) == 1
    monkeypatch.setattr(true_nodes, "LARGEST", 10)
    with pytest.raises(DataError, match="bytes are more"):
        read_truths(tmp_path / "true.csv")
