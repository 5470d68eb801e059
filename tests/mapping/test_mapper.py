"""The mapping wing on a simulated room: snapshots, closures with reasons, corrections; and the accumulated baseline."""

from __future__ import annotations

import numpy as np
import pytest
from kept import as_before, of_drive

from sim2d import worlds
from sim2d.robot import SimRobot
from topomap.app.config import load_config
from topomap.app.wiring import build_navigator
from topomap.core.geometry import wrap
from topomap.core.records import StepRecord, Verdict
from topomap.mapping.mapper import Mapper
from topomap.mapping.places import view_cache
from topomap.mapping.places.small_view import view_of
from topomap.vision.compass.min_warping_compass import MinWarpingCompass


def drive(steps: int, *settings: str, seed: int = 3) -> tuple[Mapper, list[StepRecord], np.ndarray]:
    """The first steps of room-corridor (one round is about 185): mapper, records and true poses."""
    config = load_config(None, settings)
    robot = SimRobot(worlds.load("room-corridor"), config.sim, seed)
    navigator = build_navigator(config.stack)
    records, truth = [], []
    for _ in range(steps):
        reading = robot.sense()
        assert reading is not None
        command, record = navigator.step(reading)
        robot.act(command)
        records.append(record)
        truth.append((robot.truth().x, robot.truth().y, robot.truth().heading))
    return navigator.mapper, records, np.array(truth)


@pytest.fixture(scope="module")
def second_round() -> tuple[Mapper, list[StepRecord], np.ndarray]:
    return drive(260)


def test_nodes_come_by_change_and_never_far_apart(second_round: tuple[Mapper, list[StepRecord], np.ndarray]) -> None:
    mapper, records, _ = second_round
    snapshots = [n for n in mapper.map.nodes if n.snapshot is not None]
    ways = np.diff([n.travel for n in snapshots])
    assert ways.min() > 0.24
    assert ways.max() < 1.15
    reasons = {added.reason for r in records for added in r.change.added}
    assert {"start", "view changed"} <= reasons


def test_the_first_round_closes_nothing_and_the_second_closes_true(
    second_round: tuple[Mapper, list[StepRecord], np.ndarray],
) -> None:
    _, records, truth = second_round
    stamps = [r.stamp_ns for r in records]
    accepted = [d for r in records for d in r.change.decisions if d.verdict is Verdict.ACCEPTED]
    assert len(accepted) >= 5
    for decision in accepted:
        query, match = stamps.index(decision.candidate.query_ns), stamps.index(decision.candidate.match_ns)
        assert query > 170
        assert np.hypot(*(truth[query] - truth[match])[:2]) < 1.0
        assert decision.reason
        assert {"difference", "cost", "ratio", "sigmas"} <= set(decision.candidate.evidence.measured())


def test_a_new_node_lies_where_its_turn_was_measured() -> None:
    config = load_config(None, ())
    robot, navigator, off = SimRobot(worlds.load("room-corridor"), config.sim, 3), build_navigator(config.stack), []
    for _ in range(40):
        reading = robot.sense()
        assert reading is not None
        command, record = navigator.step(reading)
        robot.act(command)
        topo = navigator.mapper.map
        if record.change.added and topo.turns:
            turn = topo.turns[-1]
            off.append(wrap(topo.pose(turn.j).heading - topo.pose(turn.i).heading - turn.turn) / turn.sigma)
    assert len(off) > 5
    assert np.abs(off).max() < 1.0


def test_views_that_a_proposal_may_ask_for_are_decoded_before_it_comes(monkeypatch: pytest.MonkeyPatch) -> None:
    """All at once they took as long as comparing them."""
    decoded = []
    monkeypatch.setattr(view_cache, "view_of", lambda *asked: decoded.append(1) or view_of(*asked))
    config = load_config(None, ())
    robot, navigator = SimRobot(worlds.load("room-corridor"), config.sim, 3), build_navigator(config.stack)
    navigator.mapper.view_cache._size = 14  # a long drive's first views aren't at hand any more
    judged, waiting = [], []
    for _ in range(260):
        reading = robot.sense()
        assert reading is not None
        before = len(decoded)
        command, record = navigator.step(reading)
        robot.act(command)
        looked = [d for d in record.change.decisions if d.candidate.evidence.cost is not None]
        (judged if looked else waiting).append(len(decoded) - before)
    assert sum(judged) < sum(waiting)
    assert max(waiting) <= 2


