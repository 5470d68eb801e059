"""The study of landmark pixels chosen by their brightness: how many, and what the choice is worth (5.30, 5.32)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from topomap.bench.homing.contestant import Pairwise, view_at
from topomap.core.arrays import FloatArray
from topomap.core.panorama import Panorama
from topomap.experiments.routes import RouteModel
from topomap.experiments.study import (
    Finding,
    Lab,
    away_from_home,
    curve_values,
    draw_bars,
    draw_curves,
    error_curve,
    row_values,
)
from topomap.report.figures import style
from topomap.vision.arena import Arena
from topomap.vision.homing.run_down import FIELDS, Selection
from topomap.vision.image.colour_features import horizon
from topomap.vision.image.pixel_selection import equalised, landmark_count

ROOM = "a1original"
MODEL = 2
"""M3, as the thesis follows in fig. 5.27."""
CHOICES: tuple[tuple[str, Selection], ...] = (("all", "all"), ("chosen", "automatic"))


def pixel_selection(lab: Lab) -> Finding:
    """The chosen number of columns over the distance, and the four route models with all of them and with these."""
    arena = lab.recipes(ROOM)[0].arena()
    counts = chosen_counts(arena)
    figure = style.canvas(12.4, 4.6)
    left, right = figure.subplots(1, 2)
    _draw_counts(left, arena, counts)
    variants = [
        Pairwise(f"M{k + 1}, {label} columns", RouteModel(k, chosen))
        for k in range(len(FIELDS))
        for label, chosen in CHOICES
    ]
    rows = lab.rows(ROOM, variants)
    draw_bars(right, f"route models without distances, {ROOM}", {one.name: rows[one.name] for one in variants})
    return Finding(figure, {
        "mean_count": round(float(counts.mean()), 2),
        "models": {one.name: row_values(rows[one.name]) for one in variants},
    })  # fmt: skip


def run_down(lab: Lab) -> Finding:
    """Grey without a choice, by threshold, by sorting, and RGB by sorting; and how many columns (5.27-5.31)."""
    variants = [
        Pairwise("I grey, all", RouteModel(MODEL)),
        Pairwise("II grey, threshold", RouteModel(MODEL, "threshold")),
        Pairwise("III grey, sorting", RouteModel(MODEL, "sorting")),
        Pairwise("IV RGB, sorting", RouteModel(MODEL, "sorting", True)),
    ]
    counts = (50, 100, 200, 300, 450, 600)
    series = {
        label: [Pairwise(f"{label} {n}", RouteModel(MODEL, "sorting", colour, n)) for n in counts]
        for label, colour in (("grey", False), ("RGB", True))
    }
    rows = lab.rows(ROOM, [*variants, *(one for several in series.values() for one in several)])
    figure = style.canvas(12.4, 4.6)
    left, right = figure.subplots(1, 2)
    draw_bars(left, f"M{MODEL + 1}, {ROOM}", {one.name: rows[one.name] for one in variants})
    curves = [error_curve(label, counts, [rows[one.name] for one in several]) for label, several in series.items()]
    style.dress(right, "columns that count", "columns", "mean angular error [deg]")
    draw_curves(right, curves)
    style.legend_below(figure, right, 2)
    return Finding(figure, {**{one.name: row_values(rows[one.name]) for one in variants}, **curve_values(curves)})


def chosen_counts(arena: Arena) -> FloatArray:
    """Return how many of its brightest columns each place (N,) keeps when it is compared with home."""
    goal = _brightness(view_at(arena.source, arena.home))
    views = (view_at(arena.source, arena.at(i)) for i in range(len(arena.positions)))
    return np.array([float(landmark_count(_brightness(view), goal)) for view in views])


def _brightness(view: Panorama) -> FloatArray:
    return equalised(horizon(view).mean(axis=0))


def _draw_counts(axes: Axes, arena: Arena, counts: FloatArray) -> None:
    style.dress(axes, f"chosen by itself: {counts.mean():.0f} columns in the mean, {arena.name}",
                "distance from home [m]", "columns that count as landmarks")  # fmt: skip
    axes.plot(away_from_home(arena), counts, "x", color=style.GREY, markersize=4.5)
    axes.axhline(float(counts.mean()), color=style.BLUE, linewidth=1.6)
    axes.set_ylim(bottom=0.0)
