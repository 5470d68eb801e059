"""A pose graph with doubtful closures, through the same stages as the robot's own: support, gate, growth, solve."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field
from scipy.special import chdtri

from topomap.geometry import FloatArray, compose
from topomap.mapping.backend import BackendSettings, Closures, OdometryEdge, Problem, Solution, solve
from topomap.mapping.backend.blocks import closure_chi2
from topomap.mapping.chain import Chain
from topomap.mapping.consistency import surprise
from topomap.mapping.odometry import Calibration, EdgeIncrements, Increments, IntArray, Preintegrated
from topomap.study.datasets.g2o import BoolArray, PoseGraph

HELD = (1e-6, 1e-6, 1e-6)  # a pose graph's odometry has no systematic error to find


def _growing() -> BackendSettings:
    return BackendSettings(cutoffs=(8.0, 3.4), iterations=1, tolerance=0.02)


def _closing() -> BackendSettings:
    return BackendSettings(cutoffs=(6.0, 3.4), iterations=8, tolerance=0.005)


class GraphSettings(BaseModel):
    """Stages and their limits; the same for every pose graph."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    window: float = Field(default=8.0, gt=0, description="way within which both ends of neighbours lie [m]")
    chance: float = Field(default=0.01, gt=0, lt=1, description="at most so probably neighbours agree by chance")
    tight: float = Field(default=3e-4, gt=0, lt=1, description="share of all claims that fit where a lone one may")
    gate: float = Field(default=0.999, gt=0.5, lt=1, description="share of true closures that odometry lets pass")
    pieces: int = Field(default=50, ge=1, description="nodes between two solves at least")
    solves: int = Field(default=20, ge=1, description="solves while growing at most")
    growing: BackendSettings = Field(default_factory=_growing, description="the solve every so often")
    closing: BackendSettings = Field(default_factory=_closing, description="the last solves")
    standing: float = Field(default=0.01, gt=0, lt=1, description="the same for a closure to stand at the end")
    lone: float = Field(default=2.5, ge=1, description="windows around a closure that must hold another at the end")
    rounds: int = Field(default=3, ge=1, description="how often the finished map hears all closures again")


class Mapped(NamedTuple):
    """Poses (N, 3) and which closures (M,) are believed."""

    poses: FloatArray
    believed: BoolArray


def map_graph(graph: PoseGraph, settings: GraphSettings | None = None) -> Mapped:
    """Map a pose graph whose closures may be false."""
    growth = Growth(graph, settings or GraphSettings())
    growth.grow()
    return growth.close()