def test_a_part_of_what_a_proposal_compares_is_compared_in_the_step_before(monkeypatch: pytest.MonkeyPatch) -> None:
    """All at once it made such steps the longest of a drive."""
    compared, align = [], MinWarpingCompass.align
    monkeypatch.setattr(MinWarpingCompass, "align", lambda *asked: compared.append(1) or align(*asked))
    config = load_config(None, ())
    robot, navigator = SimRobot(worlds.load("room-corridor"), config.sim, 3), build_navigator(config.stack)
    judged = []
    for _ in range(260):
        reading = robot.sense()
        assert reading is not None
        before, nodes = len(compared), len(navigator.mapper.map.nodes)
        command, record = navigator.step(reading)
        robot.act(command)
        snapshot = any(added.node >= nodes and added.snapshot for added in record.change.added)
        looked = [d for d in record.change.decisions if d.candidate.evidence.cost is not None]
        judged += [len(compared) - before - snapshot] if looked else []
    assert len(judged) > 10
    assert np.median(judged) <= 2  # of 5
    assert max(judged) <= 4
    assert len(compared) < 70, "nearly all that is compared beforehand is asked for: 58 without"


def test_the_calibration_is_found(second_round: tuple[Mapper, list[StepRecord], np.ndarray]) -> None:
    mapper, _, _ = second_round
    state = mapper.optimisation.state
    assert state.rotation_scale.observed
    assert state.distance_scale.observed
    assert abs(state.distance_scale.value - 0.95) < 0.03
    assert abs(state.rotation_scale.value - 1.04) < 0.03


def test_the_accumulated_rule_is_a_baseline_that_can_be_chosen() -> None:
    usual, _, _ = drive(40)
    baseline, _, _ = drive(40, "stack.mapper.snapshots.rule=accumulated")
    assert len(baseline.map.nodes) > len(usual.map.nodes)


def test_without_ranges_the_ground_line_shows_the_distance_scale_less_exactly() -> None:
    seen = drive(120, "sim.laser.dropout=1.0")[0].optimisation.state.distance_scale
    measured = drive(120)[0].optimisation.state.distance_scale
    assert seen.observed
    assert abs(seen.value - 0.95) < min(0.05, 3 * seen.sigma)
    assert seen.sigma >= 0.015
    assert seen.sigma > measured.sigma


def test_without_ranges_and_floor_the_distance_scale_is_unobserved() -> None:
    mapper, records, _ = drive(60, "sim.laser.max_range=0.01", "sim.camera.horizon_row=97")
    assert not mapper.optimisation.state.distance_scale.observed
    assert mapper.optimisation.state.distance_scale.value == pytest.approx(1.0)
    assert np.isfinite([r.where.pose.array() for r in records]).all()


def test_the_same_readings_give_the_same_map_to_the_bit() -> None:
    first, second = drive(50)[0], drive(50)[0]
    assert first.graph_hash() == second.graph_hash()
    assert first.graph_hash() != drive(50, seed=4)[0].graph_hash()


def test_the_drive_is_as_before(second_round: tuple[Mapper, list[StepRecord], np.ndarray]) -> None:
    mapper, records, _ = second_round
    trust, calibration = mapper.optimisation.trust, mapper.map.calibration
    as_before("drive", of_drive(records))
    as_before(
        "map",
        {
            "nodes": mapper.map.poses[::3],
            "travel": [node.travel for node in mapper.map.nodes[::3]],
            "closures": [(edge.i, edge.j) for edge in mapper.map.closures],
            "calibration": calibration.vector(),
            "noise": [trust.way_noise or 0.0, trust.turn_noise or 0.0],
        },
    )
