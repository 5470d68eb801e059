"""The finished map against itself without turns by sight, and against dead reckoning."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ring import ring

from topomap.core.arrays import FloatArray
from topomap.mapping.competition import BLIND, DEAD, FULL, compete
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.optimizer import Closures, OptimizerSettings, Problem, TurnEdge, solve

SETTINGS = OptimizerSettings()


def dead_reckoning(problem: Problem) -> FloatArray:
    return np.asarray(problem.poses)


def with_turns(problem: Problem, truth: FloatArray, gain: float) -> Problem:
    turns = tuple(
        TurnEdge(k, k + 1, gain * float(np.angle(np.exp(1j * (truth[k + 1, 2] - truth[k, 2])))), 0.002)
        for k in range(len(truth) - 1)
    )
    return replace(problem, turns=turns)


def solved(problem: Problem) -> Problem:
    found = solve(problem, SETTINGS)
    return replace(problem, poses=found.poses, calibration=found.calibration)


@pytest.mark.parametrize("gain", [1.0, 0.9])
def test_turns_by_sight_stay_where_they_help_and_go_where_they_bend(gain: float) -> None:
    made = ring(0, closures=60)
    problem = solved(with_turns(made.problem, made.truth, gain))
    contest = compete(problem, dead_reckoning(made.problem), (), SETTINGS)
    assert contest.kept == (FULL if gain == 1.0 else BLIND)
    assert contest.errors[contest.kept] == min(contest.errors.values()) or gain == 1.0
    assert contest.kept in contest.reason


def test_a_map_beats_dead_reckoning() -> None:
    made = ring(1, closures=60)
    contest = compete(solved(made.problem), dead_reckoning(made.problem), (), SETTINGS)
    assert contest.kept == FULL
    assert contest.errors[DEAD] > 2 * contest.errors[FULL]


def test_a_map_that_stood_before_has_no_dead_reckoning_for_a_rival() -> None:
    made = ring(1, closures=60)
    contest = compete(solved(made.problem), None, (), SETTINGS)
    assert contest.kept == FULL
    assert DEAD not in contest.errors
    bare = replace(made.problem, closures=Closures.of(()))
    assert compete(bare, dead_reckoning(made.problem), (), SETTINGS).kept == DEAD
    assert compete(bare, None, (), SETTINGS).kept == FULL


def test_closures_that_predict_nothing_leave_dead_reckoning() -> None:
    made = ring(2, closures=60)
    known = made.problem.closures
    near = made.problem.poses[known.j, :2] - made.problem.poses[known.i, :2]
    rng = np.random.default_rng(0)
    # what odometry has it, and now and then another way: a map made with these is bent where odometry is right
    relative = known.relative.copy()
    truth = dead_reckoning(made.problem)
    relative[:, 2] = np.angle(np.exp(1j * (truth[known.j, 2] - truth[known.i, 2])))
    c, s = np.cos(truth[known.i, 2]), np.sin(truth[known.i, 2])
    relative[:, 0], relative[:, 1] = c * near[:, 0] + s * near[:, 1], c * near[:, 1] - s * near[:, 0]
    relative[:, :2] += rng.normal(0.0, 0.3, (len(known), 2))
    bent = made.truth + np.column_stack([np.linspace(0, 30, len(made.truth)), np.zeros((len(made.truth), 2))])
    held = replace(
        made.problem, poses=bent,
        closures=Closures(known.i, known.j, relative, known.covariance, known.weight),
        turns=(), calibration=Calibration(), prior=Calibration(), prior_sigmas=(1e-6, 1e-6, 1e-6),
    )  # fmt: skip
    contest = compete(held, truth, (), SETTINGS)
    assert contest.errors[DEAD] <= contest.errors[FULL] + 0.5


def test_few_closures_compare_nothing() -> None:
    made = ring(3, closures=3)
    contest = compete(made.problem, dead_reckoning(made.problem), (), SETTINGS)
    assert contest.kept == FULL
    assert contest.errors == {}
    assert "too few" in contest.reason


@pytest.mark.parametrize(("sigma", "kept"), [(0.0005, FULL), (0.1, DEAD)])
def test_with_nothing_seen_again_only_turns_better_than_the_odometers_correct_it(sigma: float, kept: str) -> None:
    made = ring(4, closures=4)
    problem = with_turns(replace(made.problem, closures=made.problem.closures[:0]), made.truth, 1.0)
    problem = replace(problem, turns=tuple(replace(turn, sigma=sigma) for turn in problem.turns))
    assert compete(problem, dead_reckoning(made.problem), (), SETTINGS).kept == kept
    assert compete(problem, dead_reckoning(made.problem), problem.turns, SETTINGS).kept == FULL
