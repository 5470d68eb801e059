"""Maps of several drives judged by the truth: what is closed and what is false, and how far a map grows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.evidence import FALSE_DISTANCE, FALSE_ROTATION
from topomap.core.geometry import wrap
from topomap.evaluation.closures import PASS_MARGIN_M, PASS_RADIUS_M, PASS_TRAVEL_M
from topomap.evaluation.trajectory import ate
from topomap.mapping.graph import TopoMap

Truths = Mapping[int, tuple[float, float, float]]
"""True poses x, y [m], heading [rad] by node number."""


@dataclass(frozen=True, slots=True)
class MapFigures:
    """A map held against the truth: nodes, closures and false ones, places seen again and the share of them that is
    closed (NaN where none is), ATE [m] of its nodes after SE(2) alignment."""

    nodes: int
    closures: int
    false: int
    possible: int
    recall: float
    ate: float


@dataclass(frozen=True, slots=True)
class Merging:
    """One world and seed: a long drive, and two that overlap by half, merged."""

    world: str
    seed: int
    settings: tuple[str, ...]
    long: MapFigures
    merged: MapFigures


@dataclass(frozen=True, slots=True)
class Growth:
    """One world and seed: nodes and bytes of the pruned map after the lesson and after each lap more, and the last
    map's figures."""

    world: str
    seed: int
    settings: tuple[str, ...]
    nodes: tuple[int, ...]
    sizes: tuple[int, ...]
    last: MapFigures

    @property
    def by_nodes(self) -> float:
        """Growth a lap, mean, as a share of what there was after the lesson."""
        return _each(self.nodes)

    @property
    def by_size(self) -> float:
        """The same of the file."""
        return _each(self.sizes)


def _each(sizes: tuple[int, ...]) -> float:
    return (sizes[-1] / sizes[0] - 1.0) / max(len(sizes) - 1, 1)


def figures(topo: TopoMap, truths: Truths) -> MapFigures:
    """Return a map's figures; truths: true poses by node number, of all its nodes.

    A snapshot is a place seen again where an older one, PASS_TRAVEL_M of way before or of another drive, was truly
    taken within PASS_RADIUS_M of it; it is closed by a true closure that ends within PASS_MARGIN_M of way of it.
    """
    true = np.array([truths[name] for name in topo.names])
    travel = np.array([node.travel for node in topo.nodes])
    false = np.array([_is_false(topo, true, k) for k in range(len(topo.closures))], dtype=np.bool_)
    again = _seen_again(topo, true, travel)
    ends = np.array([travel[max(c.i, c.j)] for c, wrong in zip(topo.closures, false, strict=True) if not wrong])
    closed = [bool(len(ends)) and float(np.abs(ends - travel[k]).min()) <= PASS_MARGIN_M for k in again]
    recall = sum(closed) / len(closed) if closed else math.nan
    error = ate(topo.poses, true)
    return MapFigures(len(topo.nodes), len(topo.closures), int(false.sum()), len(again), recall, error)


def _is_false(topo: TopoMap, true: FloatArray, number: int) -> bool:
    edge = topo.closures[number]
    apart = math.dist(true[edge.i, :2], true[edge.j, :2])
    turned = wrap(edge.relative.heading - float(true[edge.j, 2] - true[edge.i, 2]))
    return apart > FALSE_DISTANCE or abs(turned) > FALSE_ROTATION


def _seen_again(topo: TopoMap, true: FloatArray, travel: FloatArray) -> list[int]:
    views: BoolArray = np.array([node.snapshot is not None for node in topo.nodes])
    found = []
    for k in np.flatnonzero(views).tolist():
        older = views & (travel <= travel[k] - PASS_TRAVEL_M)
        near = np.hypot(*(true[older, :2] - true[k, :2]).T) <= PASS_RADIUS_M
        if near.any():
            found.append(k)
    return found


MERGE_HEAD = (
    "world", "seed", "settings", "nodes, long", "nodes, merged", "closures, long", "closures, merged", "false, long",
    "false, merged", "recall, long", "recall, merged", "ATE long [m]", "ATE merged [m]",
)  # fmt: skip
GROWTH_HEAD = ("world", "seed", "settings", "laps", "nodes", "kB", "nodes a lap", "bytes a lap", "closures", "false",
               "recall", "ATE [m]")  # fmt: skip


def merge_row(one: Merging) -> tuple[str, ...]:
    """Return a row under MERGE_HEAD."""
    both = (one.long, one.merged)
    return (
        one.world, f"{one.seed}", " ".join(one.settings), *(f"{m.nodes}" for m in both),
        *(f"{m.closures}" for m in both), *(f"{m.false}" for m in both), *(f"{m.recall:.3f}" for m in both),
        *(f"{m.ate:.3f}" for m in both),
    )  # fmt: skip


def growth_row(one: Growth) -> tuple[str, ...]:
    """Return a row under GROWTH_HEAD."""
    last = one.last
    return (
        one.world, f"{one.seed}", " ".join(one.settings), f"{len(one.nodes) - 1}",
        f"{one.nodes[0]} to {one.nodes[-1]}", f"{one.sizes[0] / 1000:.0f} to {one.sizes[-1] / 1000:.0f}",
        f"{100 * one.by_nodes:+.2f} %", f"{100 * one.by_size:+.2f} %", f"{last.closures}", f"{last.false}",
        f"{last.recall:.3f}", f"{last.ate:.3f}",
    )  # fmt: skip
