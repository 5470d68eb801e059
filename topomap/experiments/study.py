"""What a study is: a named question, the environments it is asked in, and the finding that answers it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from topomap.bench.homing.bench import BenchSettings, Table, bench
from topomap.bench.homing.contestant import GIVEN, Contestant
from topomap.bench.homing.rows import Row
from topomap.bench.homing.table import JsonValue
from topomap.bench.pool import Workers
from topomap.core.arrays import FloatArray
from topomap.report.figures import style
from topomap.vision.arena import Arena, Point, Recipe

COLOURS = (style.BLUE, style.RED, style.GREEN, style.PURPLE, style.AMBER, style.BLACK, style.GREY, "#56B4E9")
SHAPES = ("o", "s", "^", "D", "v", "P", "X", "*")


@dataclass(frozen=True, slots=True)
class Lab:
    """Where studies are made: recipes of environments by name, seeds, and the workers that measure.

    every: one place of a grid in so many is asked, others for each seed.
    """

    recipe: Callable[[str, int, tuple[str, ...]], Recipe]
    seeds: tuple[int, ...]
    workers: Workers
    advance: Callable[[], None]
    every: int = 1

    def recipes(self, environment: str, options: tuple[str, ...] = ()) -> list[Recipe]:
        """Return an environment's recipe for every seed; options: of the views. Raises DataError for unknown ones."""
        return [self.recipe(environment, seed, options) for seed in self.seeds]

    def table(
        self,
        environment: str,
        contestants: Sequence[Contestant],
        home: Point | None = None,
        options: tuple[str, ...] = (),
        compass: str = GIVEN,
    ) -> Table:
        """Return the homing table of contestants in an environment, over the grid only. Raises DataError."""
        return self.measured(self.recipes(environment, options), contestants, home, compass)

    def measured(
        self,
        recipes: Sequence[Recipe],
        contestants: Sequence[Contestant],
        home: Point | None = None,
        compass: str = GIVEN,
    ) -> Table:
        """Return the homing table of contestants over recipes of one environment, over the grid only."""
        settings = BenchSettings(starts=0, compass=compass, every=self.every)
        return bench(recipes, home, contestants, settings, self.workers, self.advance)[0]

    def rows(
        self,
        environment: str,
        contestants: Sequence[Contestant],
        options: tuple[str, ...] = (),
        compass: str = GIVEN,
    ) -> dict[str, Row]:
        """Return the table's rows by the contestants' names; compass: given, or an aligner's name. Raises DataError."""
        table = self.table(environment, contestants, options=options, compass=compass)
        return {row.method: row for row in table.rows}


@dataclass(frozen=True, slots=True)
class Finding:
    """What a study found: its figure, and the figures behind it as plain JSON values."""

    figure: Figure
    values: JsonValue