class Growth:
    """The map of one pose graph as it grows."""

    def __init__(self, graph: PoseGraph, settings: GraphSettings) -> None:
        self._s, self._graph = settings, graph
        self._closures = Closures(graph.i, graph.j, graph.relative, graph.covariance, np.ones(len(graph.i)))
        self._edges = odometry_edges(graph)
        self._integrated = EdgeIncrements.of([e.increments for e in self._edges]).integrate(Calibration())
        self._poses = np.zeros((1, 3))
        self._active = np.zeros(0, np.int64)
        self._believed = np.zeros(0, np.int64)
        self._odometry = Chain.of(odometry_poses(graph), self._integrated, Calibration(), np.diag(np.square(HELD)))
        self._volume = _volume(self._odometry.poses)
        every = np.arange(len(graph.i))
        self._agreed = self._told(every, self._s.window, self._s.chance)
        self._waiting = every

    def _told(self, which: IntArray, window: float, chance: float) -> BoolArray:
        """Return which of some closures others agree with, more than chance would have it."""
        some = self._closures[which]
        found = surprise(some.relative, some.covariance, some.i, some.j, self._odometry, window, self._volume)
        return found[1] <= chance

    def grow(self) -> None:
        """Follow the chain, with a solve whenever new closures pass the gate."""
        nodes = self._graph.nodes
        piece = max(self._s.pieces, -(-nodes // self._s.solves))
        for last in [*range(piece, nodes, piece), nodes]:
            self._extend(last)
            new, self._waiting = self._split(last)
            passed = new[self._allowed(new)]
            if len(passed):
                self._active = np.concatenate([self._active, passed])
                self._take(self._active, self._solve(self._active, self._s.growing))

    def _extend(self, nodes: int) -> None:
        rows = [self._poses]
        pose = self._poses[-1]
        for step in self._graph.odometry[len(self._poses) - 1 : nodes - 1]:
            pose = compose(pose, step)
            rows.append(pose[None])
        self._poses = np.concatenate(rows)

    def _split(self, nodes: int) -> tuple[IntArray, IntArray]:
        inside = self._graph.j[self._waiting] < nodes
        return self._waiting[inside], self._waiting[~inside]

    def _allowed(self, new: IntArray) -> BoolArray:
        """Return which of the new closures odometry allows since the last node that a believed closure holds.

        One that nobody agrees with must also fit where little would: then its fit is evidence enough.
        """
        if not len(new):
            return np.zeros(0, bool)
        some = self._closures[new]
        held = np.concatenate([[0], self._closures.j[self._believed]])
        since = np.array([held[held <= j].max() for j in some.j.tolist()], np.int64)
        start = np.where(since > some.i, since, some.i)
        covariance = self._chain().covariance(start, some.j)
        limit = float(chdtri(3, 1 - self._s.gate))
        fits = closure_chi2(self._poses, some, covariance) <= limit
        ellipsoid = 4 / 3 * np.pi * limit**1.5 * np.sqrt(np.linalg.det(covariance + some.covariance))
        return np.asarray(fits & (self._agreed[new] | (ellipsoid <= self._s.tight * self._volume)))

    def _chain(self) -> Chain:
        edges = Preintegrated(*(part[: len(self._poses) - 1] for part in self._integrated))
        return Chain.of(self._poses, edges, Calibration(), np.diag(np.square(HELD)))

    def _solve(self, which: IntArray, settings: BackendSettings) -> Solution:
        edges = self._edges[: len(self._poses) - 1]
        return solve(Problem(self._poses, edges, self._closures[which], prior_sigmas=HELD), settings)

    def _take(self, which: IntArray, solution: Solution) -> None:
        self._poses = solution.poses
        self._believed = which[solution.closure_weights > 0]

    def close(self) -> Mapped:
        """Hear every closure again, nearer each time, until the believed stay the same."""
        for _ in range(self._s.rounds):
            near = self._near()
            before = self._believed
            if len(near):
                self._take(near, self._solve(near, self._s.closing))
            if np.array_equal(before, self._believed):
                break
        firm = self._believed[self._supported(self._believed)]
        if len(self._believed) < len(self._graph.i) and len(firm) < len(self._believed):
            self._take(firm, self._solve(firm, self._s.closing))
        return Mapped(self._poses, np.isin(np.arange(len(self._graph.i)), self._believed))

    def _supported(self, believed: IntArray) -> BoolArray:
        """Return which of the believed closures others support: one that fits alone may fit by chance."""
        return self._told(believed, self._s.lone * self._s.window, self._s.standing)

    def _near(self) -> IntArray:
        """Return the closures that the map allows within twice the last cutoff."""
        nothing = np.zeros((len(self._closures), 3, 3))
        chi2 = closure_chi2(self._poses, self._closures, nothing)
        return np.flatnonzero(chi2 <= (2 * self._s.closing.cutoff) ** 2)


def odometry_edges(graph: PoseGraph) -> tuple[OdometryEdge, ...]:
    """Return the graph's odometry as increments, one an edge, laid as an arc."""
    half = graph.odometry[:, 2] / 2
    c, s = np.cos(half), np.sin(half)
    x, y = graph.odometry[:, 0], graph.odometry[:, 1]
    deltas = np.column_stack([c * x + s * y, c * y - s * x, graph.odometry[:, 2]])
    carry = np.zeros((len(half), 3, 3))  # what the arc does to the increment's noise, undone below
    carry[:, 0, 0], carry[:, 0, 1], carry[:, 1, 0], carry[:, 1, 1], carry[:, 2, 2] = c, -s, s, c, 1.0
    carry[:, 0, 2], carry[:, 1, 2] = -y / 2, x / 2
    undo = np.linalg.inv(carry)
    covariances = undo @ graph.odometry_covariance @ undo.transpose(0, 2, 1)
    rows = zip(deltas, covariances, strict=True)
    return tuple(
        OdometryEdge(k, k + 1, Increments(np.array([k + 1]), d[None], q[None])) for k, (d, q) in enumerate(rows)
    )


def _volume(poses: FloatArray) -> float:
    """Return the area of the drive [m^2] times all headings [rad]."""
    width, height = np.maximum(np.ptp(poses[:, :2], axis=0), 1.0)
    return float(width * height * 2 * np.pi)


def odometry_poses(graph: PoseGraph) -> FloatArray:
    """Return the poses (N, 3) by odometry alone."""
    poses = [np.zeros(3)]
    for step in graph.odometry:
        poses.append(compose(poses[-1], step))
    return np.array(poses)
