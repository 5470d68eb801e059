"""Stationary points (H24): the direction of a small movement from the horizontal flow along the horizon."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.geometry import TAU
from topomap.vision.image.compare import parabola
from topomap.vision.matching.difference_kernels import block_differences


@dataclass(frozen=True, slots=True)
class Flow:
    """The flow fitted by a sin t + b cos t + c: direction [rad] of the movement goal -> current in the
    aligned frame (the diffusion point; the convergence point lies opposite), strength [rad], turn c [rad],
    the compass's error.
    """

    direction: float
    strength: float
    turn: float


@dataclass(frozen=True, slots=True)
class FlowSpec:
    """How flow is measured: reach [rad] of the search, half [rad] the half window, rounds of re-weighting."""

    reach: float = math.radians(40.0)
    half: float = math.radians(12.0)
    rounds: int = 8


FLOW = FlowSpec()


def fitted_flow(current: Float32Array, goal: Float32Array, spec: FlowSpec) -> Flow:
    """Return the flow between two aligned rings (F, C) (METHODS H24: step direction atan2(-b, a))."""
    flow, weight = measured_flow(current, goal, spec)
    angles = np.arange(len(flow)) * (TAU / len(flow))
    design = np.column_stack([np.sin(angles), np.cos(angles), np.ones(len(flow))])
    fit: FloatArray = np.zeros(3)
    scale = math.radians(20.0)
    robust: FloatArray = np.ones(len(flow), np.float64)
    for _ in range(spec.rounds):
        w = weight * robust
        normal = design.T @ (design * w[:, np.newaxis]) + 1e-9 * np.eye(3)
        fit = np.asarray(np.linalg.solve(normal, design.T @ (w * flow)), np.float64)
        scale = max(0.7 * scale, math.radians(3.0))
        robust = _trust(flow - design @ fit, scale)
    return Flow(math.atan2(-fit[1], fit[0]), math.hypot(fit[0], fit[1]), float(fit[2]))


def _trust(residual: FloatArray, scale: float) -> FloatArray:
    """Geman-McClure's weight: what doesn't fit hardly counts."""
    weight: FloatArray = 1.0 / np.square(1.0 + np.square(residual / scale))
    return weight


def measured_flow(current: Float32Array, goal: Float32Array, spec: FlowSpec) -> tuple[FloatArray, FloatArray]:
    """Return how far each goal column has moved in the current ring [rad] and how sure that is, (C,)."""
    columns = goal.shape[1]
    step = TAU / columns
    reach, half = max(round(spec.reach / step), 1), max(round(spec.half / step), 1)
    cost = block_differences(goal, current, reach, half).astype(np.float64)
    rows = np.arange(columns)
    inner = cost[:, 1:-1].argmin(axis=1) + 1
    offset, low = parabola(cost[rows, inner - 1], cost[rows, inner], cost[rows, inner + 1])
    weight = 1.0 - low / np.maximum(cost.mean(axis=1), 1e-9)
    return (inner + offset - reach) * step, np.square(np.maximum(weight, 0.0))
