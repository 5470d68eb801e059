"""What the closure engine's stages decide at their bounds and on either side of them: the same as before."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from kept import as_before
from maps import square

from topomap.core.evidence import Evidence
from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, Candidate, HomeVector, PlaceMatch, Verdict
from topomap.core.rig import Rig
from topomap.mapping.closures import batch, noise, relative_pose
from topomap.mapping.closures.appearance import FEW, RIVAL_DISTANCE, Appearance, Look, Outcome, _outcome, apart
from topomap.mapping.closures.chance import probability
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import TESTS, Apart, Crowding, Knowledge, Looks, Odometry, Prevalence
from topomap.mapping.closures.difference_rule import DifferenceRule, DifferenceRuleSettings
from topomap.mapping.closures.engine import ClosureEngine
from topomap.mapping.closures.gates import Gate, Supported
from topomap.mapping.closures.ledger import Ledger
from topomap.mapping.closures.looks import FEWEST, MEMORY, LogRatio, UsualCost, Weights, log_ratio
from topomap.mapping.closures.online import Closing, ClosingSettings
from topomap.mapping.closures.placing import FAR_TURNED, placed
from topomap.mapping.closures.prevalence import log_prevalence
from topomap.mapping.closures.relative_pose import RelativePoseEstimator, RelativePoseSettings
from topomap.mapping.closures.seen import Seen
from topomap.mapping.closures.settling import doubtful
from topomap.mapping.closures.sight import EQUALLY, SLOW, Sight
from topomap.mapping.closures.sight_tests import (
    BY_SIGHT,
    MOST_APART,
    MOST_COST,
    MOST_RATIO,
    MOST_TOGETHER,
    TIMES_USUAL,
    UNMEASURED,
    AsUsual,
    Familiar,
    SameSpot,
)
from topomap.mapping.closures.spot_tests import AtPlace, Beside, Placed
from topomap.mapping.closures.strain import _cells, _in_map_axes
from topomap.mapping.closures.support import Support
from topomap.mapping.closures.voting import ANGLE, DISTANCE, WITHIN, Voting
from topomap.mapping.competition import Contest, _stretches, _turns_tell
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.optimizer.problem import Closures, OdometryEdge, OdometryEdges, Problem, TurnEdge
from topomap.mapping.places.contrast import FEWEST as CONTRASTED
from topomap.mapping.places.contrast import MARGIN, Contrast
from topomap.mapping.track import Track
from topomap.vision.matching.scan_match import ScanMatch

MAP = square(8)
VIEW = Panorama(np.zeros((10, 72, 3), np.uint8), np.full(72, 2.0, np.float32), Rig(72, 10, 4.5, 72 / math.tau))


def around(bound: float) -> tuple[float, float, float]:
    """Just below, at, and just above."""
    return math.nextafter(bound, -math.inf), bound, math.nextafter(bound, math.inf)


def many(count: int = 12, seed: int = 0) -> tuple[Claims, Knowledge]:
    """Claims on a bending way, some of them blind, and what a map knows of them."""
    rng = np.random.default_rng(seed)
    poses = np.column_stack([np.cumsum(rng.uniform(0.3, 1.0, (40, 2)), axis=0), rng.uniform(-3, 3, 40)])
    i, j = rng.integers(0, 20, count), rng.integers(20, 40, count)
    roots = rng.normal(size=(count, 3, 3)) * 0.1 + 0.2 * np.eye(3)
    covariance = roots @ roots.transpose(0, 2, 1)
    covariance[::4, 2, 2] = 40.0
    there = np.array([Pose2.of(poses[a]).to(Pose2.of(poses[b])).array() for a, b in zip(i, j, strict=True)])
    relative = there + rng.normal(size=(count, 3)) * np.array([0.5, 0.5, 0.3]) * rng.choice([0.2, 1.0, 4.0], (count, 1))
    claims = replace(Claims.of(i, j, relative, covariance), looks=rng.normal(size=count))
    errors = roots @ roots.transpose(0, 2, 1) * 0.3 + 0.01 * np.eye(3)
    seen = Seen(*rng.uniform(0.2, 1.1, (5, count)), *(rng.random((3, count)) < 0.5))
    return claims, Knowledge(poses, errors, rng.integers(1, 9, count), rng.normal(size=count), rng.random(count), seen)


def test_each_test_says_as_much_as_before() -> None:
    claims, knowledge = many()
    tests = (*TESTS, Looks(), Prevalence(), Odometry(), AtPlace(), Beside(0.8), Placed(0.5), Apart(), Crowding(),
             Supported(), Gate(0.95), *BY_SIGHT, SameSpot(), AsUsual())  # fmt: skip
    found = {f"{k} {one.name}": np.clip(one.weigh(claims, knowledge), -1e3, 1e3) for k, one in enumerate(tests)}
    words = [one.reason(claims[k : k + 1], knowledge.among(np.array([k])))
             for one in tests if hasattr(one, "reason") for k in (1, 4, 7)]  # fmt: skip
    engine = ClosureEngine(tests[:5])
    for bar in (-np.inf, -2.0, 0.0, 3.0):
        weighed = engine.weigh(claims, knowledge, bar)
        found[f"bar {bar}"] = [np.clip(weighed.log_odds, -1e3, 1e3), weighed.failed]
    part = engine.weigh(claims, knowledge, 0.0, slice(1, 3))
    found["part"] = [np.clip(part.log_odds, -1e3, 1e3), part.failed]
    found["beside"] = engine.beside_odometry(claims, knowledge)
    as_before("closing tests", {**found, "words": [*words, engine.reason(claims[:1], knowledge, 0)]})


def one(**seen: object) -> tuple[Claims, Knowledge]:
    """One claim at its very place, seen as told."""
    usual = {"difference": 0.5, "limit": 0.9, "cost": 0.3, "ratio": 0.5, "usual": 0.4} | seen
    claim = Claims.of_one(0, 1, Pose2(), 0.01 * np.eye(3))
    return claim, Knowledge.of_one(np.zeros((2, 3)), np.zeros((3, 3)), Seen.of_one(**usual))


def refused(test: object, claim: Claims, knowledge: Knowledge) -> bool:
    return bool(np.isneginf(test.weigh(claim, knowledge)[0]))


def test_what_is_seen_is_refused_beyond_its_bounds() -> None:
    alike, distinct, reachable, familiar = BY_SIGHT
    assert [refused(alike, *one(cost=c)) for c in around(MOST_COST)] == [False, False, True]
    assert not refused(alike, *one(cost=0.99, clear=True))
    assert [refused(distinct, *one(ratio=r)) for r in around(MOST_RATIO)] == [False, False, True]
    assert [refused(distinct, *one(ratio=r, waits=True)) for r in around(MOST_TOGETHER)] == [False, False, True]
    assert [refused(reachable, *one(compared=c)) for c in (True, False)] == [False, True]
    assert [refused(familiar, *one(difference=d)) for d in around(0.9)] == [False, False, True]
    assert isinstance(familiar, Familiar)
    for x, beyond in zip(around(MOST_APART), (False, False, True), strict=True):
        claim, knowledge = one()
        assert refused(SameSpot(), replace(claim, relative=np.array([[x, 0.0, 0.0]])), knowledge) is beyond
    for sigma, cost, beyond in ((UNMEASURED * 1.001, 0.4 * TIMES_USUAL + 1e-9, True), (UNMEASURED * 0.999, 3.0, False),
                                (0.5, 0.4 * TIMES_USUAL, False)):  # fmt: skip
        claim, knowledge = one(cost=cost)
        assert refused(AsUsual(), replace(claim, covariance=claim.covariance * 100 * sigma**2), knowledge) is beyond
    claim, knowledge = one()
    for support, beyond in zip(around(1.0), (True, False, False), strict=True):
        assert refused(Supported(), claim, replace(knowledge, support=np.array([support]))) is beyond
    assert Support(np.array([0.5]), 2.0).reason(0) == "too few neighbours along the way agree (1.00 of at least 2.00)"


def test_looks_say_as_much_as_before() -> None:
    told = [log_ratio(Weights(-3.0, 4.0, 10.0), cost, rival, usual)
            for cost, rival, usual in itertools.product((0.0, 0.2, 0.5), (0.0, 0.4, 0.6), (0.3, 0.9))]  # fmt: skip
    learnt, costs = LogRatio(), UsualCost()
    for k in range(MEMORY + 4):
        assert math.isinf(costs.value) is (k < FEWEST)
        elsewhere = math.nan if k == 20 else 0.4 + 0.01 * k
        winner = Look(PlaceMatch(1, 0.3, 0.0), Alignment(0.0, 0.25, None))
        for ratio, rivals in ((0.6, True), (0.0, True), (0.6, False)):
            outcome = SimpleNamespace(winner=winner, ratio=ratio, elsewhere=elsewhere)
            told.append(learnt.of(outcome, rivals) if k != 20 or ratio == 0.0 else 0.0)
        costs.learn(0.2 + 0.01 * k)
        told.append(min(costs.value, 9.0))
    fresh = LogRatio()
    for k in range(FEWEST + 1):
        assert fresh.known is (k >= FEWEST)
        told.append(fresh.of(SimpleNamespace(winner=winner, ratio=0.0, elsewhere=0.5), False))
    contrast = Contrast()
    places = np.array([[0.0, 0.0], [0.5, 0.0], [3.0, 0.0], [9.0, 1.0]])
    for k in range(CONTRASTED + 60):
        rng = np.random.default_rng(k)
        contrast.learn(rng.uniform(0.3, 1.0, 4), places, 1.5)
        told += [contrast.log_ratio(d, 0.9) for d in (0.02, 0.2, MARGIN * 0.3, 0.5)]
    contrast.learn(np.zeros(0), places[:0], 1.5)
    contrast.learn(np.array([0.1, 0.2]), places[:2], 1.5)
    told.append(len(contrast._chance))
    as_before("closing looks", {"told": told})


def test_what_is_compared_tells_as_much_as_before() -> None:
    far, rows = apart(0.0), list[str]()
    assert [apart(c) for c in (0.0, 0.6, 1.0)] == [RIVAL_DISTANCE, RIVAL_DISTANCE, 2.5]
    costs, asked = {0: 0.5, 1: 0.3, 2: 0.4, 3: 0.31, 4: 0.9, 5: 0.2}, list[int]()

    def align(view: object, node: int, rotation: float) -> Alignment:
        asked.append(node)
        return Alignment(rotation, costs[node], None)

    place = {0: 0.0, 1: 0.1, 2: far, 3: 3.0, 4: 9.0, 5: far + 0.11}
    appearance = Appearance(SimpleNamespace(align=align))

    def distance(a: int, b: int) -> float:
        return abs(place[a] - place[b])

    for places, rivals in (((0,), ()), ((0, 1), (2, 3)), ((1,), (4, 3, 2)), ((0, 1, 2, 3, 4, 5), ()), ((1,), (5, 4))):
        asked.clear()
        near, far_off = ([PlaceMatch(k, 0.5, 0.1) for k in some] for some in (places, rivals))
        found = appearance.compare(VIEW, near, far_off, lambda k: k, distance)
        rows.append(f"{found.winner.match.node} {found.ratio:.4f} {found.elsewhere:.3f} "
                    f"{[k.match.node for k in found.alike]} {asked}")  # fmt: skip
        rest = [PlaceMatch(k, 0.5, 0.0) for k in (0, 2, 4, 5, 3)]
        rows.append(f"{appearance.elsewhere(VIEW, found.winner, rest, lambda k: k, distance):.4f} {asked[-FEW:]}")
    assert math.isnan(appearance.elsewhere(VIEW, found.winner, [], lambda k: k, distance))
    only = _outcome([Look(PlaceMatch(0, 0.5, 0.0), Alignment(0.0, 0.0, None))], distance, far)
    assert (only.ratio, len(only.alike)) == (0.0, 1)
    as_before("closing compared", {"rows": rows})


def test_a_sighting_is_the_nearest_of_what_is_equally_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = list[str]()
    looks = [
        Look(PlaceMatch(k, d, 0.2), Alignment(0.1, 0.3 + 0.1 * k, None)) for k, d in ((3, 0.30), (8, 0.34), (20, 0.36))
    ]
    for length, other, open_places, older in itertools.product(
        (0.0, *around(SLOW)), (0.5, 1.0), (False, True), ({}, {3: 0.3, 30: 0.7}, {5: 0.2, 12: 0.01, 31: 0.9})
    ):
        catchment = SimpleNamespace(length=length, other=other)
        contrast = SimpleNamespace(log_ratio=lambda d, rival: 1.5 if rival > 0.6 else 0.0)
        track = SimpleNamespace(map=MAP, pose_at=lambda stamp: Pose2(1.9, 0.0, 0.0))
        sight = Sight(None, track, SimpleNamespace(panorama=lambda k: k), 0.1 * np.eye(3), catchment, contrast)
        outcome = SimpleNamespace(winner=looks[0], ratio=0.8, elsewhere=math.nan, alike=tuple(looks))
        whole = Outcome(looks[0], 0.8, math.nan, tuple(looks))
        near = sight._nearest(5, whole)
        rows.append(f"{length:.6f} {other} {near.winner.match.node}")
        moment = SimpleNamespace(stamp_ns=5, panorama=VIEW, difference={3: 0.3})
        proposal = SimpleNamespace(moment=moment, older=older, limit=0.9, rivals=(), places=())
        rows.append(f"{sight._clear(proposal, outcome)}")
        monkeypatch.setattr(sight._appearance, "compare", lambda *_, w=whole: w)
        monkeypatch.setattr(sight._appearance, "elsewhere", lambda *_: 0.7)
        candidate, seen, winner = sight.compare(proposal, open_places)
        rows.append(f"{candidate.match} {candidate.relative} {candidate.similarity:.3f} {candidate.evidence}")
        rows.append(f"{seen} {winner.match.node} {sight.apart}")
    assert EQUALLY == 0.35
    as_before("closing sighted", {"rows": rows})


def candidate(match: int, query: int, ratio: float = 0.5, x: float = 0.0, active: float | None = None) -> Candidate:
    stamp, old = MAP.nodes[query].stamp_ns, MAP.nodes[match].stamp_ns
    relative = MAP.pose(match).to(MAP.pose(query)) @ Pose2(x, 0.0, 0.0)
    evidence = Evidence(0.3, 0.9, 0.4, ratio, active=active, looks=0.2)
    return Candidate(stamp, match, old, relative, 0.01 * np.eye(3), 0.7, query, evidence)


def test_votes_are_counted_at_their_bounds() -> None:
    told = list[float]()
    for ratio, active in itertools.product((0.0, 0.74, 0.75, 0.76, 0.9, 1.0), (None, 1.0)):
        told.append(Voting(MAP)._weight(candidate(1, 20, ratio, active=active)))
    voting = Voting(MAP)
    for x, turn, agree in ((DISTANCE - 1e-6, 0.0, True), (DISTANCE + 1e-6, 0.0, False), (0.0, ANGLE - 1e-6, True),
                           (0.0, -ANGLE - 1e-6, False)):  # fmt: skip
        a, b = candidate(1, 20), candidate(2, 20, x=x)
        b = replace(b, relative=b.relative @ Pose2(0.0, 0.0, turn), query=20)
        assert voting._agree(a, b) is agree, (x, turn)
    wide = replace(candidate(1, 20), covariance=np.diag([0.5, 0.9, 0.1]))
    assert voting._agree(wide, candidate(2, 20, x=0.6))
    assert voting._agree(candidate(1, 20), candidate(2, 24, x=DISTANCE + 0.09))
    assert not voting._agree(candidate(1, 20), candidate(2, 24, x=DISTANCE + 0.11))
    for match, query, x in ((1, 20, 0.0), (2, 21, 0.1), (9, 22, 5.0), (3, 22, 0.0), (4, 23, 0.0)):
        company = voting.add(candidate(match, query, 0.8, x))
        told += [company.support, len(company.agreeing)]
    travel = MAP.nodes[20].travel + WITHIN
    told += [len(voting.expired(t)) for t in (*around(travel)[:2], travel + 1e-6, travel + 0.6)]
    voting.settle(company)
    told.append(len(voting._waiting))
    lone = candidate(6, 30)
    voting.add(lone)
    voting.drop(candidate(6, 30))
    told.append(len(voting._waiting))
    voting.drop(lone)
    told.append(len(voting._waiting))
    as_before("closing votes", {"told": told})


class Sighted:
    """A sight that sees what it is told to."""

    def __init__(self, seen: Seen, made: Candidate) -> None:
        self.seen, self.made, self.learnt = seen, made, 0
        self.apart = 1.5

    def compare(self, *_: object) -> tuple[Candidate, Seen, object]:
        return replace(self.made, query=None), self.seen, Look(PlaceMatch(1, 0.3, 0.0), Alignment(0.0, 0.3, None))

    def believed(self, _: object) -> None:
        self.learnt += 1


def test_a_proposal_comes_to_the_verdicts_of_before(monkeypatch: pytest.MonkeyPatch) -> None:
    rows, topo = list[str](), square(8)
    track = Track(topo)
    for (reach, clear, ratio), (x, cost), spread in itertools.product(
        ((0.5, True, 0.5), (5.0, True, 0.5), (5.0, True, 0.95), (5.0, False, 0.5), (1.2, True, 0.93)),
        ((0.0, 0.3), (0.0, 0.9), (0.9, 0.3), (0.3, 0.3)), (1e-4, 0.2),
    ):  # fmt: skip
        closed = list[object]()
        monkeypatch.setattr(topo, "close", closed.append)
        ledger, believed = Ledger(), list[object]()
        optimisation = SimpleNamespace(believe=lambda edge, one, b=believed: b.append(edge), covariance=np.eye(3),
                                       disbelieve=lambda *a: [], sequential=SimpleNamespace(turns=[]))  # fmt: skip
        closing = Closing(
            ClosingSettings(), None, track, SimpleNamespace(panorama=lambda k: VIEW), ledger, optimisation
        )
        made = candidate(1, 30, ratio, x)
        closing._sight = Sighted(Seen.of_one(0.3, 0.9, cost, ratio, clear=clear), made)
        closing._reachability = SimpleNamespace(
            reach=lambda node, r=reach: r, errors=lambda a, b, s=spread: s * np.eye(3)
        )
        measured = SimpleNamespace(relative=made.relative, covariance=0.01 * np.eye(3), share=0.4)
        monkeypatch.setattr(closing._offset, "measure", lambda *_, m=measured: m)
        moment = SimpleNamespace(panorama=VIEW, stamp_ns=made.query_ns)
        proposal = SimpleNamespace(places=(PlaceMatch(1, 0.3, 0.0),), moment=moment)
        for step in range(4):
            shown = candidate(*((0, 31), (1, 32), (0, 32), (0, 32))[step], ratio, x)
            closing._sight.made = shown
            moment.stamp_ns, measured.relative = shown.query_ns, shown.relative
            said = closing.judge(step, proposal if step < 3 else None)
            rows += [f"{reach} {clear} {ratio} {x} {cost} {spread} {step}: {d.verdict} {d.reason} "
                     f"{d.candidate.query} {d.candidate.evidence.odds}" for d in said]  # fmt: skip
            if step == 1 and (waits := ledger.pending):
                closing.testify(waits[0], True, "seen nearer")
            if step == 2 and (waits := ledger.pending):
                closing.testify(waits[-1], False, "seen farther")
        closing.forget(9)
        rows += [f"{d.verdict} {d.reason}" for d in closing.judge(10, None)]
        rows.append(f"{len(believed)} {len(closed)} {closing._sight.learnt}")
    assert any("accepted" in row for row in rows)
    assert any("waits for others" in row for row in rows)
    as_before("closing verdicts", {"rows": [row.replace("-0.0,", "0.0,") for row in rows]})


def test_what_nobody_agrees_with_in_time_is_refused() -> None:
    ledger = Ledger()
    track = Track(MAP)
    optimisation = SimpleNamespace(believe=lambda *_: None, disbelieve=lambda *_: ["withdrawn"],
                                   covariance=np.eye(3), sequential=SimpleNamespace(turns=[]))  # fmt: skip
    closing = Closing(ClosingSettings(), None, track, None, ledger, optimisation)
    waits = candidate(1, 20)
    closing._vote(1, waits, "open")
    assert ledger.verdict((waits.query_ns, waits.match_ns)) is Verdict.PENDING
    track.travel = MAP.nodes[20].travel + WITHIN + 0.1
    assert [d.verdict for d in closing.judge(2, None)] == [Verdict.REFUSED]
    closing.withdraw(3, {1})
    assert closing.judge(4, None) == ("withdrawn",)
    assert closing.judge(5, None) == ()


def test_chance_prevalence_and_doubt_are_as_before() -> None:
    rng, told = np.random.default_rng(4), list[float]()
    poses = np.column_stack([rng.uniform(0, 20, (60, 2)), np.zeros(60)])
    travelled = np.cumsum(rng.uniform(0.5, 1.5, 60))
    for stood, heard, near, gap in ((0, 9, 2.0, 5.0), (1, 9, 2.0, 5.0), (4, 9, 2.0, 5.0), (4, 9, 0.0, 5.0),
                                    (2, 40, 2.0, 50.0), (2, 3, 2.0, 1e3)):  # fmt: skip
        told.append(math.log(probability(stood, heard, poses, travelled, near, gap) + 1e-30))
    size = np.array([1, 2, 3, 4, 5, 8, 13, 20, 21, 40, 1, 1, 2, 1])
    for allowed in (np.ones(14, bool), np.arange(14) % 3 > 0):
        for share in (0.0, 0.4, 0.95):
            told += log_prevalence(size, allowed, share).tolist()
    odds = np.array([9.0, 8.0, 2.9, 3.1, 6.0, -1.0, 7.5, 6.9])
    told += doubtful(odds, np.array([1, 1, 3, 4, 1, 2, 1, 3])).tolist()
    told += doubtful(odds[:0], np.zeros(0, np.int64)).tolist()
    as_before("closing chance", {"told": told})


def test_what_lies_behind_a_gap_is_moved_where_a_claim_has_it() -> None:
    poses, variance = MAP.poses[:12].copy(), np.full(12, 1e-4).cumsum()
    random = np.zeros((12, 3, 3))
    random[:, 2, 2] = variance
    open_ = random.copy()
    open_[6:, 2, 2] += 1.0
    told = [np.zeros((0, 3))]
    for errors, turn in itertools.product((random, open_), (FAR_TURNED - 1e-6, FAR_TURNED + 1e-6, -2.0)):
        told.append(placed(poses, SimpleNamespace(random=errors), Claims.of_one(2, 9, MAP.pose(2).to(MAP.pose(9))
                    @ Pose2(0.3, 0.1, turn), np.eye(3))))  # fmt: skip
    beside = Claims.of_one(7, 9, MAP.pose(7).to(MAP.pose(9)) @ Pose2(0.0, 0.0, 2.0), np.eye(3))
    told.append(placed(poses, SimpleNamespace(random=open_), beside))
    as_before("closing placed", {"told": np.concatenate(told)})


def test_what_cells_miss_by_is_as_before() -> None:
    claims, knowledge = many(14, 3)
    order = np.lexsort((claims.j, claims.i))
    cells = _cells(knowledge.poses, claims[order], np.arange(14) // 3)
    turned, spread = _in_map_axes(knowledge.poses, claims, claims.j[::-1])
    as_before("closing cells", {"label": cells.label, "ends": [cells.i, cells.j], "mean": cells.mean,
                                "covariance": cells.covariance, "turned": turned, "spread": spread})  # fmt: skip


def test_a_relative_pose_is_measured_by_ranges_or_the_floor_or_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    rows, asked = list[float](), list[np.ndarray]()
    bare = replace(VIEW, ranges=None)
    home = Look(PlaceMatch(1, 0.3, 0.0), Alignment(0.4, 0.3, HomeVector(0.7, None, 0.8)))
    blunt = Look(PlaceMatch(1, 0.3, 0.0), Alignment(-3.0, 0.3, None))
    for fits, (place, view), look, catchment in itertools.product(
        ("measured", "seen", "none"),
        ((VIEW, VIEW), (bare, VIEW), (VIEW, bare), (None, VIEW)),
        (home, blunt),
        (0.0, 0.9),
    ):

        def match(a: object, b: object, guess: np.ndarray, surfaces: object, f: str = fits) -> ScanMatch | None:
            asked.append(guess)
            good = f == ("measured" if surfaces is relative_pose.MEASURED else "seen")
            share = 0.2 + 0.1 * float(np.hypot(*guess[:2]))
            return ScanMatch(guess + np.array([0.1, 0.05, 0.02]), np.diag([0.01, 0.02, 0.001]), share) if good else None

        monkeypatch.setattr(relative_pose, "match_scans", match)
        found = RelativePoseEstimator(RelativePoseSettings()).measure(look, place, view, catchment)
        rows += [*found.relative.array(), found.share, *np.sqrt(found.covariance.diagonal()), found.covariance[0, 1]]
    as_before("closing measured", {"rows": rows, "guesses": np.array(asked)[:60]})


def test_a_contest_needs_stretches_and_turns_that_tell() -> None:
    told = list[float]()
    for count in (0, 1, 3, 4, 11, 12, 13, 30):
        none = np.zeros(count, np.int64)
        closures = Closures(none, np.arange(count)[::-1], np.zeros((count, 3)), np.zeros((count, 3, 3)), np.ones(count))
        told += _stretches(closures).tolist()
    edges = OdometryEdges.of([OdometryEdge(a, b, way) for a, b, way in MAP.odometry_edges()][:10])
    declared = 5 * 1e-4
    for sigma in (0.5 * math.sqrt(declared) * 0.999, 0.5 * math.sqrt(declared) * 1.001):
        turns = tuple(TurnEdge(k, k + 1, 0.0, sigma) for k in range(5))
        told.append(_turns_tell(Problem(MAP.poses[:11], edges, Closures.of([]), turns, Calibration())))
    told.append(_turns_tell(Problem(MAP.poses[:11], edges, Closures.of([]), (), Calibration())))
    said = [Contest(kept, errors).reason for kept, errors in (("dead reckoning", {}), ("all evidence", {}),
            ("dead reckoning", {"all evidence": 1.234, "dead reckoning": 0.5}))]  # fmt: skip
    as_before("closing contest", {"told": told, "said": said})


def test_the_thesis_rule_corrects_at_its_bounds() -> None:
    told = list[float]()
    for turn, off, way in itertools.product((0.1, 0.157, 0.158, -0.3), (0.0, 0.4, -0.6, 1.0), (0.0, 0.1)):
        rule = DifferenceRule(DifferenceRuleSettings())
        for k in range(12):
            rule._move(SimpleNamespace(forward=way, turn=turn if k < 11 else 0.0))
        told += [*rule._corrections(1, 11, 10 * turn + off), *rule._travelled[-1:]]
        told += rule._redone(2, 6, 0.9, 1.1)[-1].tolist()
    as_before("closing thesis", {"told": told})


def test_a_solution_is_doubtful_at_its_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    told = list[bool]()
    for complete, standing, open_, tension in itertools.product(
        (True, False), (batch.TELLING - 1, batch.TELLING, 20), (2, 3, 4), around(batch.TENSE)
    ):
        monkeypatch.setattr(batch, "_complete", lambda _, c=complete: c)
        monkeypatch.setattr(batch, "undecided", lambda _, o=open_: o)
        working = SimpleNamespace(standing_clusters=lambda s=standing: np.zeros(s))
        told.append(batch._doubtful(batch._Solution(working, "", 1.0, tension)))
    monkeypatch.undo()
    for standing, open_ in itertools.product((0, 99, 100, 300), (0, 1, 2, 3, 4)):
        monkeypatch.setattr(batch, "undecided", lambda _, o=open_: o)
        told.append(batch._complete(SimpleNamespace(standing_clusters=lambda s=standing: np.zeros(s))))
    as_before("closing doubtful", {"told": np.array(told, float)})


def test_a_mixture_needs_so_many_true_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    for true, found in zip(around(float(noise.FEWEST)), (False, True, True), strict=True):
        fit = (1.0, 0.5, 9.0, np.array([0.6, 0.2, 0.2]), true, 4.0)
        monkeypatch.setattr(noise, "_fitted", lambda *_, f=fit: f)
        assert (noise._mixture(np.ones(3), np.ones(3)) is not None) is found
    told = [noise._Fit(1.0, scale, 9.0, np.ones(3), true, tails).factor()
            for scale, true, tails in itertools.product((0.5, 2.0), (0.0, 1.0, 20.0, 500.0), (4.0, 64.0))]  # fmt: skip
    as_before("closing mixture", {"told": told})
