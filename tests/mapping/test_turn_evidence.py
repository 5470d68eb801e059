"""Turns between neighbours: three instruments tell one another's errors, and a shared error doesn't average out."""

from __future__ import annotations

import math

import numpy as np
import pytest
from kept import as_before

from topomap.core.arrays import FloatArray
from topomap.mapping.measured_turns import MeasuredTurn
from topomap.mapping.turn_evidence import SHARE_UNCHECKED, TurnEvidence, Weighed

DEGREE = math.radians(1.0)
WAY = 0.3  # [m]
CORNER = math.radians(90.0)


def drive(n: int, seed: int) -> FloatArray:
    """Every tenth turn is a corner, the others bend a little."""
    rng = np.random.default_rng(seed)
    turns = rng.normal(0.0, 2.0 * DEGREE, n)
    turns[::10] += CORNER * rng.choice([-1.0, 1.0], len(turns[::10]))
    return turns


def weighed(
    n: int = 200,
    seed: int = 0,
    aligned: float = 0.5,
    matched: float | None = 0.1,
    common: float = 0.0,
    gain: float = 1.0,
    declared: float = 1.0,
    lost: float = 0.0,
) -> tuple[Weighed, FloatArray]:
    """Weigh a drive of many short edges.

    aligned, matched: errors of the two methods, common: one that they share [degree]; gain: of the aligner's turns;
    declared: the odometer's variance, as a multiple of the true one; lost: share of the aligner's turns that read 0.
    """
    rng = np.random.default_rng(seed + 1000)
    true, evidence = drive(n, seed), TurnEvidence()
    shared = rng.normal(0.0, common, n)
    for k, turn in enumerate(true.tolist()):
        read = 1.04 * turn + 0.003 * WAY + rng.normal(0.0, 0.5 * DEGREE)
        seen = 0.0 if rng.random() < lost else gain * turn + (rng.normal(0.0, aligned) + shared[k]) * DEGREE
        second = math.nan if matched is None else turn + (rng.normal(0.0, matched) + shared[k]) * DEGREE
        evidence.add(
            MeasuredTurn(k, k + 1, read, WAY, declared * (0.5 * DEGREE) ** 2, 1.0, aligned=seen, matched=second)
        )
    return evidence.weigh(), true


