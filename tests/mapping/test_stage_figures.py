"""The back end and the closure engine on made-up drives: the same figures as before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from chains import UNSURE, walk
from graphs import ring_graph
from kept import Figures, as_before
from lapped import LAP, Lapped, lapped
from ring import Ring, blinded, edges_of, ring

from topomap.core.geometry import between
from topomap.mapping.competition import compete
from topomap.mapping.graph_engine import optimise_graph
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.optimizer import (
    AxisEdge,
    OptimizerSettings,
    Problem,
    Solution,
    TurnEdge,
    solve,
    solving_recent,
)
from topomap.mapping.optimizer.slices import drained
from topomap.mapping.uncertainty.network import PathNetwork

SETTINGS = OptimizerSettings()


def figures(found: Solution) -> Figures:
    return {
        "poses": found.poses[::10],
        "calibration": found.calibration.vector(),
        "covariance": found.calibration_covariance * 1e4,
        "weights": found.closure_weights,
        "errors": [found.error_before, found.error_after],
        "iterations": [found.iterations, found.improved],
    }


def turns(made: Ring) -> tuple[TurnEdge, ...]:
    seen = between(made.truth[:-1], made.truth[1:])[:, 2]
    return tuple(TurnEdge(k, k + 1, float(turn) + 0.003 * (-1) ** k, 0.01) for k, turn in enumerate(seen))


def problems() -> dict[str, Problem]:
    plain, false, back = ring(3), ring(4, false=0.3), ring(5, nodes=120, length=120.0, closures=20, back=True)
    axes = tuple(AxisEdge(k, k + 1, 0.05) for k in range(0, 118, 3))
    mixed = false.problem.closures.covariance.copy()
    mixed[::3, 2, 2] = 40.0
    return {
        "plain": plain.problem,
        "false": false.problem,
        "back, turns": replace(back.problem, turns=turns(back)),
        "back, axes": replace(back.problem, axes=axes),
        "blind": blinded(plain.problem),
        "some blind": replace(false.problem, closures=replace(false.problem.closures, covariance=mixed)),
    }


@pytest.mark.parametrize("name", problems())
def test_solutions_are_as_before(name: str) -> None:
    as_before(f"solve {name}", figures(solve(problems()[name], SETTINGS)))


def test_a_solution_of_the_newest_stretch_is_as_before() -> None:
    problem = ring(6, nodes=120, length=120.0, closures=20).problem
    edges = edges_of(problem)[-50:]
    new = problem.closures[problem.closures.j > edges[0].i]
    seen = turns(ring(6, nodes=120, length=120.0))[-50:]
    found = drained(solving_recent(problem.poses, edges, new, seen, Calibration(), SETTINGS))
    as_before("solve recent", {"nodes": found.nodes, "heard": found.heard, **figures(found.solution)})


def test_a_contest_is_as_before() -> None:
    made = ring(0, closures=60)
    problem = replace(made.problem, turns=turns(made))
    found = compete(problem, made.problem.poses, problem.turns[::4], SETTINGS)
    as_before("compete", {"errors": list(found.errors.values()), "names": list(found.errors), "kept": [found.reason]})


def graphs() -> dict[str, Lapped]:
    plain = lapped(laps=3, every=5, seed=2)
    covariance = plain.graph.covariance.copy()
    covariance[::4, 2, 2] = 40.0
    return {
        "mixed": lapped(seed=0).groups(4, 5, 3).alone(40, 4),
        "place-like": plain.alone(30, 5).groups(2, 3, 6, literal=True),
        "some blind": replace(plain, graph=replace(plain.graph, covariance=covariance)).alone(10, 7),
        "poor odometry": lapped(laps=2, every=3, seed=8, step=np.array([0.1, 0.1, 0.04])).alone(10, 9),
    }


@pytest.mark.parametrize("name", graphs())
def test_verdicts_on_graphs_are_as_before(name: str) -> None:
    found = optimise_graph(graphs()[name].graph)
    odds = np.clip(found.log_odds, -1e3, 1e3)
    as_before(
        f"graph {name}",
        {"poses": found.poses[::20], "stands": found.inlier, "odds": odds, "why": found.reason, "kept": [found.kept]},
    )


def test_verdicts_on_a_ring_with_gaps_are_as_before() -> None:
    found = optimise_graph(ring_graph(3, 12, 5).without((60, 100)).graph)
    odds = np.clip(found.log_odds, -1e3, 1e3)
    as_before("graph with gaps", {"poses": found.poses[::9], "odds": odds, "why": found.reason, "kept": [found.kept]})


def test_paths_are_as_before() -> None:
    rng, chain = np.random.default_rng(0), walk(2 * LAP, 4, UNSURE)
    ends = np.sort(rng.integers(0, 2 * LAP, (2, 30)), axis=0)
    covariance = np.tile(np.diag([0.1, 0.2, 0.03]) ** 2, (30, 1, 1))
    network = PathNetwork(chain, *np.ascontiguousarray(ends), covariance, np.arange(30) % 4)
    i, j = rng.integers(0, 2 * LAP, (2, 40))
    as_before(
        "paths",
        {
            "chain": chain.covariance(i, j),
            "errors": network.errors(i, j),
            "without": network.errors(i, j, np.arange(40) % 4),
            "bounds": network.upper_bounds(i, j),
        },
    )
