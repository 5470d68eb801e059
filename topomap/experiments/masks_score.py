"""The study of mask scores: their differences by direction, and their sum by distance (4.23, 4.27)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from scipy.optimize import curve_fit
from scipy.stats import spearmanr

from topomap.bench.homing.contestant import Referenced, view_at
from topomap.bench.homing.table import JsonValue
from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU, wrap, wrap_all
from topomap.core.panorama import Panorama
from topomap.evaluation.statistics import angular_errors
from topomap.experiments.study import Finding, Lab, away_from_home, near_and_far
from topomap.report.figures import style
from topomap.vision.arena import Arena, Point, bearings_home
from topomap.vision.homing.random_masks import RandomMasks, ReferenceMasks
from topomap.vision.image.haar_masks import MaskSpec, masks, scores

ROOMS = ("ourlab", "a1original")
MASKS = MaskSpec(count=5000)
BINS = 72
WINDOW = TAU / 4
"""Differences within a window of 90 degrees are added up (4.23)."""


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """Masks compared at two places: summed score differences by direction, raw and in the window (BINS,).

    place [m]; directions of home [rad]: the true one, one reference's and three references' answer.
    """

    place: Point
    raw: FloatArray
    windowed: FloatArray
    true: float
    one: float
    three: float


@dataclass(frozen=True, slots=True, eq=False)
class Saturation:
    """y = top * x / (x + half), fitted; rank: Spearman's correlation of x and y."""

    top: float
    half: float
    rank: float

    def at(self, x: FloatArray) -> FloatArray:
        """Return y (N,) at x (N,)."""
        return _saturating(x, self.top, self.half)


def score_histogram(lab: Lab) -> Finding:
    """Score differences by direction, near and far, and their sum over the distance from home (4.23, 4.27)."""
    figure = style.canvas(11.0, 7.6)
    names = ("near", "far", *ROOMS)
    panels = dict(zip(names, figure.subplots(2, 2).ravel(), strict=True))
    found: dict[str, JsonValue] = {}
    arena = lab.recipes(ROOMS[0])[0].arena()
    for label, index in near_and_far(arena).items():
        pair = compare(arena, index)
        _draw_pair(panels[label], f"{label}: {away_from_home(arena)[index]:.2f} m from home, {arena.name}", pair)
        found[label] = _said(pair)
        lab.advance()
    style.legend_below(figure, panels["near"], 5)
    for room in ROOMS:
        away, sums = sums_by_distance(lab.recipes(room)[0].arena())
        law = fitted(away, sums)
        _draw_sums(panels[room], room, away, sums, law)
        found[f"sum by distance, {room}"] = {
            "top": round(law.top, 3), "half_m": round(law.half, 4), "spearman": round(law.rank, 4),
            "places": len(away),
        }  # fmt: skip
        lab.advance()
    return Finding(figure, found)


def compare(arena: Arena, index: int) -> Pair:
    """Return the score differences of a grid position and home, and what the methods make of them."""
    goal, seen = view_at(arena.source, arena.home), view_at(arena.source, arena.at(index))
    bearings = masks(MASKS, goal.rig.width, goal.rig.height, goal.rig.horizon_row).bearings
    unlike = _scores(seen) - _scores(goal)
    centres = np.arange(BINS) * TAU / BINS
    apart = np.abs(wrap_all(bearings[np.newaxis] - centres[:, np.newaxis]))
    raw, windowed = ((apart <= half) @ unlike for half in (0.5 * TAU / BINS, 0.5 * WINDOW))
    return Pair(arena.at(index), raw, windowed, float(bearings_home(arena.positions[[index]], arena.home)[0]),
                _one_reference(seen, goal), _three_references(arena, seen))  # fmt: skip


def sums_by_distance(arena: Arena) -> tuple[FloatArray, FloatArray]:
    """Return distance from home (N,) [m] and sum of absolute score differences (N,) of all places but home."""
    goal = _scores(view_at(arena.source, arena.home))
    away = away_from_home(arena)
    sums = [np.abs(_scores(view_at(arena.source, arena.at(i))) - goal).sum() for i in range(len(away))]
    return away[away > 1e-9], np.array(sums)[away > 1e-9]


def fitted(x: FloatArray, y: FloatArray) -> Saturation:
    """Return the saturating curve through positive x, y (N,)."""
    (top, half), _ = curve_fit(_saturating, x, y, p0=(float(y.max()), float(np.median(x))))
    return Saturation(float(top), float(half), float(spearmanr(x, y).statistic))


def _saturating(x: FloatArray, top: float, half: float) -> FloatArray:
    return np.asarray(top * x / (x + half), np.float64)


def _scores(view: Panorama) -> FloatArray:
    return view.derived(MASKS, lambda p: scores(p, MASKS))


def _one_reference(seen: Panorama, goal: Panorama) -> float:
    method = RandomMasks(MASKS)
    return method.home(method.describe(seen), method.describe(goal)).bearing


def _three_references(arena: Arena, seen: Panorama) -> float:
    x, y = arena.home
    bound = Referenced("", ReferenceMasks(MASKS)).bind(
        view_at(arena.source, arena.home), lambda dx, dy: view_at(arena.source, (x + dx, y + dy))
    )
    return bound.direction(seen, 0.0, 0.0)


def _draw_pair(axes: Axes, title: str, pair: Pair) -> None:
    style.dress(axes, title, "direction, 0 is home [deg]", "score difference, summed")
    offsets = np.degrees(wrap_all(np.arange(BINS) * TAU / BINS - pair.true))
    order = np.argsort(offsets)
    axes.bar(offsets[order], pair.raw[order], 0.85 * 360 / BINS, color=style.PALE, label="masks of 5°, summed")
    mean = pair.windowed[order] * TAU / (WINDOW * BINS)
    axes.plot(offsets[order], mean, "-", color=style.BLUE, linewidth=1.8, label="mean over 90°")
    axes.axhline(0.0, color=style.GREY, linewidth=0.8)
    for direction, colour, dash, label in (
        (pair.true, style.BLACK, "-", "home"),
        (pair.one, style.RED, "--", "one reference's answer"),
        (pair.three, style.GREEN, ":", "three references' answer"),
    ):
        at = np.degrees(wrap(direction - pair.true))
        axes.axvline(at, color=colour, linestyle=dash, linewidth=1.8, label=label)
    axes.set(xlim=(-182, 182), xticks=range(-180, 181, 45))


def _draw_sums(axes: Axes, room: str, away: FloatArray, sums: FloatArray, law: Saturation) -> None:
    style.dress(axes, f"{room}: half of the most at {law.half:.2f} m, rank correlation {law.rank:.2f}",
                "distance from home [m]", "sum of |score differences|")  # fmt: skip
    axes.plot(away, sums, "x", color=style.GREY, markersize=4.5)
    x = np.linspace(0.0, float(away.max()), 100)
    axes.plot(x, law.at(x), "-", color=style.BLUE, linewidth=1.8)
    axes.set_ylim(bottom=0.0)


def _said(pair: Pair) -> dict[str, JsonValue]:
    off = angular_errors(np.array([pair.one, pair.three]), np.full(2, pair.true))
    return {
        "place": list(pair.place),
        "home_deg": round(float(np.degrees(pair.true)), 3),
        "one_reference_error_deg": round(float(off[0]), 3),
        "three_references_error_deg": round(float(off[1]), 3),
        "raw": pair.raw.round(4).tolist(),
        "windowed": pair.windowed.round(4).tolist(),
    }
