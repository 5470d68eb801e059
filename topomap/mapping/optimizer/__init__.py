"""The door to gtsam: a pose graph with unknown odometry errors in, corrected poses out."""

from topomap.mapping.optimizer.held_solver import HeldSolver
from topomap.mapping.optimizer.objective import geman_mcclure
from topomap.mapping.optimizer.problem import (
    AxisEdge,
    ClosureEdge,
    Closures,
    OdometryEdge,
    OdometryEdges,
    Problem,
    Solution,
    TurnEdge,
)
from topomap.mapping.optimizer.relative_edges import RelativeEdges, relative_edges
from topomap.mapping.optimizer.settings import OptimizerSettings
from topomap.mapping.optimizer.slices import Slices
from topomap.mapping.optimizer.solver import solve, solving
from topomap.mapping.optimizer.window import Recent, solving_recent

__all__ = [
    "AxisEdge",
    "ClosureEdge",
    "Closures",
    "HeldSolver",
    "OdometryEdge",
    "OdometryEdges",
    "OptimizerSettings",
    "Problem",
    "Recent",
    "RelativeEdges",
    "Slices",
    "Solution",
    "TurnEdge",
    "geman_mcclure",
    "relative_edges",
    "solve",
    "solving",
    "solving_recent",
]
