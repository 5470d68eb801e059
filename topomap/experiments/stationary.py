"""The study of stationary points: their matches against a full search of where warping should start (5.34)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from matplotlib.axes import Axes

from topomap.bench.homing.contestant import Pairwise, view_at
from topomap.bench.homing.rows import Row
from topomap.bench.homing.table import JsonValue
from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.geometry import TAU, wrap_all
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.experiments.study import Finding, Lab, away_from_home, draw_bars, near_and_far, row_values
from topomap.report.figures import style
from topomap.vision.arena import Arena, bearings_home
from topomap.vision.contracts import Needs
from topomap.vision.homing.dtw import DynamicWarping, RingPair, matched_home
from topomap.vision.image.ring import RingSpec
from topomap.vision.matching.dtw_kernels import dtw_path
from topomap.vision.matching.ring_flow import fitted_flow

ROOM = "a1original"
COARSE = DynamicWarping(spec=RingSpec(columns=72))
"""Every start of 72 x 72 columns can be searched; at 720 the thesis waited three hours."""


@dataclass(frozen=True, slots=True)
class FullSearch:
    """Warping from that pair of start columns, among all, whose match costs least; bearing only."""

    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = True
    warping: DynamicWarping

    def describe(self, panorama: Panorama) -> RingPair:
        """Return the rings the matching runs on."""
        return self.warping.describe(panorama)

    def home(self, current: RingPair, goal: RingPair) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame."""
        costs = self.costs(current, goal)
        there, here = (int(k) for k in np.unravel_index(costs.argmin(), costs.shape))
        shift, _ = dtw_path(_from(goal.fine, there), _from(current.fine, here), self._band(goal))
        own, step = np.arange(len(shift)), TAU / len(shift)
        pairs = np.stack([own + there, own + shift + here]).astype(np.float64) * step + goal.first_bearing
        return matched_home(pairs[0], pairs[1], 0.0)

    def costs(self, current: RingPair, goal: RingPair) -> FloatArray:
        """Return the cost (C, C) of warping from each goal column (rows) and current column on."""
        columns, band = len(goal.fine[0]), self._band(goal)
        here = [_from(current.fine, k) for k in range(columns)]
        return np.array([[dtw_path(there, one, band)[1] for one in here]
                         for there in (_from(goal.fine, k) for k in range(columns))])  # fmt: skip

    def _band(self, goal: RingPair) -> int:
        columns = len(goal.fine[0])
        return min(max(round(self.warping.band * columns / TAU), 1), columns - 1)


@dataclass(frozen=True, slots=True, eq=False)
class ScoreField:
    """The costs (C, C) of every start, the diffusion point found [column] and the true one [column, fractional]."""

    costs: FloatArray
    found: int
    true: float

    @property
    def least(self) -> tuple[int, int]:
        """The full search's start, goal and current column."""
        there, here = np.unravel_index(self.costs.argmin(), self.costs.shape)
        return int(there), int(here)


def stationary_points(lab: Lab) -> Finding:
    """Where stationary points lie among all starts, near and far, and what a full search gains (5.34)."""
    arena = lab.recipes(ROOM)[0].arena()
    figure = style.canvas(12.0, 6.6)
    grid = figure.add_gridspec(2, 2, height_ratios=(3.2, 1.3))
    panels = {"near": figure.add_subplot(grid[0, 0]), "far": figure.add_subplot(grid[0, 1])}
    found: dict[str, JsonValue] = {}
    for label, index in near_and_far(arena).items():
        field = score_field(arena, index)
        _draw_field(panels[label], f"{label}: {away_from_home(arena)[index]:.2f} m from home, {ROOM}", field)
        found[label] = _said(field)
        lab.advance()
    style.legend_below(figure, panels["far"], 4)
    variants = [Pairwise("stationary points", COARSE), Pairwise("full search", FullSearch(COARSE))]
    rows = lab.rows(ROOM, variants)
    timed = {f"{one.name}\n{_ms(rows[one.name]):.2f} ms a pair": rows[one.name] for one in variants}
    draw_bars(figure.add_subplot(grid[1, :]), f"all places, {COARSE.spec.columns} columns", timed)
    found["grid"] = {name: {**row_values(row), "ms": round(_ms(row), 3)} for name, row in rows.items()}
    return Finding(figure, found)


def score_field(arena: Arena, index: int) -> ScoreField:
    """Return the score field of a grid position and home."""
    seen, goal = (COARSE.describe(view_at(arena.source, at)) for at in (arena.at(index), arena.home))
    columns = goal.fine.shape[1]
    ahead = fitted_flow(seen.coarse, goal.coarse, COARSE.flow).direction
    home = float(bearings_home(arena.positions[[index]], arena.home)[0])
    # the movement went from the goal to here, the other way
    true = ((home + np.pi - goal.first_bearing) * columns / TAU) % columns
    return ScoreField(FullSearch(COARSE).costs(seen, goal), round(ahead * columns / TAU) % columns, float(true))


def _from(ring: Float32Array, column: int) -> Float32Array:
    return np.roll(ring, -column, axis=1)


def _draw_field(axes: Axes, title: str, field: ScoreField) -> None:
    columns = len(field.costs)
    style.dress(axes, title, "start in the current view [deg]", "start in the goal's view [deg]")
    axes.grid(False)
    picture = axes.imshow(field.costs, cmap="viridis", origin="lower", extent=(0, 360, 0, 360), interpolation="nearest")
    bar = axes.figure.colorbar(picture, ax=axes, shrink=0.85)
    bar.set_label("cost of the match", fontsize=8.5)
    scale = 360.0 / columns
    opposite = (field.found + columns / 2) % columns
    there, here = field.least
    axes.plot((here + 0.5) * scale, (there + 0.5) * scale, "o", color=style.RED, markersize=9,
              markeredgecolor="white", label="least cost of all")  # fmt: skip
    for at, shape, label in ((field.found, "D", "diffusion point"), (opposite, "s", "convergence point")):
        axes.plot((at + 0.5) * scale, (at + 0.5) * scale, shape, color="#56B4E9", markersize=8,
                  markeredgecolor="white", label=label)  # fmt: skip
    axes.plot((field.true + 0.5) * scale, (field.true + 0.5) * scale, "*", color="#FFD400", markersize=12,
              markeredgecolor=style.BLACK, label="true diffusion point")  # fmt: skip
    axes.set(xticks=range(0, 361, 90), yticks=range(0, 361, 90))


def _said(field: ScoreField) -> dict[str, JsonValue]:
    own, step = float(field.costs[field.found, field.found]), 360.0 / len(field.costs)
    off = wrap_all(np.array([(field.found - field.true) * TAU / len(field.costs)]))
    return {
        "mean_cost": round(float(field.costs.mean()), 5),
        "least_cost": round(float(field.costs.min()), 5),
        "least_at_deg": [round(k * step, 2) for k in field.least],
        "stationary_cost": round(own, 5),
        "stationary_at_deg": round(field.found * step, 2),
        "stationary_off_deg": round(float(np.degrees(np.abs(off[0]))), 3),
        "starts_that_cost_less": round(float((field.costs < own).mean()), 5),
    }


def _ms(row: Row) -> float:
    return float("nan") if row.ms is None else row.ms
