"""Studies on moments: their order, their convergence points, their potential, range and colour (chapter 3)."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from topomap.contract import HomingMethod
from topomap.geometry import FloatArray
from topomap.study import figures_style as style
from topomap.study.homing_contestant import Pairwise, view_at
from topomap.study.homing_figures import draw_plan
from topomap.study.studies.study import Curve, Finding, Lab, away_from_home, bars_finding, curves_finding, error_curve
from topomap.vision.convergence import convergence_point, points
from topomap.vision.distances import distances
from topomap.vision.homing.area_centroid import AreaCentroid
from topomap.vision.homing.convergence_point import ConvergencePoint
from topomap.vision.homing.moment import Form, Moment
from topomap.vision.homing.view_vector import ViewVector

ORDERS = (-1.0, 0.5, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0)
LABELLED = (1.0, 2.0, 4.0, 10.0)
"""Orders whose points are named beside the farther place; from home they lie too close together."""
AROUND = 0.25
"""What is shown around the points [m]."""
ROOM = "ourlab"


def dimension(lab: Lab) -> Finding:
    """The mean error over the order n, by form and with and without colour (3.9-3.12, 3.24, 3.30)."""
    forms: tuple[Form, ...] = ("gradient", "pixel", "area")
    variants = {
        f"{form}, {'range only' if feature == 'equal' else 'range and colour'}": [
            Pairwise(f"{form} {feature} {n:g}", Moment(n, feature, form)) for n in ORDERS
        ]
        for form in forms
        for feature in ("equal", "rgb")
    }
    rows = lab.rows(ROOM, [one for several in variants.values() for one in several])
    curves = [error_curve(label, ORDERS, [rows[one.name] for one in several]) for label, several in variants.items()]
    found = curves_finding(f"Order of the moment, {ROOM}", "order n", "mean angular error [deg]", curves)
    # from half a degree to the wrong way round
    found.figure.axes[0].set(yscale="log", ylim=(0.3, 200.0), yticks=(0.5, 1, 2, 5, 10, 20, 50, 100), xticks=ORDERS)
    found.figure.axes[0].yaxis.set_major_formatter("{x:g}")
    found.figure.axes[0].xaxis.set_major_formatter("{x:g}")
    return found


def derivative_or_search(lab: Lab) -> Finding:
    """The gradient's difference against the difference of searched convergence points (3.29)."""
    orders = (1.5, 2.0, 3.0, 4.0, 6.0)
    gradient = [Pairwise(f"gradient {n:g}", Moment(n, "equal")) for n in orders]
    search = [Pairwise(f"search {n:g}", ConvergencePoint(n)) for n in orders]
    rows = lab.rows(ROOM, [*gradient, *search])
    curves = [
        error_curve("derivative", orders, [rows[one.name] for one in gradient]),
        error_curve("convergence point", orders, [rows[one.name] for one in search]),
    ]
    return curves_finding(f"Derivative or search, {ROOM}", "order n", "mean angular error [deg]", curves)


def convergence(lab: Lab) -> Finding:
    """Where the convergence point lies for orders 1 to 10, from two places (3.4)."""
    orders = [1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0]
    arena = lab.recipes(ROOM)[0].arena()
    other = arena.at(len(arena.positions) // 4)
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
        axes.annotate(f"n={n:g}", found[_said(other)][orders.index(n)], xytext=(5, -11), textcoords="offset points",
                      fontsize=8, color=style.RED)  # fmt: skip
    every = np.concatenate([found[_said(place)] for place in (arena.home, other)])
    low, high = every.min(axis=0) - AROUND, every.max(axis=0) + AROUND
    axes.set(aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    style.legend_below(figure, axes, 2)
    return Finding(figure, {"orders": list(orders), "points": found})


def potential(lab: Lab) -> Finding:
    """Contours of the moment's potential of order 2 and 4 (3.13)."""
    arena = lab.recipes(ROOM)[0].arena()
    place = arena.at(len(arena.positions) // 4)
    landmarks = points(distances(view_at(arena.source, place), "range").metres) + place
    low, high = landmarks.min(axis=0), landmarks.max(axis=0)
    x, y = np.meshgrid(np.linspace(low[0], high[0], 70), np.linspace(low[1], high[1], 70))
    figure = style.canvas(9.0, 4.4)
    lowest: dict[str, list[float]] = {}
    for axes, order in zip(figure.subplots(1, 2), (2.0, 4.0), strict=True):
        style.dress(axes, f"n = {order:g}", "x [m]", "y [m]")
        values = _potential(landmarks, np.stack([x, y], axis=-1), order)
        axes.contour(x, y, values ** (1.0 / order), levels=14, cmap="viridis_r", linewidths=1.0)
        draw_plan(axes, arena.plan)
        at = convergence_point(landmarks - place, np.ones(len(landmarks)), order) + place
        axes.plot(*place, "*", color="#FFD400", markersize=12, markeredgecolor="black", label="seen from")
        axes.plot(*at, "o", color=style.RED, markersize=6, label="least potential")
        axes.set_aspect("equal")
        lowest[f"n={order:g}"] = [round(float(v), 5) for v in at]
    style.legend_below(figure, axes, 2)
    figure.suptitle(f"Potential of the moment, {arena.name}", fontsize=11, x=0.01, ha="left")
    return Finding(figure, {"lowest": lowest})


def range_or_colour(lab: Lab) -> Finding:
    """Colour only, range only and both (3.14, 3.15)."""
    variants = [
        Pairwise("colour only", Moment(2.0, "rgb", distance="equal")),
        Pairwise("range only", Moment(2.0, "equal")),
        Pairwise("range and colour", Moment(2.0, "rgb")),
        Pairwise("range only, area", Moment(2.0, "equal", "area")),
        Pairwise("range and colour, area", Moment(2.0, "rgb", "area")),
    ]
    rows = lab.rows(ROOM, variants)
    return bars_finding(f"Range or colour, moment n = 2, {ROOM}", {one.name: rows[one.name] for one in variants})


def features(lab: Lab) -> Finding:
    """The colour feature that weighs the ranges (3.16)."""
    variants = [Pairwise(f, Moment(2.0, f)) for f in ("equal", "red", "green", "blue", "grey", "rgb", "hsv", "value")]
    rows = lab.rows(ROOM, variants)
    return bars_finding(f"Feature, moment n = 2, {ROOM}", {one.name: rows[one.name] for one in variants})


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
    gaps = np.hypot(at[..., 0, None] - landmarks[:, 0], at[..., 1, None] - landmarks[:, 1])
    return np.asarray((gaps**order).mean(axis=-1), np.float64)


def _said(place: tuple[float, float]) -> str:
    return f"{place[0]:.2f}, {place[1]:.2f} m"
