"""The door to gtsam: a pose graph with unknown odometry errors in, corrected poses out."""

from topomap.mapping.backend.problem import AxisEdge, ClosureEdge, Closures, OdometryEdge, Problem, Solution, TurnEdge
from topomap.mapping.backend.settings import BackendSettings
from topomap.mapping.backend.solver import Slices, solve, solving
from topomap.mapping.backend.window import Recent, solve_recent

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
