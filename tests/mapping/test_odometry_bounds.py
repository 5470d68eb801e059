# ruff: noqa: E501 rows of tables
"""What is made of odometry, turns and the map's parts at their bounds: the same as before."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from graphs import ring_graph
from kept import as_before
from maps import RIG, STEP_NS, increments, snapshot, square

from topomap.core.errors import DataError, TopomapError
from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, Candidate, Motion
from topomap.core.rig import Rig
from topomap.mapping import optimisation as optimisation_file
from topomap.mapping import sequential as sequential_file
from topomap.mapping.closures.along_drive import map_along
from topomap.mapping.closures.along_settings import AlongSettings
from topomap.mapping.closures.difference_rule import DifferenceRuleSettings
from topomap.mapping.closures.ledger import Ledger
from topomap.mapping.difference_mapping import map_by_difference
from topomap.mapping.graph import Node, TopoMap
from topomap.mapping.graph_engine import warm_up
from topomap.mapping.look_survey import LookSurvey, _likeness
from topomap.mapping.measured_turns import Columns, MeasuredTurn
from topomap.mapping.odometry.calibration import MIN_MOVES, DistanceScale, calibration_state
from topomap.mapping.odometry.gap import GAP, Restated, bridged, restated
from topomap.mapping.odometry.increments import Calibration, Increments
from topomap.mapping.odometry.leaps import FEWEST
from topomap.mapping.odometry.noise import MUCH, OdometerNoise, declared, rolled
from topomap.mapping.odometry.scan_watch import SEEN_OFF, STEPS, STOOD, TURN_OFF, WAY_OFF, ScanWatch, Shown
from topomap.mapping.odometry.usual_change import LATELY, SELDOM, UsualChange
from topomap.mapping.odometry.watch import PATIENCE, OdometryWatch
from topomap.mapping.optimisation import Optimisation
from topomap.mapping.optimizer.examples import example
from topomap.mapping.optimizer.peers import PEERS, inliers, optimum
from topomap.mapping.optimizer.problem import PRIOR_SIGMAS, ClosureEdge, TurnEdge
from topomap.mapping.place_claims import PlaceClaims
from topomap.mapping.places.place_index import BLOCK, PlaceIndex
from topomap.mapping.places.recognition import Recognition, RecognitionSettings
from topomap.mapping.recorded_drive import RecordedDrive
from topomap.mapping.sequential import SequentialConstraints, _beside, _factor, _near
from topomap.mapping.sessions.condense import condensed
from topomap.mapping.sessions.merge import _claims, _ends, _read_as, _reversed
from topomap.mapping.sessions.places import find, forget_place, name_place, span
from topomap.mapping.sessions.prune import _drives, _inside, _reaches, _stretches, _tied
from topomap.mapping.sessions.rebuild import only
from topomap.mapping.solve_due import OptimisationSettings
from topomap.mapping.track import Track
from topomap.mapping.turn_evidence import TurnEvidence, _alike, _alone, _beyond, _told
from topomap.mapping.turn_line import FEWEST as TURNS
from topomap.mapping.turn_line import Line, _nearest, line
from topomap.vision.image.compare import PLACE, signature
from topomap.vision.matching.scan_match import ScanMatch
from topomap.vision.registry import aligner

SMALL = Rig(72, 10, 4.5, 72 / math.tau, 0.6)


def around(bound: float) -> tuple[float, float, float]:
    """Just below, at, and just above."""
    return math.nextafter(bound, -math.inf), bound, math.nextafter(bound, math.inf)


def view(seed: int) -> Panorama:
    """A view with its own pattern."""
    rng = np.random.default_rng(seed)
    image = np.kron(rng.uniform(40, 210, (5, 18, 1)), np.ones((2, 4, 3))).astype(np.uint8)
    return Panorama(image, None, SMALL)


def some_increments(count: int = 9, seed: int = 0) -> Increments:
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=(count, 3, 3)) * 0.01 + 0.01 * np.eye(3)
    deltas = rng.normal(size=(count, 3)) * [0.2, 0.02, 0.3]
    return Increments((np.arange(count) + 1) * STEP_NS, deltas, roots @ roots.transpose(0, 2, 1))


def test_noise_gaps_and_stand_ins_are_as_before() -> None:
    ways, told = some_increments(), list[np.ndarray]()
    for noise in (OdometerNoise(), OdometerNoise(2.0, None), OdometerNoise(None, 0.5), OdometerNoise(0.1, 9.0)):
        told.append(noise.judged(ways).covariances.ravel())
    told.append(declared(ways).ravel())
    told.append(np.array([rolled(ways)]))
    exact = Increments(ways.stamps_ns, ways.deltas, np.zeros_like(ways.covariances))
    told.append(declared(exact).ravel())
    calibration = Calibration(1.05, 0.03, 0.9)
    read = Motion(0.2, 0.01, 0.1, ways.covariances[0], 0.25)
    for ways_, turns in itertools.product((None, 0.05), (None, 0.02)):
        found = restated(read, Restated(0.3, -0.02, 0.2, ways_, turns), calibration)
        told.append(np.array([found.forward, found.left, found.turn, *found.covariance.ravel()]))
    led = bridged(ways, calibration, Pose2(1.0, -0.4, 2.0))
    told += [led.deltas.ravel(), np.sqrt(led.covariances[-1].diagonal())]
    one = condensed(ways, calibration)
    told += [one.deltas.ravel(), one.covariances.ravel() * 1e3]
    other = _read_as(ways, calibration, Calibration(0.97, -0.01, 1.1), 7)
    told += [other.deltas.ravel(), other.covariances.ravel() * 1e3, other.stamps_ns - ways.stamps_ns]
    as_before("odometry stand-ins", {"told": np.concatenate(told)})
    assert GAP[0, 0] == 2500.0
    near = OdometerNoise(1.0, 2.0)
    for factor, same in (
        (math.exp(MUCH * 0.999), True),
        (math.exp(MUCH * 1.001), False),
        (math.exp(-MUCH * 0.999), True),
    ):
        assert near.near(OdometerNoise(factor, 2.0)) is same
        assert near.near(OdometerNoise(1.0, 2.0 * factor)) is same
    assert not near.near(OdometerNoise(None, 2.0))
    assert OdometerNoise(None, 1.0).near(OdometerNoise(None, 1.0))


def test_the_distance_scale_is_told_from_so_many_moves_on() -> None:
    told = list[float]()
    for count, wrong, seen in itertools.product((MIN_MOVES - 1, MIN_MOVES, 20), (0, 2), (False, True)):
        scale = DistanceScale()
        for k in range(count):
            measured = 1.0 + 0.02 * (k % 5)
            scale.add(
                0.93 * measured * (1.2 if k < wrong else 1.0) + 0.004 * (k % 3),
                measured,
                0.01,
                0.015 if seen else 0.0,
                0.02,
            )
        found, odometer = scale.estimate(), scale.odometer()
        told += [found.value, found.sigma, found.observed, *((-1.0, -1.0) if odometer is None else odometer)]
    vague = DistanceScale()
    for k in range(20):
        vague.add(1.0 + 0.2 * (-1) ** k, 1.0, 0.5, 0.0, 0.5)
    told += [vague.estimate().sigma, vague.estimate().observed]
    for share in around(0.5):
        sigmas = np.array([share * s for s in PRIOR_SIGMAS])
        state = calibration_state(Calibration(1.1, 0.01, 0.9), np.diag(sigmas**2), PRIOR_SIGMAS)
        told += [
            v for one in (state.rotation_scale, state.curvature, state.distance_scale) for v in (one.value, one.sigma)
        ]
    as_before("odometry scale", {"told": told})


def columns(count: int, seed: int = 0, **changed: object) -> Columns:
    rng = np.random.default_rng(seed)
    read = rng.normal(0.0, 0.3, count)
    rows = [MeasuredTurn(k, k + 1, float(r), 0.3 + 0.01 * k, 1e-4, 1.0, aligned=float(r) * 0.97 + 0.001, matched=float(r))
            for k, r in enumerate(read)]  # fmt: skip
    return Columns.of_rows(np.array([one.row() for one in rows], float))._replace(**changed)


def test_lines_through_turns_are_as_before() -> None:
    told = list[float]()
    for count, gain, scatter in itertools.product((TURNS - 1, TURNS, 40), (0.0, 1.0), (0.0, 0.01)):
        c = columns(count)
        turns = 0.9 * c.read + 0.01 * c.forward + scatter * np.sin(np.arange(count) * 2.0)
        turns[::7] = math.nan
        found = line(turns, c, gain)
        told += [found.gain, min(found.gain_sigma, 9.0), found.bend, min(found.bend_sigma, 9.0), found.scatter * 10]
        told += [
            found.number,
            found.known,
            found.possible,
            found.variance * 1e3,
            *np.nan_to_num(found.off, nan=9.0)[:9],
        ]
    told += [_nearest(*three) for three in itertools.product((0.0, 1.0, 2.0), (0.5, 1.5), (0.8, 3.0))]
    for gain, sigma in itertools.product((0.84, 0.85, 0.86, 1.149, 1.151, 1.3), (0.0, 0.1)):
        told.append(Line(gain, sigma, 0.0, 0.0, 0.01, 20, np.zeros(1)).possible)
        told.append(_alone(Line(gain, sigma, 0.0, 0.0, 0.01 * gain, 11 + int(10 * sigma), np.zeros(1)))[0] * 100)
    told += [_beyond(0.05, sigma) for sigma in (0.0, 0.02, 0.025, 0.03)]
    told += [_alike(np.array(sizes)) for sizes in ([], [0.0], [1.0, 1.0, 1.0], [math.nan, 2.0, 0.1])]
    for size, variance in itertools.product((0.001, 0.01, 0.05), (0.0, 1e-5, 1e-3)):
        c = columns(30)
        straight = Line(1.0, 0.0, 0.0, 0.0, size, 30, size * np.cos(np.arange(30)))
        said = _told(c, straight, variance)
        told += [-1.0, -1.0] if said is None else list(said)
        assert _told(c._replace(variance=np.zeros(30)), straight, variance) is None
    as_before("odometry lines", {"told": told})


def test_turns_are_weighed_as_before_whatever_measured_them() -> None:
    told = list[float]()
    for seen, gain, error, scanned in itertools.product(
        ("both", "aligned", "matched", "none"), (1.0, 0.5), (0.002, 0.05), (0, 3)
    ):
        rng, evidence = np.random.default_rng(5), TurnEvidence()
        for k in range(30):
            read = float(rng.normal(0.0, 0.2)) + (1.5 if k % 10 == 0 else 0.0)
            evidence.add(MeasuredTurn(
                k, k + 1, read, 0.3, 1e-4, 0.3 + 0.15 * abs(read),
                scanned=read + 0.003 if scanned and k % scanned == 0 else math.nan,
                scan_sigma=0.002 if scanned and k % scanned == 0 else math.nan,
                aligned=gain * read + float(rng.normal(0, error)) if seen in ("both", "aligned") else math.nan,
                matched=gain * read + float(rng.normal(0, error)) if seen in ("both", "matched") else math.nan,
            ))  # fmt: skip
        found = evidence.weigh()
        told += [len(found.edges), *((-1.0, -1.0) if found.odometer is None else found.odometer)]
        told += [v for edge in found.edges[::4] for v in (edge.turn, edge.sigma * 10)]
    as_before("odometry turns", {"told": told})


def test_neighbours_are_compared_at_their_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    told = [9.0 if (f := _factor(one)) is None else f for one in (
        None, (0.2, 0.9), (0.2, 0.5), (0.2, 0.49), (0.2, 1.0), (2.0, 3.0), (0.5, 3.0), (0.0, 1e-4), (0.0, 0.3))]  # fmt: skip
    far = sequential_file.FAR
    assert [_near(r, np.array([0.0, 0.0, 0.1])) for r in (0.1 + far * 0.999, 0.1 + far * 1.001, 0.1 - far * 1.001)] == [
        True, False, False]  # fmt: skip
    told += [_beside(rotation, read) for rotation, read in ((0.1, 0.2), (-3.0, 3.2), (3.0, -9.0))]
    for x, spread, seen in itertools.product((0.14, 0.15, 0.6), (1e-4, 3.99e-4, 4.01e-4), (False, True)):
        topo = square()
        constraints, kept = SequentialConstraints(None, topo), list[float]()
        monkeypatch.setattr(constraints._scale, "add", lambda *a, k=kept: k.extend(map(float, a)))
        match = ScanMatch(np.array([x, 0.0, 0.1]), np.diag([spread, 1.0, 1e-4]), 0.5)
        constraints._measure(increments(0, 5), match, seen)
        told += [len(kept), *kept]
    for values in itertools.product((math.nan, 0.2), (math.nan, 0.25), (math.nan, 0.3)):
        constraints = SequentialConstraints(None, square())
        turn = MeasuredTurn(0, 1, 0.2, 0.5, 1e-4, 0.5)
        constraints._take(turn, values[0], 0.01 if values[0] == values[0] else math.nan, values[1], values[2])
        told += [v for edge in constraints.turns for v in (edge.turn, edge.sigma)] + [len(constraints.turns)]
    as_before("odometry neighbours", {"told": told})


def test_what_views_show_may_differ_by_more_than_what_ranges_show() -> None:
    for off in (WAY_OFF, SEEN_OFF):
        shown = [Shown(Pose2(off + e, 0.0, 0.0), np.eye(2), 0.5, off=off) for e in (-1e-9, 1e-9)]
        assert [ScanWatch()._off(one) for one in shown] == [False, True]


def test_scans_are_laid_over_one_another_at_their_bounds() -> None:
    told, said = list[float](), list[str]()
    square_, line_ = np.eye(2), np.array([[0.0, 1.0]])
    for x, turn, directions, stood, untrue in itertools.product(
        (0.0, WAY_OFF - 1e-9, WAY_OFF + 1e-9, 1.0), (0.0, TURN_OFF + 1e-9), (square_, line_), (0, 1, STOOD - 1, STOOD),
        (False, True)
    ):  # fmt: skip
        watch = ScanWatch()
        watch._stood, watch.untrue, watch._believed = stood, untrue, Pose2(0.05, 0.0, 0.0)
        shown = Shown(Pose2(x, x / 9, turn), directions, 0.5)
        told.append(watch._off(shown))
        found = watch._judge(shown)
        told += [9.0] * 3 if found is None else [found.x, found.y, found.heading]
        said.append(watch.said)
        told += [watch.untrue, watch._slack.x]
    bare = view(1)
    scanned = replace(bare, ranges=np.full(72, 2.0, np.float32))
    for views in ((bare,) * 8, (scanned,) * 8, (scanned, bare) * 4):
        watch = ScanWatch()
        watch.begin(views[0])
        asked = list[int]()
        watch._found = lambda *_, a=asked: a.append(1)  # type: ignore[method-assign]
        for k, one in enumerate(views):
            watch.step(one, Pose2(0.1), Pose2(0.1), 0.1, k % 2 == 0, k == 3)
            told += [watch._steps, watch._stood, watch._moved, watch._read.x, len(asked)]
    assert STEPS == 5
    as_before("odometry scans", {"told": told, "said": said})


def test_changes_of_the_view_are_judged_at_their_bounds() -> None:
    told = list[float]()
    for known, usual, lately, way in itertools.product((FEWEST - 1, FEWEST), (0.1, 0.3), (0.1, 0.6), (0.1, 0.4)):
        watch = OdometryWatch()
        for _ in range(known):
            watch._usual.learn(usual, usual, 0.1)
        watch._usual._lately = lately
        told += [watch._usual.exceeded(change, way) for change in (0.2, 0.26, 0.35, 0.36, 0.76, 0.91, 1.01, 3.1)]
        for driven, change in itertools.product((0.0, 0.015, 0.02, 0.021, 0.1), (0.0, 0.01, 0.05, 0.06, 0.15, 0.2)):
            watch._dead, watch._spinning = 2, 3
            told += [*watch._contradicted(change, driven + 0.001, driven), watch._dead, watch._spinning]
        told += [watch._usual.still, watch._usual.change]
    for dead, spinning, sees, untrue in itertools.product(
        (0, PATIENCE - 1, PATIENCE, PATIENCE + STEPS), (0, 99), (False, True), (False, True)
    ):
        watch = OdometryWatch()
        watch._dead, watch._spinning, watch._scans.sees, watch._scans.untrue = dead, spinning, sees, untrue
        told.append(watch.doubted)
    assert LATELY == 10
    as_before("odometry changes", {"told": told})


def test_the_third_greatest_change_of_a_drive_is_no_break_and_two_are_no_rule() -> None:
    usual = UsualChange()
    for _ in range(FEWEST):
        usual.learn(0.1, 0.1, 0.1)
    for so_far, change in enumerate((0.9, 0.6, 0.4)):
        assert so_far < SELDOM
        assert usual.exceeded(0.36, 0.1)
        usual.happened(change, 0.2)
        usual.happened(1.3, 0.26)  # readings were left out
    assert [usual.exceeded(change, 0.1) for change in (0.59, 0.61)] == [False, True]
    assert usual.unusual(0.59, 0.1)
    usual.happened(0.3, 0.1)
    assert usual.exceeded(0.61, 0.1)
    usual.happened(0.95, 0.1)
    assert [usual.exceeded(change, 0.1) for change in (0.89, 0.91)] == [False, True]
    for _ in range(SELDOM):
        usual.happened(1.0, 0.1)
    assert not usual.exceeded(1.8, 0.1), "views that have nothing in common differ by 1.4"


def test_the_track_and_the_map_are_cut_and_moved_as_before() -> None:
    track, told = Track(square()), list[float]()
    topo = track.map
    last = topo.nodes[topo.chain[-1]].stamp_ns
    for k in range(6):
        track.advance(last + (k + 1) * STEP_NS, Motion(0.1, 0.01, 0.2, 1e-4 * np.eye(3), 0.25), broken=k == 4)
    for stamp in (last - 2 * STEP_NS, last, last + 1, last + STEP_NS, last + 3 * STEP_NS + 5, last + 9 * STEP_NS):
        told += track.pose_at(stamp).array().tolist()
    told += [track.node_at(last - 2 * STEP_NS), track.node_at(last), track.node_at(last + 3 * STEP_NS), track.travel]
    told += [topo.nodes[-1].travel, len(track._motions), *track.pose.array(), *topo.poses.ravel()]
    told += [v for a, b, way in topo.odometry_edges() for v in (a, b, len(way))]
    edge = ClosureEdge(1, 2, Pose2(), np.eye(3))
    topo.close(edge)
    told.append(topo.graph.edges[1, 2]["kind"] == "odometry")
    topo.insert(topo.nodes[1].stamp_ns + STEP_NS)
    told.append(topo.graph.edges[1, 2]["kind"] == "closure")
    topo.remove(edge)
    told.append(topo.graph.has_edge(1, 2))
    far = ClosureEdge(0, 5, Pose2(), np.eye(3))
    for _ in range(2):
        topo.close(far)
    topo.remove(far)
    told.append(topo.graph.has_edge(0, 5))
    topo.remove(far)
    told.append(topo.graph.has_edge(0, 5))
    topo.place(9, Pose2(5.0, 5.0, 1.0))
    topo.calibration = Calibration(1.02, 0.01, 0.97)
    told += [*topo.poses.ravel(), *topo.dead_reckoning().ravel(), *topo.trajectory(4)[1][::5].ravel()]
    told += [topo.length(0, 9), len(topo.way(3, 6)), topo.node_named(5) or -1, topo.node_named(99) or -1]
    topo.end_before(last + 99)
    told += [(topo.nodes[0].stamp_ns) / 1e9, topo._increments[3, 4].stamps_ns[0] / 1e9]
    topo.end_before(topo.nodes[topo.chain[-1]].stamp_ns + 1)
    told.append(topo.nodes[0].stamp_ns / 1e9)
    before = len(topo.turns)
    topo.weigh([TurnEdge(0, 1, 0.1, 0.01)])
    assert (before, len(topo.turns)) == (0, 1)
    with pytest.raises(ValueError, match="pose node"):
        topo.restate(topo.insert(topo.nodes[3].stamp_ns + STEP_NS), 0.1, 0.1, ())
    as_before("odometry track", {"told": told})


@pytest.mark.parametrize(("motion", "stamp", "said"), [
    (Motion(0.1, 0.0, 0.0, np.eye(3), 0.25), 0, "isn't later"), (Motion(0.1, 0.0, 0.0, np.eye(2), 0.25), 1 << 40, "not"),
    (Motion(math.nan, 0.0, 0.0, np.eye(3), 0.25), 1 << 40, "NaN"), (Motion(0.1, 0.0, math.inf, np.eye(3), 1.0), 1 << 40, "NaN"),
])  # fmt: skip
def test_what_would_fail_later_is_refused(motion: Motion, stamp: int, said: str) -> None:
    with pytest.raises(DataError, match=said):
        Track(square()).check(stamp, motion)
    Track(TopoMap()).check(0, Motion(0.1, 0.0, 0.0, np.eye(3), 0.25))


def drives() -> TopoMap:
    """Two drives on one map, the second one tied to the first at both its ends."""
    topo = square()
    last = topo.nodes[-1].stamp_ns
    for k in range(6):
        way = increments(80 + 5 * k, 5)
        way = Increments(way.stamps_ns, way.deltas, way.covariances * (1e6 if k == 0 else 1.0))
        shot = None if k == 3 else snapshot(k)
        topo.add(Node(last + (5 * k + 5) * STEP_NS, 20.0 + 0.5 * k, shot), way, jump=k == 0)
    for i, j in ((1, 18), (3, 20), (5, 22)):
        topo.close(ClosureEdge(i, j, topo.pose(i).to(topo.pose(j)), 0.01 * np.eye(3)))
    topo.places = {"desk": 4, "door": 21}
    topo.experience.passed(3, 4, 2.0)
    topo.experience.failed(18, 19, 5)
    topo.turns.append(TurnEdge(3, 4, 0.1, 0.01))
    return topo


def test_stretches_that_add_nothing_are_found_as_before() -> None:
    topo, rows = drives(), list[str]()
    rows.append(str(_drives(topo)))
    for covered in (set(), {18, 19, 21}, {17, 18, 19, 20, 21, 22}, set(range(17)), {2, 3, 22}):
        for drive in _drives(topo):
            for stretch in _stretches(topo, drive, covered):
                rows.append(f"{stretch} {sorted(_inside(topo, drive, stretch, set()))} "
                            f"{sorted(_inside(topo, drive, stretch, {1, 3}))}")  # fmt: skip
    ties = np.array([(c.i, c.j) for c in topo.closures], np.int64)
    travel = np.array([node.travel for node in topo.nodes])
    for node in (17, 20, 3):
        rows.append(f"{_tied(topo, node, ties, travel).tolist()} {_tied(topo, node, ties[:0], travel).tolist()}")
        rows.append(str([_reaches(topo, np.array([0, 9]), older) for older in range(0, 17, 4)]))
    for keep, parting in ((set(range(23)) - {6, 7}, set()), (set(range(23)) - {6, 7}, {6}), (set(range(23)) - {16, 17}, set()),
                          ({0, 5, 22}, {9}), (set(range(23)) - {18}, {18})):  # fmt: skip
        made = only(topo, keep, parting)
        rows.append(
            f"{made.chain} {sorted(made.jumps)} {made.names} {[(c.i, c.j) for c in made.closures]} {made.places}"
        )
        rows.append(
            f"{[(e.a, e.b) for e in made.experience]} {len(made.turns)} "
            f"{[(a, b, len(way), round(float(way.covariances[:, 2, 2].max()), 6)) for a, b, way in made.odometry_edges()]}"
        )
    as_before("odometry pruned", {"rows": rows})


def test_places_are_found_and_named_as_before() -> None:
    topo, said = drives(), list[str]()
    for target in ("desk", "3", "99", "nowhere", "19", "20", "1234567890", "²"):
        try:
            said.append(str(find(topo, target)))
        except TopomapError as error:
            said.append(str(error))
    for word in (
        "sofa=5",
        "=5",
        "sofa=",
        "sofa",
        "12=5",
        "a,b=5",
        "unknown=5",
        "x" * 64 + "=5",
        "x" * 65 + "=5",
        "t\n=5",
        "a=b=c",
    ):
        try:
            said.append(name_place(topo, word))
        except TopomapError as error:
            said.append(str(error))
    forget_place(topo, "sofa")
    with pytest.raises(TopomapError, match="no such place"):
        forget_place(topo, "sofa")
    for k in range(14):
        topo.places[f"p{k:02d}"] = 3
    with pytest.raises(TopomapError) as told:
        find(topo, "gone")
    said += [str(told.value), span(topo)]
    topo.names[-1] = 99
    said.append(span(topo))
    as_before("odometry places", {"said": said})


def test_closures_are_turned_to_begin_at_the_earlier_place() -> None:
    covariance = np.array([[0.04, 0.01, 0.002], [0.01, 0.09, -0.003], [0.002, -0.003, 0.02]])
    edge = ClosureEdge(7, 2, Pose2(0.4, -0.3, 0.8), covariance, 0.5)
    back = _reversed(edge)
    again = _reversed(back)
    assert again.covariance == pytest.approx(covariance)
    assert again.relative.array() == pytest.approx(edge.relative.array())
    place = np.arange(9)
    assert (_ends(edge, place), back.i, back.j, back.weight) == ((2, 7), 2, 7, 0.5)
    claims = _claims([edge, back], place)
    assert claims.relative[0] == pytest.approx(claims.relative[1])
    as_before("odometry reversed", {"relative": back.relative.array(), "covariance": back.covariance})


class Turnless:
    def align(self, *_: object) -> Alignment:
        return Alignment(0.0, 1.0)


def test_a_large_map_is_solved_bit_by_bit_as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(optimisation_file, "LARGE", 12)
    monkeypatch.setattr(optimisation_file, "STRETCH", 9)
    topo, told = TopoMap(), list[float]()
    track = Track(topo)
    optimisation, ledger = Optimisation(OptimisationSettings(every=4, surprise=1.0), Turnless(), topo), Ledger()
    rng = np.random.default_rng(2)
    for k in range(44):
        turn = 0.3 + float(rng.normal(0.0, 0.02))
        track.advance(k, Motion(0.5, 0.0, turn, np.diag([1e-3, 1e-4, 1e-3]), 0.25))
        track.node_at(k)
        if k >= 22 and k % 3 == 0:
            edge = ClosureEdge(k - 21, k, Pose2(0.02, -0.01, 0.01 if k != 33 else 1.5), 1e-2 * np.eye(3))
            one = Candidate(k, k - 21, k - 21, edge.relative, edge.covariance, query=k)
            sigmas = {24: 0.5, 30: 1.5, 33: 9.0, 39: 2.6}.get(k, 0.1)
            topo.close(edge)
            optimisation.believe(edge, replace(one, evidence=replace(one.evidence, sigmas=sigmas)))
        solved, changed = optimisation.update(k, ledger)
        told += [
            k,
            solved,
            optimisation.solves,
            optimisation._running is not None,
            *(d.candidate.query or 0 for d in changed),
        ]
        if solved:
            track.restart()
        if k == 42:
            told += [len(optimisation.disbelieve(k, ledger, {30, 31}, "elsewhere")), len(optimisation._closures)]
    told += [*topo.poses[::4].ravel(), *topo.calibration.vector() * 100, len(topo.closures)]
    optimisation.finish(99, ledger)
    told += [*topo.poses[::4].ravel(), len(topo.closures)]
    as_before("odometry large", {"told": told, "kept": [optimisation.contest.kept if optimisation.contest else ""]})


def test_gtsams_own_optimisers_find_what_they_found() -> None:
    graph, found = ring_graph(2, 6).graph, {}
    for name, peer in PEERS.items():
        poses, stands = inliers(graph, peer.solve(peer.build(graph), graph.nodes))
        found[name] = [*poses[::12].ravel(), *stands.astype(float)]
    found["optimum"] = [*optimum(graph)[::12].ravel()]
    as_before("odometry peers", found)
    assert example("w10000").exists()
    with pytest.raises(DataError, match="no example graph 'nothing'"):
        example("nothing")
    warm_up()


def test_looks_along_a_drive_are_surveyed_as_before() -> None:
    survey, told = LookSurvey(aligner("min-warping")), list[float]()
    for k in range(75):
        place = k % 30
        found = survey.update(k, 0.4, view(100 + place // 2), 5 * math.cos(place / 5), 5 * math.sin(place / 5))
        told += [k, *found] if found is not None else []
    assert len(told) >= 8
    none = SimpleNamespace(ratio=0.0)
    assert _likeness(1, 2, none) is None
    as_before("odometry survey", {"told": told, "kept": [len(survey._views), survey._kept_at]})


def test_a_drive_through_the_thesis_rule_is_as_before() -> None:
    readings = [SimpleNamespace(image=view(k % 20 // 2).image, rig=RIG, ranges=None,
                                motion=SimpleNamespace(forward=0.5, left=0.0, turn=math.tau / 20, covariance=np.eye(3), dt=0.25))
                for k in range(50)]  # fmt: skip
    found = map_by_difference(readings, DifferenceRuleSettings(threshold=0.5, travel=3.0))
    assert found.closures
    as_before("odometry rule", {"poses": found.poses[::5], "online": found.online[::5], "kept": found.kept,
                                "closed": [(c.now, c.old) for c in found.closures]})  # fmt: skip


def test_many_views_are_searched_block_by_block_as_before() -> None:
    index, told = PlaceIndex(), list[float]()
    for k in range(4 * BLOCK + 40):
        index.add(signature(view(k), PLACE))
    for first in (None, 3, 4 * BLOCK, 4 * BLOCK + 1, 9999):
        places, found = index.search(signature(view(17), PLACE), 5, first)
        told += [*places[:5], *found.difference[:5], *found.rotation[:5]]
    told += [len(index), *index.search(signature(view(5), PLACE), 3, 0)[0]]
    as_before(
        "odometry searched", {"told": told}, floor=1e-3
    )  # the difference of a view from itself is a root of noise
    recognition = Recognition(RecognitionSettings(min_travel=1.0))
    for k in range(430):
        recognition.add(k, 0.1 * k, view(k))
    now = Panorama(np.uint8(0.8 * view(40).image + 0.2 * view(130).image), None, SMALL)
    near = recognition._search(signature(now), 43.0, np.arange(405))
    few = recognition._search(signature(now), 43.0, np.arange(30))
    moment = SimpleNamespace(panorama=now, travel=43.0, places=near[0], likely=near[1], difference={})
    as_before("odometry recognised", {
        "near": [v for m in near[0][:9] for v in (m.node, m.difference)], "few": [m.node for m in few[0]],
        "likely": [m.node for m in near[1]], "older": [len(recognition._older(moment))], "count": [len(near[0])],
        "rivals": [m.node for m in recognition._rivals(moment)], "far": [recognition.far, recognition.limit],
    })  # fmt: skip


def recorded(curvature: float = 0.0) -> tuple[RecordedDrive, PlaceClaims]:
    """Three laps of 40 m whose odometer bends, with places seen again a lap later, and some false ones."""
    rng = np.random.default_rng(8)
    count = 3 * 80
    turn = np.where(np.arange(count) % 20 >= 16, math.pi / 8, 0.0) + curvature * 0.5 + rng.normal(0, 0.003, count)
    deltas = np.column_stack([np.full(count, 0.5), np.zeros(count), turn])
    stamps = np.arange(count + 1) * STEP_NS
    ways = Increments(stamps[1:], deltas, np.tile(np.diag([1e-3, 1e-4, 1e-4]), (count, 1, 1)))
    marks = np.arange(0, count + 1, 2)
    drive = RecordedDrive(stamps, ways, marks)
    query, match = np.arange(42, 120, 2), np.arange(42, 120, 2) - 40
    query, match = np.append(query, [60, 90, 5, 70]), np.append(match, [3, 30, 4, -1])
    outside = np.where(match < 0, 10**15, stamps[marks][match])
    return drive, PlaceClaims(stamps[marks][query], outside, query, match, rng.uniform(0.5, 1.0, len(query)))


@pytest.mark.parametrize("curvature", [0.0, 0.03])
def test_a_recorded_drive_is_mapped_along_its_way_as_before(curvature: float) -> None:
    drive, claims = recorded(curvature)
    found = {}
    for name, settings in (("plain", AlongSettings()), ("axes", AlongSettings(building_axes=True, every=40.0)),
                           ("strict", AlongSettings(min_believed=1.0, chance=0.0, min_way=30.0))):  # fmt: skip
        mapping, solution = map_along(drive, claims, settings)
        verdicts = [f"{d.candidate.query} {d.verdict} {d.reason}" for d in mapping.ledger.decisions]
        found |= {
            f"{name} poses": [*solution.poses[::10].ravel(), *mapping.online[::40].ravel()],
            f"{name} told": [mapping.inlier_share, *mapping.prior_sigmas, *mapping.calibration.vector() * 10],
            f"{name} said": verdicts,
        }
    found["straight"] = drive.straight(3.0, 0.05).astype(float)
    as_before(f"odometry along {curvature:g}", found)


def test_of_few_places_all_are_held_against_a_view() -> None:
    recognition = Recognition(RecognitionSettings(min_travel=1.0))
    for k in range(12):
        recognition.add(k, 0.5 * k, view(k))
    near, likely = recognition._search(signature(view(3)), 40.0, np.arange(12))
    moment = SimpleNamespace(panorama=view(3), travel=40.0, places=near, likely=likely, difference={3: 0.0})
    assert sorted(recognition._older(moment)) == list(range(12))
    assert recognition._older(moment)[3] == 0.0
