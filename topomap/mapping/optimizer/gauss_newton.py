"""One Gauss-Newton step of poses and calibration: the linear system at a state, eliminated by gtsam, a slice a time."""

from __future__ import annotations

import gtsam
import numpy as np

from topomap.core.arrays import FloatArray
from topomap.mapping.optimizer.calibration_jacobian import with_calibration
from topomap.mapping.optimizer.elimination import Condensed, condense
from topomap.mapping.optimizer.linear_system import LinearSystem
from topomap.mapping.optimizer.objective import Linearised, Objective, State, geman_mcclure
from topomap.mapping.optimizer.residuals import Residuals
from topomap.mapping.optimizer.slices import Slices, drained

WEIGHTLESS = 1e-6  # a closure with less weight is left out of the system
LARGE = 500  # nodes from which on a step is more than fits into a robot's: 40 ms at 2,400
LARGEST_STEP = np.array([0.1, 0.02, 0.1])  # of the calibration: keeps the linearisation honest


class GaussNewton:
    """Steps from state to state of a graph; what a large one's takes is done in slices."""

    def __init__(self, graph: Objective) -> None:
        self.graph = graph
        self._ordered: tuple[bytes, gtsam.Ordering] | None = None  # the last system's closures and order

    def system(self, at: Linearised, weights: FloatArray) -> LinearSystem:
        """Return the linear system with closure weights (M,), in poses that the calibration carries along; eliminated.

        Raises TopomapError for one that isn't determined.
        """
        return drained(self.building(at, weights))

    def building(self, at: Linearised, weights: FloatArray) -> Slices[LinearSystem]:
        """Do what `system` does; of a large graph in slices."""
        used = weights > WEIGHTLESS
        closures = with_calibration(at.closures.among(used), at.calibration_jacobian)
        inside, across = [], []
        for blocks, on_edge, cutoff in (
            (at.turns, self.graph.turn_on_edge, self.graph.turn_cutoffs),
            (at.axes, self.graph.axis_on_edge, self.graph.axis_cutoff),
        ):
            faded = with_calibration(blocks, at.calibration_jacobian).weighted(geman_mcclure(blocks.chi2(), cutoff))
            inside.append(faded.among(on_edge))
            across.append(faded.among(~on_edge))
        condensed = self._condensed(at.odometry, inside, [*across, closures])
        yield from self.pause()
        system = LinearSystem(len(self.graph.problem.poses), self.graph.problem.anchor, condensed)
        yield from self.pause()
        system.add_calibration_prior(at.prior, self.graph.sigmas)
        for blocks in across:
            system.add(blocks)
        system.add(closures.weighted(weights[used]))
        yield from self.pause()
        yield from self._eliminating(system, used.tobytes())
        return system

    def _eliminating(self, system: LinearSystem, used: bytes) -> Slices[None]:
        """Eliminate a system's poses; with the same closures as in the last one, in the same order."""
        known = self._ordered[1] if self._ordered is not None and self._ordered[0] == used else None
        self._ordered = used, system.order(known)
        if known is None:
            yield from self.pause()
        system.eliminated()

    def pause(self) -> Slices[None]:
        """End a slice where the graph is large."""
        if len(self.graph.problem.poses) > LARGE:
            yield

    def _condensed(self, odometry: Residuals, inside: list[Residuals], across: list[Residuals]) -> Condensed | None:
        """Return the chain without the nodes that only its own edges touch; the anchor stays."""
        if not len(self.graph.pairs):
            return None
        seen = np.zeros(len(self.graph.problem.poses), bool)
        seen[self.graph.problem.anchor] = True
        for blocks in across:
            seen[blocks.i] = seen[blocks.j] = True
        return condense(self.graph.order, odometry, inside, seen[self.graph.order])

    def step(self, state: State, at: Linearised, weights: FloatArray) -> tuple[State, Linearised, float]:
        """Return the state after a Gauss-Newton step, halved while that is worse, and its largest move."""
        return drained(self.stepping(state, at, weights))

    def stepping(self, state: State, at: Linearised, weights: FloatArray) -> Slices[tuple[State, Linearised, float]]:
        """Do what `step` does; of a large graph in slices."""
        system = yield from self.building(at, weights)
        yield from self.pause()
        own, calibration = system.solve()
        yield from self.pause()
        poses = own + at.calibration_jacobian @ calibration
        before = self.graph.error(at, weights)
        longest = 1.0 / max(1.0, float((np.abs(calibration) / LARGEST_STEP).max()))
        for halvings in range(5):
            length = longest * 0.5**halvings
            moved = state.stepped(poses, calibration, length)
            there = self.graph.linearise(moved)
            if self.graph.error(there, weights) <= before * (1 + 1e-9) + 1e-9:
                return moved, there, float(np.abs(poses).max()) * length
            yield from self.pause()
        return state, at, 0.0
