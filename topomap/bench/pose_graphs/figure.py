"""The injection test as a figure a kind: precision, recall, error and time over the share of false closures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from topomap.bench.pose_graphs.bench import NONE, OURS, Row
from topomap.report.figures import style

PANELS = (("precision", "share", False), ("recall", "share", False), ("ate_m", "m", True), ("seconds", "s", True))
TITLES = {"precision": "precision", "recall": "recall", "ate_m": "ATE", "seconds": "time"}
LOOKS = ((style.RED, "o"), (style.BLUE, "s"), (style.AMBER, "^"), (style.GREEN, "D"), (style.PURPLE, "v"))
LEAST = 1e-3  # [m, s]: what is less is drawn there, as a logarithm has no zero


def kinds(rows: Sequence[Row]) -> list[str]:
    """Return the kinds of false closures that rows tell of."""
    told = [kind for kind in dict.fromkeys(row.kind for row in rows) if kind != NONE]
    return told or [NONE]


def injection(rows: Sequence[Row], kind: str) -> Figure:
    """Return a row of panels a graph, a line a method: the mean over seeds, with the worst and best as a band.

    ATE is to the clean optimum; a method whose runs were stopped has no point there, and none where it wasn't asked.
    """
    own = [row for row in rows if row.kind in (kind, NONE)]
    graphs = list(dict.fromkeys(row.graph for row in own))
    methods = list(dict.fromkeys(row.method for row in own))
    figure = style.canvas(12.0, 0.8 + 2.5 * len(graphs))
    figure.suptitle(f"false closures of the kind '{kind}'", x=0.01, ha="left", fontsize=11)
    axes = figure.subplots(len(graphs), len(PANELS), squeeze=False)
    for line, graph in enumerate(graphs):
        for panel, (name, unit, logarithmic) in zip(axes[line], PANELS, strict=True):
            style.dress(panel, f"{graph}: {TITLES[name]}", "false closures [%]", f"[{unit}]")
            if logarithmic:
                panel.set_yscale("log")
            else:
                panel.set_ylim(-0.03, 1.05)
            for method, (colour, sign) in zip(methods, LOOKS, strict=False):
                _draw(panel, [row for row in own if (row.graph, row.method) == (graph, method)], name, colour, sign)
        _odometry(axes[line][2], own, graph)
    style.legend_below(figure, axes[0][2], 6)
    return figure


def _draw(axes: Axes, own: Sequence[Row], name: str, colour: str, sign: str) -> None:
    shares, middle, low, high = [], [], [], []
    for share in sorted({row.false_share for row in own}):
        values = [getattr(row, name) for row in own if row.false_share == share and row.asked]
        known = [value for value in values if value is not None]
        if known:
            shares.append(100 * share)
            middle.append(float(np.mean(known)))
            low.append(min(known))
            high.append(max(known))
    if shares:
        width = 2.0 if own[0].method == OURS else 1.1
        least = LEAST if axes.get_yscale() == "log" else 0.0
        middle, low, high = (np.maximum(part, least).tolist() for part in (middle, low, high))
        axes.plot(shares, middle, color=colour, marker=sign, markersize=4, linewidth=width, label=own[0].method)
        axes.fill_between(shares, low, high, color=colour, alpha=0.12, linewidth=0)


def _odometry(axes: Axes, rows: Sequence[Row], graph: str) -> None:
    drift = next(row.odometry_ate_m for row in rows if row.graph == graph)
    axes.axhline(drift, color=style.BLACK, linestyle="--", linewidth=1.0, label="odometry")
