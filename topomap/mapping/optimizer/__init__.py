"""The door to gtsam: a pose graph with unknown odometry errors in, corrected poses out."""

from topomap.mapping.optimizer.problem import AxisEdge, ClosureEdge, Closures, OdometryEdge, Problem, Solution, TurnEdge
from topomap.mapping.optimizer.settings import BackendSettings
from topomap.mapping.optimizer.solver import Slices, solve, solving
from topomap.mapping.optimizer.window import Recent, solve_recent

__all__ = [
    "AxisEdge",
    "BackendSettings",
    "ClosureEdge",
    "Closures",
    "OdometryEdge",
    "Problem",
    "Recent",
    "Slices",
    "Solution",
    "TurnEdge",
    "solve",
    "solve_recent",
    "solving",
]
