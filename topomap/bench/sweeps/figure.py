"""A sweep as a figure: every run a point, a row a world and variant."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from topomap.bench.sweeps.table import COLUMNS, ERRORS, SIGMAS, SweptRun, Value, deviation
from topomap.report.figures import style

Row = list[SweptRun]
LANES = np.array([-0.22, 0.0, 0.22])  # of what shares a row


def swept(runs: Sequence[SweptRun]) -> Figure:
    """Return four panels: ATE of map, online and dead reckoning; recall; false closures; calibration in sigmas."""
    rows: dict[str, Row] = {}
    for run in runs:
        rows.setdefault(f"{run.world}\n{run.variant}", []).append(run)
    figure = style.canvas(13.0, 1.6 + 0.55 * len(rows))
    ate, recall, false, sigmas = figure.subplots(1, 4, sharey=True)
    _ate(ate, list(rows.values()))
    _one(recall, list(rows.values()), COLUMNS["recall"], "recall", "share of possible closures")
    _one(false, list(rows.values()), COLUMNS["closures_false"], "false closures", "accepted")
    _sigmas(sigmas, list(rows.values()))
    ate.set_yticks(range(len(rows)), [style.literal(row) for row in rows], fontsize=8)
    ate.set_ylim(len(rows) - 0.5, -0.5)
    recall.set_xlim(-0.03, 1.03)
    false.set_xlim(-0.3, max(3.0, false.get_xlim()[1]))
    style.legend_below(figure, ate, 3)
    return figure


def _ate(axes: Axes, rows: Sequence[Row]) -> None:
    style.dress(axes, "ATE, SE(2)", "[m]")
    axes.set_xscale("log")
    looks = (
        ("dead_reckoning_ate_m", style.DEAD_RECKONING),
        ("online_ate_m", style.ONLINE),
        ("map_ate_se2_m", style.MAP),
    )
    for name, look in looks:
        _points(axes, rows, COLUMNS[name], style.Mark(look.color, "o", look.label), 0.0)


def _one(axes: Axes, rows: Sequence[Row], value: Value, title: str, unit: str) -> None:
    style.dress(axes, title, f"[{unit}]")
    _points(axes, rows, value, style.Mark(style.RED, "o", title), 0.0)


def _sigmas(axes: Axes, rows: Sequence[Row]) -> None:
    style.dress(axes, "odometry's errors found", "(found - true) / sigma")
    axes.axvspan(-SIGMAS, SIGMAS, color=style.PALE, alpha=0.35, linewidth=0)
    colours = (style.BLUE, style.GREEN, style.PURPLE)
    for name, colour, lane in zip(ERRORS, colours, LANES.tolist(), strict=True):
        _points(axes, rows, deviation(name), style.Mark(colour, "o", name.replace("_", " ")), lane)
    axes.legend(fontsize=8, frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=3, handletextpad=0)


def _points(axes: Axes, rows: Sequence[Row], value: Value, look: style.Mark, lane: float) -> None:
    known = [(v, k + lane) for k, row in enumerate(rows) for v in map(value, row) if v is not None]
    if known:
        style.mark(axes, np.array(known), look)
