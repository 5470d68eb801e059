"""How the closures' weights go from wide to narrow."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from topomap.core.arrays import FloatArray
from topomap.mapping.optimizer.objective import Objective, geman_mcclure
from topomap.mapping.optimizer.problem import UNKNOWN_HEADING
from topomap.mapping.optimizer.residuals import closure_chi2
from topomap.mapping.optimizer.settings import OptimizerSettings
from topomap.mapping.uncertainty.agreement import Agreeing, support

Weighing = Iterable[Callable[[FloatArray], FloatArray]]
SUPPORTED_STEPS = 3  # Gauss-Newton steps with the supported closures alone


class Schedule:
    """Weights of the closures by stage, as functions of the poses (N, 3).

    A closure is measured in the sum of its covariance and what odometry may be off along the way between its ends,
    and that allowance shrinks: a true closure of a long loop may begin far off, a false one of a short path mayn't.
    """

    def __init__(self, graph: Objective, settings: OptimizerSettings) -> None:
        self._closures = graph.problem.closures
        self._settings = settings
        self._chain, position = graph.chain()
        self._i, self._j = position[self._closures.i], position[self._closures.j]
        self._allowance = self._chain.covariance(self._i, self._j)

    def narrowing(self) -> Weighing:
        """Narrow the settings' cutoffs whatever odometry allows: for a start that is nearly right."""
        nothing = np.zeros_like(self._allowance)
        return [self._cut(nothing, cutoff) for cutoff in self._settings.cutoffs]

    def __len__(self) -> int:
        return self._settings.stages

    def allowed(self) -> Weighing:
        """Begin with all that odometry allows."""
        return [self._stage(stage) for stage in range(len(self))]

    def supported(self) -> Weighing | None:
        """Begin with those closures that neighbours agree with, or None if there are no such."""
        agreed = self.agreement(np.ones(len(self._closures), bool))
        if not bool((agreed > 0).any()):
            return None
        firm = (agreed > 0).astype(float)
        return [lambda _: firm] * SUPPORTED_STEPS + [self._stage(k) for k in range(SUPPORTED_STEPS, len(self))]

    def agreement(self, among: NDArray[np.bool_]) -> FloatArray:
        """Return the support that some closures (M,) give one another, in their order."""
        blind = self._closures.covariance[:, 2, 2] > UNKNOWN_HEADING
        some = self._closures[among]
        claims = Agreeing(self._i[among], self._j[among], some.relative, blind[among], some.weight)
        return support(claims, self._chain.poses, self._chain.travelled, self._settings.support)

    def _stage(self, stage: int) -> Callable[[FloatArray], FloatArray]:
        return self._cut(self._allowance * self._settings.shrink ** (-2 * stage), self._settings.cutoff)

    def _cut(self, allowance: FloatArray, cutoff: float) -> Callable[[FloatArray], FloatArray]:
        def weigh(poses: FloatArray) -> FloatArray:
            chi2 = closure_chi2(poses, self._closures, allowance)
            return np.asarray(geman_mcclure(chi2, cutoff))

        return weigh