@dataclass(frozen=True, slots=True)
class Study:
    """A named experiment: the thesis's figures it repeats, its question, the environments it needs, how it is made."""

    name: str
    source: str
    question: str
    environments: tuple[str, ...]
    make: Callable[[Lab], Finding]


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A curve (N,) over x (N,) with the ends of its 95 % intervals."""

    label: str
    x: Sequence[float]
    y: Sequence[float]
    low: Sequence[float]
    high: Sequence[float]


def error_curve(label: str, x: Sequence[float], rows: Sequence[Row]) -> Curve:
    """Return the mean errors [degrees] of rows over x; rows without figures are left out."""
    known = [(at, row.mean) for at, row in zip(x, rows, strict=True) if row.mean is not None]
    return Curve(
        label,
        [at for at, _ in known],
        [m.value for _, m in known],
        [m.low for _, m in known],
        [m.high for _, m in known],
    )


def curves_finding(title: str, x_label: str, y_label: str, curves: Sequence[Curve], log: bool = False) -> Finding:
    """Return curves as a finding."""
    figure = style.canvas(7.2, 4.2)
    axes = figure.add_subplot()
    style.dress(axes, title, x_label, y_label)
    draw_curves(axes, curves)
    if log:
        axes.set_xscale("log")
    style.legend_below(figure, axes, min(len(curves), 3))
    return Finding(figure, curve_values(curves))


def draw_curves(axes: Axes, curves: Sequence[Curve]) -> None:
    """Draw curves from zero up, each in its colour and shape, with their intervals."""
    for curve, colour, shape in zip(curves, COLOURS, SHAPES, strict=False):
        spread = [[y - a for y, a in zip(curve.y, curve.low, strict=True)],
                  [b - y for y, b in zip(curve.y, curve.high, strict=True)]]  # fmt: skip
        axes.errorbar(
            curve.x, curve.y, spread, fmt=f"{shape}-", color=colour, markersize=5, linewidth=1.4, capsize=2.5,
            elinewidth=0.9, label=curve.label,
        )  # fmt: skip
    axes.set_ylim(bottom=0.0)


def draw_groups(axes: Axes, names: Sequence[str], curves: Sequence[Curve]) -> None:
    """Draw curves over named groups 0, 1, .. as points side by side."""
    middle, gap = (len(curves) - 1) / 2, 0.6 / max(len(curves), 1)
    beside = [replace(curve, x=[x + gap * (k - middle) for x in curve.x]) for k, curve in enumerate(curves)]
    draw_curves(axes, beside)
    for line in axes.get_lines():
        line.set_linestyle("")
    axes.set_xticks(range(len(names)), names)
    axes.set_xlim(-0.5, len(names) - 0.5)


def curve_values(curves: Sequence[Curve]) -> dict[str, JsonValue]:
    """Return curves as plain JSON values by their labels."""
    return {curve.label: _plain(curve) for curve in curves}


def bars_finding(title: str, rows: Mapping[str, Row]) -> Finding:
    """Return mean errors with 95 % intervals and the shares below 45 degrees as bars."""
    known = {name: row for name, row in rows.items() if row.mean is not None}
    figure = style.canvas(7.2, 1.4 + 0.36 * max(len(known), 1))
    draw_bars(figure.add_subplot(), title, known)
    return Finding(figure, {name: row_values(row) for name, row in known.items()})


def panels_finding(panels: Mapping[str, Mapping[str, Row]]) -> Finding:
    """Return tables' rows by title as a finding: mean errors as bars, one panel below the other."""
    figure = style.canvas(7.6, 1.0 + sum(0.9 + 0.34 * len(rows) for rows in panels.values()))
    axes = figure.subplots(len(panels), 1, height_ratios=[len(rows) + 2 for rows in panels.values()])
    for one, (title, rows) in zip(axes, panels.items(), strict=True):
        draw_bars(one, title, rows)
    return Finding(figure, {title: {n: row_values(r) for n, r in rows.items()} for title, rows in panels.items()})


def draw_bars(axes: Axes, title: str, rows: Mapping[str, Row]) -> None:
    """Draw mean errors with 95 % intervals and the shares below 45 degrees as bars, the first row on top."""
    style.dress(axes, title, "mean angular error with 95 % interval [deg]")
    for k, row in enumerate(rows.values()):
        mean, good = row.mean, row.below_45
        if mean is None or good is None:
            continue
        axes.barh(k, mean.value, 0.62, color=COLOURS[0], xerr=[[mean.value - mean.low], [mean.high - mean.value]],
                  error_kw={"elinewidth": 1.0, "capsize": 2.5})  # fmt: skip
        axes.text(mean.high, k, f"  {mean.value:.1f}°, {100 * good.value:.0f} % below 45°", va="center", fontsize=8.5)
    axes.set_yticks(range(len(rows)), list(rows))
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.45 * max((row.mean.high for row in rows.values() if row.mean), default=1.0))


def away_from_home(arena: Arena) -> FloatArray:
    """Return the distance (N,) [m] of an arena's positions from its home."""
    return np.asarray(np.hypot(*(arena.positions - np.asarray(arena.home)).T), np.float64)


def near_and_far(arena: Arena) -> dict[str, int]:
    """Return the grid position nearest to home, but not home itself, and the one farthest from it."""
    away = away_from_home(arena)
    return {"near": int(np.where(away > 1e-9, away, np.inf).argmin()), "far": int(away.argmax())}


def binned(values: FloatArray, by: FloatArray, edges: Sequence[float]) -> list[FloatArray]:
    """Return the values (N,) in each bin of another quantity (N,)."""
    return [values[(by >= a) & (by < b)] for a, b in pairwise(edges)]


def row_values(row: Row) -> dict[str, JsonValue]:
    """Return a row's figures as plain JSON values, none for a method that doesn't fit."""
    if row.mean is None or row.below_45 is None:
        return {}
    return {
        "mean_deg": round(row.mean.value, 4),
        "low": round(row.mean.low, 4),
        "high": round(row.mean.high, 4),
        "below_45": round(row.below_45.value, 4),
        "catchment": None if row.catchment is None else round(row.catchment.value, 4),
        "places": row.places,
    }


def _plain(curve: Curve) -> dict[str, JsonValue]:
    named = {"x": curve.x, "y": curve.y, "low": curve.low, "high": curve.high}
    return {name: [round(float(v), 6) for v in values] for name, values in named.items()}
