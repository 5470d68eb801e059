"""How well the robot came home, or to each goal of a patrol, by its own word and by the truth."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.run_data import Leg, NodeData, RunData
from topomap.evaluation.closures import runs_of
from topomap.evaluation.shortest import shortest_way
from topomap.evaluation.trajectory import travel, true_pose

REACHED_M = 0.3


@dataclass(frozen=True, slots=True)
class HomeResult:
    """The way home; None where it doesn't apply or the truth is missing.

    claimed: the robot said it arrived; within: the last true position lies within 0.3 m of where the goal
    node was truly taken; error: that distance [m]; path_ratio: true path after hand-over over
    `reference_route`, shortest_ratio: over the shortest way on the true plan, both None for a way that didn't lead
    home; collisions: contact episodes (contiguous steps in
    contact) that begin after hand-over.
    A replay is open loop: all None.
    """

    asked: bool | None = None
    claimed: bool | None = None
    within: bool | None = None
    error: float | None = None
    path_ratio: float | None = None
    collisions: int | None = None
    shortest_ratio: float | None = None


def handover_step(run: RunData) -> int | None:
    """Return the first step after which nobody but the stack has the wheels until the end; None if there is
    none."""
    if run.driven is None or not len(run.driven) or run.driven[-1]:
        return None
    held = np.flatnonzero(run.driven)
    return int(held[-1]) + 1 if len(held) else 0


def goal(run: RunData) -> NodeData | None:
    """Return the node that the robot was sent to, None without one."""
    return next((node for node in run.nodes if node.node == run.goal_node), None)


def reference_route(run: RunData) -> FloatArray | None:
    """Return the polyline (K, 2) [m] against which the way home is measured, in the truth's frame.

    From the true position at hand-over over the true positions of the planned milestones to that of the goal
    node; without milestones straight to the goal. The plan's own detours are thus no fault of the drive, and
    a drive that cuts corners between milestones can have a ratio below 1. On a patrol it leads over all goals.
    """
    start = handover_step(run)
    if run.goal_node is None or start is None:
        return None
    return _reference(run, Leg(run.goal_node, start, len(run.stamps_ns) - 1, run.claimed, run.milestones))


def _reference(run: RunData, leg: Leg) -> FloatArray | None:
    stamps = {node.node: node.stamp_ns for node in run.nodes}
    if run.truth is None or leg.goal not in stamps:
        return None
    nodes = [node for node in leg.milestones if node in stamps and node != leg.goal] + [leg.goal]
    return np.array([run.truth[leg.first, :2], *(true_pose(run, stamps[node])[:2] for node in nodes)])


@dataclass(frozen=True, slots=True)
class LegResult:
    """One leg of a mission; None where it doesn't apply or the truth is missing.

    claimed: the robot said it arrived, None where it was cut off; within, error [m], collisions: as in `HomeResult`, at
    the leg's last step; way [m]: driven; ratio: way over that by the planned milestones, None for a leg that didn't
    lead to its goal.
    """

    goal: int
    claimed: bool | None
    within: bool | None
    error: float | None
    way: float | None
    ratio: float | None
    collisions: int | None


def legs(run: RunData) -> list[LegResult]:
    """Return how each leg went, in their order; none of a replay, which can't change the drive."""
    return [] if run.replayed else [_judged(run, leg) for leg in run.legs]


def _judged(run: RunData, leg: Leg) -> LegResult:
    error = _error(run, leg)
    within = None if error is None else error <= REACHED_M
    way = None if run.truth is None else _way(run.truth, leg)
    came = leg.claimed is True and within is not False
    ratio = _ratio(run, leg) if came else None
    return LegResult(leg.goal, leg.claimed, within, error, way, ratio, _collisions(run, leg))


def home(run: RunData) -> HomeResult:
    """Return how the way home went; of a patrol, how its last leg went."""
    if run.replayed:
        return HomeResult()
    if run.goal_node is None:
        return HomeResult(asked=False)
    last = len(run.stamps_ns) - 1
    error = _error(run, Leg(run.goal_node, last, last, run.claimed))
    within = None if error is None else error <= REACHED_M
    start = handover_step(run)
    if start is None:
        return HomeResult(True, run.claimed, within, error)
    patrol = len(run.legs) > 1
    way = run.legs[-1] if patrol else Leg(run.goal_node, start, last, run.claimed, run.milestones)
    # a way that didn't lead home has no ratio: the nearer the robot gave up, the better it would look
    came = run.claimed and within is not False
    ratio, shortest = (_ratio(run, way), _shortest_ratio(run, way)) if came else (None, None)
    return HomeResult(True, run.claimed, within, error, ratio, _collisions(run, way), shortest)


def _error(run: RunData, leg: Leg) -> float | None:
    stamp = next((node.stamp_ns for node in run.nodes if node.node == leg.goal), None)
    if run.truth is None or stamp is None:
        return None
    gap = run.truth[leg.last, :2] - true_pose(run, stamp)[:2]
    error = math.hypot(gap[0], gap[1])
    return error if math.isfinite(error) else None


def _way(truth: FloatArray, leg: Leg) -> float:
    return float(travel(truth[leg.first : leg.last + 1])[-1])


def _ratio(run: RunData, leg: Leg) -> float | None:
    route = _reference(run, leg)
    if route is None or run.truth is None:
        return None
    planned = float(travel(route)[-1])
    return _way(run.truth, leg) / planned if planned > 0.0 else None


def _shortest_ratio(run: RunData, leg: Leg) -> float | None:
    route = _reference(run, leg)
    if run.truth is None or route is None or not np.isfinite(np.concatenate([run.truth[:, :2], route])).all():
        return None  # of nodes that another drive kept the truth may be unknown
    shortest = shortest_way(run.plan, run.truth[:, :2], route[0], route[-1])
    return _way(run.truth, leg) / shortest if shortest else None


def _collisions(run: RunData, leg: Leg) -> int | None:
    if run.contact is None:
        return None
    return sum(leg.first <= first <= leg.last for first, _ in runs_of(run.contact))