def straight_sigmas(found: Weighed, true: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sigmas and errors in sigmas of the turns that are no corners."""
    edges = [edge for edge in found.edges if abs(true[edge.i]) < 0.2]
    sigma = np.array([edge.sigma for edge in edges])
    return sigma, np.array([edge.turn - true[edge.i] for edge in edges]) / sigma


@pytest.mark.parametrize(("aligned", "matched"), [(0.5, 0.1), (0.2, 1.0), (1.5, 1.5), (0.3, 0.3), (3.0, 2.0)])
def test_errors_are_told_by_the_data(aligned: float, matched: float) -> None:
    for seed in range(5):
        found, true = weighed(400, seed, aligned, matched)
        sigma, z = straight_sigmas(found, true)
        assert float(np.median(sigma)) < math.hypot(0.9 * math.hypot(aligned, matched), 0.25) * DEGREE
        assert 0.2 < float(np.sqrt(np.mean(z**2))) < 1.3


@pytest.mark.parametrize("declared", [1 / 9, 1.0, 9.0])
def test_the_odometers_declared_variance_is_judged(declared: float) -> None:
    for seed in range(5):
        found, _ = weighed(400, seed, 0.15, 0.1, declared=declared)
        assert found.odometer is not None
        least, most = found.odometer
        assert 0.85 * least <= 1 / declared <= most
        assert most < 1.6 / declared


@pytest.mark.parametrize("declared", [1 / 9, 1.0])
def test_where_the_view_may_explain_all_the_odometer_is_taken_for_a_poor_one(declared: float) -> None:
    found, _ = weighed(400, 0, 0.8, 0.8, declared=declared)
    assert found.odometer is not None
    assert 1.0 <= found.odometer[0] * declared <= 4.0


def test_two_methods_that_err_together_dont_blame_the_odometer_beyond_what_one_can_be() -> None:
    found, true = weighed(400, 0, 1.0, 1.0, common=6.0)
    _, z = straight_sigmas(found, true)
    assert float(np.sqrt(np.mean(z**2))) < 1.5


def test_what_only_the_odometer_checks_is_put_down_to_the_view() -> None:
    found, true = weighed(400, 0, 0.3, None)
    sigma, z = straight_sigmas(found, true)
    assert float(np.sqrt(np.mean(z**2))) < 1.0
    assert float(np.median(sigma)) > 0.5 * DEGREE
    assert found.odometer is not None
    least, most = found.odometer
    assert least == pytest.approx(min(4.0, most))  # a poor odometer's variance is four times the simulator's


def test_an_error_shared_by_all_corners_doesnt_average_out() -> None:
    found, true = weighed(400, 0, 0.3, None, gain=0.86)
    told = sum(edge.turn**2 / edge.sigma**2 for edge in found.edges if abs(true[edge.i]) > 0.5)
    assert told <= 1.001 / SHARE_UNCHECKED**2  # as much as one corner would tell


def test_a_gain_that_two_methods_dont_share_widens_every_corner() -> None:
    alike, true = weighed(400, 0, 0.2, 0.2)
    unlike, _ = weighed(400, 0, 0.2, 0.2, gain=0.86)

    def corners(found: Weighed) -> float:
        return float(np.median([edge.sigma for edge in found.edges if abs(true[edge.i]) > 0.5]))

    assert corners(unlike) > 4 * corners(alike)


def test_turns_no_odometer_explains_are_dismissed() -> None:
    found, true = weighed(400, 0, 0.05, 0.3, gain=0.1)
    off = [abs(edge.turn - true[edge.i]) for edge in found.edges]
    assert max(off) < 3 * DEGREE  # the second method's; the first one's would be 80 degrees off at every corner


def test_a_turn_that_two_methods_contradict_is_as_unsure_as_they_are_apart() -> None:
    found, true = weighed(400, 0, 0.3, 0.5, lost=0.1)
    z = np.array([(edge.turn - true[edge.i]) / edge.sigma for edge in found.edges])
    assert float(np.abs(z).max()) < 4.5


def test_few_turns_are_believed_little() -> None:
    found, _ = weighed(6)
    assert min(edge.sigma for edge in found.edges) >= 1.5 * DEGREE
    assert found.odometer is None


def test_nothing_measured_is_nothing() -> None:
    assert TurnEvidence().weigh().edges == ()


def test_ranges_are_taken_as_they_are_and_judge_the_odometer() -> None:
    rng, evidence = np.random.default_rng(0), TurnEvidence()
    for k, turn in enumerate(drive(300, 0).tolist()):
        read = 1.04 * turn + rng.normal(0.0, 0.5 * DEGREE)
        scanned = turn + rng.normal(0.0, 0.05 * DEGREE)
        evidence.add(MeasuredTurn(k, k + 1, read, 1.0, 4 * (0.5 * DEGREE) ** 2, 1.0, scanned, 0.05 * DEGREE))
    found = evidence.weigh()
    assert {edge.sigma for edge in found.edges} == {0.05 * DEGREE}
    assert found.odometer is not None
    assert found.odometer[0] == pytest.approx(0.25, rel=0.3)


CASES: dict[str, dict[str, float | None]] = {
    "two alike": {},
    "unlike": {"aligned": 0.2, "matched": 1.0},
    "poor": {"aligned": 3.0, "matched": 2.0, "declared": 9.0},
    "common": {"aligned": 1.0, "matched": 1.0, "common": 6.0},
    "alone": {"aligned": 0.3, "matched": None, "gain": 0.9},
    "lost": {"aligned": 0.3, "matched": 0.5, "lost": 0.1},
    "exact": {"aligned": 0.05, "matched": 0.3, "gain": 0.1, "declared": 0.1},
}


@pytest.mark.parametrize("name", CASES)
def test_weighed_turns_are_as_before(name: str) -> None:
    found, _ = weighed(60, 3, **CASES[name])  # type: ignore[arg-type]
    edges = [(edge.i, edge.turn, edge.sigma / DEGREE) for edge in found.edges]
    as_before("turns", {name: edges, f"{name}, odometer": found.odometer or ()}, part=True)


@pytest.mark.parametrize("corners", [0, 4])
@pytest.mark.parametrize("by", ["scanned", "aligned"])
@pytest.mark.parametrize("seed", range(4))
def test_along_a_corridor_the_odometers_wobble_is_its_noise_and_not_its_scale(corners: int, by: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    turns = rng.normal(0.0, 0.02 * DEGREE, 120)
    turns[30 : 30 + corners] = CORNER
    evidence = TurnEvidence()
    for k, turn in enumerate(turns.tolist()):
        read = 1.04 * turn + rng.normal(0.0, 0.3 * DEGREE)
        exact = turn + rng.normal(0.0, 0.05 * DEGREE)
        seen = {"scanned": exact, "scan_sigma": 0.05 * DEGREE} if by == "scanned" else {by: exact, "matched": turn}
        evidence.add(MeasuredTurn(k, k + 1, read, WAY, (0.3 * DEGREE) ** 2, 1.0, **seen))
    told = evidence.weigh().odometer
    assert told is not None
    assert told[0] < 1.5
    assert told[1] > 0.6
