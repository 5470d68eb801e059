"""Studies on where moments converge: points by order, potential, lengths of vectors (chapter 3)."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes

from topomap.bench.homing.contestant import view_at
from topomap.bench.homing.figures import draw_plan
from topomap.core.arrays import FloatArray
from topomap.experiments.study import Curve, Finding, Lab, away_from_home, curves_finding
from topomap.report.figures import style
from topomap.vision.arena import Arena, Point
from topomap.vision.contracts import HomingMethod
from topomap.vision.homing.area_centroid import AreaCentroid
from topomap.vision.homing.convergence_point import ConvergencePoint
from topomap.vision.homing.moment import Moment
from topomap.vision.homing.view_vector import ViewVector
from topomap.vision.image.distances import distances
from topomap.vision.matching.moment_potential import convergence_point, points

ROOM = "ourlab"
LABELLED = (1.0, 2.0, 4.0, 10.0)
"""Orders whose points are named beside the farther place; from home they lie too close together."""
AROUND = 0.25
"""What is shown around the points [m]."""


def convergence(lab: Lab) -> Finding:
    """Where the convergence point lies for orders 1 to 10, from two places (3.4)."""
    orders = [1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0]
    arena = lab.recipes(ROOM)[0].arena()
    other = _elsewhere(arena)
    figure = style.canvas(6.4, 5.6)
    axes = figure.add_subplot()
    style.dress(axes, f"Convergence points by order, {arena.name}", "x [m]", "y [m]")
    draw_plan(axes, arena.plan)
    found: dict[str, list[list[float]]] = {}
    for place, colour in ((arena.home, style.BLUE), (other, style.RED)):
        landmarks = points(distances(view_at(arena.source, place), "range").metres)
        path = np.array([convergence_point(landmarks, np.ones(len(landmarks)), n) for n in orders]) + place
        axes.plot(path[:, 0], path[:, 1], "o-", color=colour, markersize=4, linewidth=1.0)
        axes.plot(*place, "*", color=colour, markersize=11, markeredgecolor="black", label=f"seen from {_said(place)}")
        found[_said(place)] = path.round(5).tolist()
    for n in LABELLED:
        x, y = found[_said(other)][orders.index(n)]
        axes.annotate(f"n={n:g}", (x, y), xytext=(5, -11), textcoords="offset points",
                      fontsize=8, color=style.RED)  # fmt: skip
    every = np.concatenate([found[_said(place)] for place in (arena.home, other)])
    low, high = every.min(axis=0) - AROUND, every.max(axis=0) + AROUND
    axes.set(aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    style.legend_below(figure, axes, 2)
    return Finding(figure, {"orders": list(orders), "points": found})


def potential(lab: Lab) -> Finding:
    """Contours of the moment's potential of order 2 and 4, from two places (3.13)."""
    arena = lab.recipes(ROOM)[0].arena()
    figure = style.canvas(8.6, 8.8)
    panels = figure.subplots(2, 2)
    lowest: dict[str, list[float]] = {}
    for line, place in zip(panels, (_elsewhere(arena), arena.home), strict=True):
        for axes, order in zip(line, (2.0, 4.0), strict=True):
            at = _draw_potential(axes, arena, place, order)
            lowest[f"n={order:g}, seen from {_said(place)}"] = at.round(5).tolist()
    style.legend_below(figure, panels[0, 0], 2)
    figure.suptitle(f"Potential of the moment, {arena.name}", fontsize=11, x=0.01, ha="left")
    return Finding(figure, {"lowest": lowest})


def _draw_potential(axes: Axes, arena: Arena, place: Point, order: float) -> FloatArray:
    """Draw the potential of what is seen from a place and return where it is least (2,) [m]."""
    landmarks = points(distances(view_at(arena.source, place), "range").metres) + place
    low, high = landmarks.min(axis=0), landmarks.max(axis=0)
    x, y = np.meshgrid(np.linspace(low[0], high[0], 70), np.linspace(low[1], high[1], 70))
    style.dress(axes, f"n = {order:g}, seen from {_said(place)}", "x [m]", "y [m]")
    axes.contour(
        x, y, _potential(landmarks, np.stack([x, y], axis=-1), order), levels=14, cmap="viridis_r", linewidths=1.0
    )
    draw_plan(axes, arena.plan)
    at: FloatArray = convergence_point(landmarks - place, np.ones(len(landmarks)), order) + place
    axes.plot(*place, "*", color="#FFD400", markersize=12, markeredgecolor="black", label="seen from")
    axes.plot(*at, "o", color=style.RED, markersize=6, label="least potential")
    axes.set_aspect("equal")
    return at


def vector_length(lab: Lab) -> Finding:
    """The length of home vectors in metres over the true distance (4.34)."""
    arena = lab.recipes(ROOM)[0].arena()
    # the lengths are asked for even where a method vouches for its bearing only
    asked: dict[str, HomingMethod[ViewVector]] = {
        "area centroid": AreaCentroid(), "convergence point": ConvergencePoint(),
        "moment's centroid": Moment(form="centroid", feature="equal"),
    }  # fmt: skip
    away = away_from_home(arena)
    edges = np.arange(0.1, float(away.max()) + 0.4, 0.3)
    curves = []
    for label, method in asked.items():
        goal = method.describe(view_at(arena.source, arena.home))
        seen = (method.describe(view_at(arena.source, arena.at(i))) for i in range(len(away)))
        lengths = np.array([math.hypot(view.x - goal.x, view.y - goal.y) for view in seen])
        curves.append(_length_curve(label, lengths, away, edges))
    return curves_finding(f"Length of the home vector, {arena.name}", "true distance [m]", "length found [m]", curves)


def _length_curve(label: str, lengths: FloatArray, away: FloatArray, edges: FloatArray) -> Curve:
    x, y, low, high = [], [], [], []
    for a, b in pairwise(edges):
        inside = lengths[(away >= a) & (away < b)]
        if len(inside) >= 3:
            x.append(float((a + b) / 2))
            y.append(float(np.median(inside)))
            low.append(float(np.percentile(inside, 5)))
            high.append(float(np.percentile(inside, 95)))
    return Curve(f"{label} (5 to 95 %)", x, y, low, high)


def _potential(landmarks: FloatArray, at: FloatArray, order: float) -> FloatArray:
    """Return the order's mean distance [m] of places (..., 2) to landmarks (N, 2): the potential in metres."""
    gaps = np.hypot(at[..., 0, None] - landmarks[:, 0], at[..., 1, None] - landmarks[:, 1])
    return np.asarray((gaps**order).mean(axis=-1) ** (1.0 / order), np.float64)


def _elsewhere(arena: Arena) -> Point:
    return arena.at(len(arena.positions) // 4)


def _said(place: Point) -> str:
    return f"{place[0]:.2f}, {place[1]:.2f} m"
