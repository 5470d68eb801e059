"""What a step costs as the map grows."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.run_data import RunData
from topomap.report.figures import style

COLOURS = (style.BLUE, style.GREEN, style.PURPLE, style.AMBER, style.GREY)
BINS = 40


def step_cost(run: RunData) -> Figure:
    """Return the milliseconds of every step over the nodes of the map, their median and 99 %, and stages' means."""
    total = sum(run.stage_ms.values(), np.zeros(len(run.stamps_ns)))
    nodes = np.searchsorted(np.sort([node.stamp_ns for node in run.nodes]), run.stamps_ns, side="right")
    figure = style.canvas(7.4, 3.8)
    axes = figure.add_subplot()
    known = total[np.isfinite(total)]
    named = f"p50 {np.median(known):.1f}, p99 {np.quantile(known, 0.99):.1f}, worst {known.max():.0f} ms"
    style.dress(axes, f"Cost of a step: {named}", "nodes of the map", "time [ms]")
    axes.plot(nodes, total, ".", color=style.PALE, markersize=1.5, rasterized=True, label="a step")
    edges = np.linspace(0, max(int(nodes.max()), 1), min(BINS, max(int(nodes.max()), 1)) + 1)
    for label, colour, values, share in (
        ("99 % of steps", style.RED, total, 0.99),
        ("half of steps", style.BLACK, total, 0.5),
    ):
        axes.plot(*_binned(nodes, values, edges, share), color=colour, linewidth=1.6, label=label)
    for (stage, values), colour in zip(run.stage_ms.items(), COLOURS, strict=False):
        axes.plot(*_binned(nodes, values, edges, None), color=colour, linewidth=1.1, linestyle="--", label=stage)
    axes.set_yscale("log")
    style.legend_below(figure, axes, 4)
    return figure


def _binned(nodes: IntArray, values: FloatArray, edges: FloatArray, share: float | None) -> tuple[FloatArray, ...]:
    """Return the middles of the bins that hold steps and a quantile of the values there (None: their mean)."""
    x, y = [], []
    for low, high in pairwise(edges.tolist()):
        part = values[(nodes > low) & (nodes <= high) & np.isfinite(values)]
        if len(part):
            x.append((low + high) / 2)
            y.append(part.mean() if share is None else np.quantile(part, share))
    return np.array(x), np.array(y)
