"""How well the robot came home, by its own word and by the truth."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.run_data import NodeData, RunData
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
    a drive that cuts corners between milestones can have a ratio below 1.
    """
    start, end = handover_step(run), goal(run)
    if run.truth is None or start is None or end is None:
        return None
    stamps = {node.node: node.stamp_ns for node in run.nodes}
    route = [stamps[node] for node in run.milestones if node in stamps and node != end.node] + [end.stamp_ns]
    return np.array([run.truth[start, :2], *(true_pose(run, stamp)[:2] for stamp in route)])


def home(run: RunData) -> HomeResult:
    """Return how the way home went."""
    if run.replayed:
        return HomeResult()
    if run.goal_node is None:
        return HomeResult(asked=False)
    error = _error(run)
    within = None if error is None else error <= REACHED_M
    # a way that didn't lead home has no ratio: the nearer the robot gave up, the better it would look
    came = run.claimed and within is not False
    ratio, shortest = (_path_ratio(run), _shortest_ratio(run)) if came else (None, None)
    return HomeResult(True, run.claimed, within, error, ratio, _collisions(run), shortest)


def _error(run: RunData) -> float | None:
    end = goal(run)
    if run.truth is None or end is None:
        return None
    gap = run.truth[-1, :2] - true_pose(run, end.stamp_ns)[:2]
    error = math.hypot(gap[0], gap[1])
    return error if math.isfinite(error) else None


def _path_ratio(run: RunData) -> float | None:
    route, start = reference_route(run), handover_step(run)
    if route is None or start is None or run.truth is None:
        return None
    shortest = float(travel(route)[-1])
    return float(travel(run.truth[start:])[-1]) / shortest if shortest > 0.0 else None


def _shortest_ratio(run: RunData) -> float | None:
    end, start = goal(run), handover_step(run)
    if run.truth is None or start is None or end is None or not np.isfinite(run.truth[:, :2]).all():
        return None
    places = run.truth[:, :2]
    shortest = shortest_way(run.plan, places, places[start], true_pose(run, end.stamp_ns)[:2])
    return float(travel(run.truth[start:])[-1]) / shortest if shortest else None


def _collisions(run: RunData) -> int | None:
    start = handover_step(run)
    if run.contact is None or start is None:
        return None
    return sum(first >= start for first, _ in runs_of(run.contact))
