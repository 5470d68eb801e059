"""What a run exports, judged by the tools that read it: gtsam and evo, and our own reader."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import gtsam
import numpy as np
import pytest
from played import Played, taught
from synthetic_run import make_run

from topomap.app.config import load_config
from topomap.app.export import g2o_text, nodes_text, trajectories, tum_rows, write_tum
from topomap.app.wiring import build_navigator
from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import between, compose, wrap_all
from topomap.core.records import UNKNOWN_HEADING
from topomap.datasets.g2o import read_graph
from topomap.evaluation.trajectory import position_errors
from topomap.mapping.graph import TopoMap
from topomap.mapping.map_problem import map_problem
from topomap.mapping.optimizer import ClosureEdge, relative_edges
from topomap.mapping.optimizer.objective import Objective, State
from topomap.mapping.optimizer.settings import OptimizerSettings
from topomap.navigation.runner import run

STEPS = 260
OPTIMUM_M, OPTIMUM_RAD = 5e-4, 1e-4
RUN = make_run()


@pytest.fixture(scope="module")
def topo() -> TopoMap:
    """One round and a half of room-corridor, with pose nodes that were inserted at closures."""
    navigator, readings = build_navigator(load_config().stack), taught(STEPS)
    run(Played(readings), navigator, ())
    navigator.mapper.finish(readings[-1].stamp_ns)
    made = navigator.mapper.map
    assert made.chain != sorted(made.chain)
    assert len(made.turns) > 20
    assert len(made.closures) > 5
    return made


@pytest.fixture(scope="module")
def file(topo: TopoMap, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("export") / "map.g2o"
    path.write_text(g2o_text(topo))
    return path


def test_our_own_reader_reads_it(topo: TopoMap, file: Path) -> None:
    """Every pose is there, and odometry runs from each to the next."""
    graph, edges = read_graph(file), relative_edges(map_problem(topo))
    assert graph.nodes == len(topo.nodes)
    steps = len(topo.nodes) - 1
    assert graph.odometry == pytest.approx(edges.relative[:steps])
    assert graph.odometry_covariance == pytest.approx(edges.covariance[:steps], rel=1e-6, abs=1e-15)
    assert len(graph.i) == len(edges.i) - steps


@pytest.mark.parametrize(("judge", "rel"), [("g2o", 1e-6), ("gtsam", 2e-2)])
def test_other_tools_measure_what_the_back_end_measures(topo: TopoMap, file: Path, judge: str, rel: float) -> None:
    """From the map to a bent one, each odometry edge with its turns and each closure grows by the same squared error.

    Two edges joined in one cost less by what they disagree, wherever the poses are. gtsam takes the logarithm of the
    relative pose as the error, which is another by half its turn times its length.
    """
    own, place = Objective(map_problem(topo), OptimizerSettings().turn_cutoff), np.argsort(topo.chain)
    weights = own.turn_weights(own.linearise(own.start()))
    bent = topo.poses + np.random.default_rng(0).normal(0.0, (0.01, 0.01, 0.005), (len(topo.poses), 3))
    measure = {"g2o": g2o_costs, "gtsam": gtsam_costs}[judge]
    before, after = (measure(file, poses[topo.chain]) for poses in (topo.poses, bent))
    ours = [costs(own, State(poses, topo.calibration), weights, place) for poses in (topo.poses, bent)]
    assert before.keys() == ours[0].keys()
    for pair, cost in ours[0].items():
        assert after[pair] - before[pair] == pytest.approx(ours[1][pair] - cost, rel=rel, abs=rel), pair


Costs = dict[tuple[int, int], float]
"""Squared errors by the places of the two nodes."""


def costs(own: Objective, state: State, weights: FloatArray, place: IntArray) -> Costs:
    at, found = own.linearise(state), Costs()
    for blocks in (at.odometry, at.turns.weighted(weights), at.closures):
        for i, j, chi2 in zip(place[blocks.i].tolist(), place[blocks.j].tolist(), blocks.chi2().tolist(), strict=True):
            found[i, j] = found.get((i, j), 0.0) + chi2
    return found


def gtsam_costs(file: Path, poses: FloatArray) -> Costs:
    graph, values, found = gtsam.readG2o(str(file), False)[0], as_values(poses), Costs()
    for factor in (graph.at(k) for k in range(graph.size())):
        i, j = factor.keys()
        found[i, j] = found.get((i, j), 0.0) + 2 * factor.error(values)
    return found


def g2o_costs(file: Path, poses: FloatArray) -> Costs:
    """As g2o's EdgeSE2 has it: the error is the measurement's inverse times the relative pose, in three numbers."""
    found = Costs()
    for words in (line.split() for line in file.read_text().splitlines() if line.startswith("EDGE_SE2")):
        i, j = int(words[1]), int(words[2])
        measured, upper = np.array(words[3:6], float), np.array(words[6:], float)
        error = between(measured, between(poses[i], poses[j]))
        information = np.zeros((3, 3))
        information[np.triu_indices(3)] = upper
        information = information + np.triu(information, 1).T
        found[i, j] = found.get((i, j), 0.0) + float(error @ information @ error)
    return found


def test_the_optimum_of_the_file_is_the_map(topo: TopoMap, file: Path) -> None:
    graph, start = gtsam.readG2o(str(file), False)
    graph.add(gtsam.PriorFactorPose2(0, start.atPose2(0), gtsam.noiseModel.Isotropic.Sigma(3, 1e-6)))
    rng = np.random.default_rng(1)
    wrong = as_values(topo.poses[topo.chain] + rng.normal(0.0, 0.02, (len(topo.chain), 3)))
    found = gtsam.LevenbergMarquardtOptimizer(graph, wrong).optimize()
    poses = np.array([(p.x(), p.y(), p.theta()) for p in (found.atPose2(k) for k in range(len(topo.chain)))])
    apart = poses - topo.poses[topo.chain]
    assert np.hypot(apart[:, 0], apart[:, 1]).max() < OPTIMUM_M
    assert np.abs(wrap_all(apart[:, 2])).max() < OPTIMUM_RAD


def test_a_turn_over_an_inserted_node_says_nothing_of_position(topo: TopoMap) -> None:
    edges, steps = relative_edges(map_problem(topo)), len(topo.chain) - 1
    pairs = {(t.i, t.j): t for t in topo.turns}
    beside = set(zip(edges.i[:steps].tolist(), edges.j[:steps].tolist(), strict=True))
    over = [pair for pair in pairs if pair not in beside]
    assert over
    for k, pair in enumerate(over, start=steps):
        assert (edges.i[k], edges.j[k]) == pair
        assert edges.covariance[k, 0, 0] >= 1e6
        assert edges.relative[k, 2] == pytest.approx(pairs[pair].turn)


def test_a_closure_without_a_heading_says_nothing_of_it(topo: TopoMap) -> None:
    problem = map_problem(topo)
    blind = ClosureEdge(
        topo.chain[0], topo.chain[-1], topo.closures[0].relative, np.diag([0.1, 0.3, 2 * UNKNOWN_HEADING])
    )
    problem = replace(problem, closures=type(problem.closures).of([blind]))
    covariance = relative_edges(problem).covariance[-1]
    assert covariance == pytest.approx(np.diag([0.2, 0.2, 1e6]))


def test_each_vertex_is_named_as_a_node(topo: TopoMap) -> None:
    rows = [row.split(",") for row in nodes_text(topo).splitlines()[1:]]
    assert [int(node) for _, node, _, _ in rows] == topo.chain
    stamps = [int(stamp) for _, _, stamp, _ in rows]
    assert stamps == sorted(stamps)
    assert sum(int(kept) for *_, kept in rows) == sum(node.snapshot is not None for node in topo.nodes)


def as_values(poses: FloatArray) -> gtsam.Values:
    values = gtsam.Values()
    for k, row in enumerate(poses):
        values.insert(k, gtsam.Pose2(*row))
    return values


@pytest.mark.parametrize("name", ["map", "online", "dead_reckoning"])
def test_evo_finds_the_report_s_errors_without_aligning_anything(name: str, tmp_path: Path) -> None:
    write_tum(RUN, tmp_path)
    poses = {"map": RUN.final, "online": RUN.online, "dead_reckoning": RUN.dead_reckoning}[name]
    wanted = position_errors(RUN, poses)
    assert wanted is not None
    assert evo_rmse(tmp_path, name) == pytest.approx(np.sqrt(np.mean(wanted**2)), abs=1e-6)


def test_a_truth_without_headings_is_laid_over_the_map_by_its_best_fit(tmp_path: Path) -> None:
    assert RUN.truth is not None
    moved = compose(np.array([30.0, -20.0, 2.0]), RUN.truth)
    blind = replace(RUN, truth=np.column_stack([moved[:, :2], np.full(len(moved), np.nan)]))
    write_tum(blind, tmp_path)
    assert evo_rmse(tmp_path, "map") < 0.04
    header = [line for line in (tmp_path / "truth.tum").read_text().splitlines() if line.startswith("#")]
    assert header[1].startswith("# map frame: it starts at the first pose; the truth was aligned by")
    assert "isn't known" in header[1]


def test_every_file_says_its_frame_and_starts_at_the_origin(tmp_path: Path) -> None:
    for path in write_tum(RUN, tmp_path):
        lines = path.read_text().splitlines()
        assert lines[1].startswith("# map frame: it starts at the first pose")
        assert [float(word) for word in lines[2].split()[1:]] == pytest.approx([0, 0, 0, 0, 0, 0, 1])
    assert list(trajectories(replace(RUN, truth=None))) == ["map", "online", "dead_reckoning"]


def evo_rmse(folder: Path, name: str) -> float:
    """The absolute position error, nothing aligned."""
    pytest.importorskip("evo")
    from evo.core.metrics import APE, PoseRelation, StatisticsType
    from evo.core.sync import associate_trajectories
    from evo.tools.file_interface import read_tum_trajectory_file

    truth, other = (read_tum_trajectory_file(str(folder / f"{one}.tum")) for one in ("truth", name))
    metric = APE(PoseRelation.translation_part)
    metric.process_data(associate_trajectories(truth, other))
    return float(metric.get_statistic(StatisticsType.rmse))


def test_a_heading_is_half_of_its_quaternions_angle() -> None:
    """A quarter turn to the left is sin and cos of an eighth (x, y, z, w with z upwards); unknown headings are 0."""
    poses = np.array([[1.5, -2.0, np.pi / 2], [0.0, 0.0, -np.pi], [1.0, 1.0, np.nan], [np.nan, 0.0, 0.0]])
    rows = [line.split() for line in tum_rows(np.array([1_000_000_001, 2, 3, 4]), poses).splitlines()]
    assert rows == [
        ["1.000000001", "1.500000000", "-2.000000000", "0", "0", "0", "0.707106781", "0.707106781"],
        ["0.000000002", "0.000000000", "0.000000000", "0", "0", "0", "-1.000000000", "0.000000000"],
        ["0.000000003", "1.000000000", "1.000000000", "0", "0", "0", "0.000000000", "1.000000000"],
    ]
