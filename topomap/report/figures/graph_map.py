"""A pose graph as a picture: dead reckoning, the optimised route, accepted and refused closures."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from topomap.core.arrays import FloatArray, IntArray
from topomap.mapping.graph_engine import GraphVerdicts
from topomap.mapping.pose_graph import PoseGraph
from topomap.report.figures import style

MOST = 4000  # closures of one verdict that are drawn: more only blacken the paper


def graph_map(graph: PoseGraph, verdicts: GraphVerdicts) -> Figure:
    """Return the routes side by side in one scale: dead reckoning with what was refused, the map with what stands."""
    reckoned = graph.dead_reckoning()
    figure = style.canvas(12.0, 6.2)
    left, right = figure.subplots(1, 2)
    style.dress(left, "Dead reckoning and refused closures", "x [m]", "y [m]")
    style.dress(right, "Optimised route and accepted closures", "x [m]", "y [m]")
    _closures(left, graph, reckoned, np.flatnonzero(~verdicts.inlier), style.PURPLE, "refused")
    _route(left, graph, reckoned, style.DEAD_RECKONING)
    _closures(right, graph, verdicts.poses, np.flatnonzero(verdicts.inlier), style.GREEN, "accepted")
    _route(right, graph, verdicts.poses, style.MAP)
    for axes in (left, right):
        axes.set_aspect("equal", adjustable="datalim")
        axes.legend(fontsize=9, frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.09), ncols=3)
    return figure


def _route(axes: Axes, graph: PoseGraph, poses: FloatArray, look: style.Line) -> None:
    """Draw a route; where odometry is missing, the line is, too."""
    places = np.insert(poses[:, :2], np.flatnonzero(graph.gaps) + 1, np.nan, axis=0)
    style.line(axes, places[:, 0], places[:, 1], look)
    axes.plot(*poses[0, :2], "s", color=look.color, markersize=6, label="first pose")


def _closures(axes: Axes, graph: PoseGraph, poses: FloatArray, which: IntArray, colour: str, word: str) -> None:
    """Draw closures as lines between the poses they join; those of a pose's own place as the points that they are."""
    drawn = which[np.linspace(0, len(which) - 1, min(len(which), MOST)).astype(np.int64)] if len(which) else which
    ends = np.stack([poses[graph.i[drawn], :2], poses[graph.j[drawn], :2]], axis=1)
    some = f"{len(drawn)} drawn of " if len(drawn) < len(which) else ""
    label = f"{some}{len(which)} {word}"
    strength = float(np.clip(40 / max(len(drawn), 1), 0.12, 0.7))
    axes.add_collection(LineCollection(list(ends), colors=colour, linewidths=0.9, alpha=strength))
    middle = ends.mean(axis=1)
    axes.plot(
        middle[:, 0], middle[:, 1], ".", color=colour, markersize=style.size_for(len(drawn), 5.0), label=label, zorder=4
    )
    axes.autoscale_view()
