"""Calibration curves: what was predicted against how often it was so, of closures as of being lost."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from topomap.core.run_data import RunData
from topomap.evaluation.calibration import Reliability, of_run
from topomap.evaluation.statistics import share_interval
from topomap.report.figures import style

SCORES = {"odds": "looks and odometry", "looks": "looks alone, even odds before"}
COLOURS = (style.BLUE, style.AMBER, style.GREEN, style.PURPLE, style.RED, style.GREY)


def closure_calibration(run: RunData) -> Figure:
    """Return the curves of a run's candidates."""
    found = {label: of_run(run, score) for score, label in SCORES.items()}
    return calibration_curve({label: one for label, one in found.items() if one is not None})


def calibration_curve(
    found: Mapping[str, Reliability],
    predicted: str = "predicted probability of a true revisit",
    was: str = "share that was true",
    of: str = "candidates",
    counted: bool = True,
) -> Figure:
    """Return one curve a label, with 95 % intervals of the share and the numbers behind it below.

    of: what is counted; counted: each counts in one place, so that their sum is told.
    """
    figure = style.canvas(7.4, 4.6)
    axes, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    style.dress(axes, "Predicted and found", "", was)
    style.dress(below, "", predicted, of)
    axes.plot([0, 1], [0, 1], color=style.GREY, linewidth=1.0, linestyle=":")
    for (label, one), colour in zip(found.items(), COLOURS, strict=False):
        many = f", {one.count.sum():.0f} {of}" if counted else ""
        _draw(axes, one, f"{label}: error {one.error:.3f}{many}", colour)
        below.plot(one.predicted, one.count, color=colour, marker="o", markersize=3, linewidth=1.0)
    below.set_yscale("log")
    axes.set_xlim(-0.03, 1.03)
    axes.set_ylim(-0.03, 1.05)
    style.legend_below(figure, axes, 1 if len(found) < 3 else 2)
    return figure


def _draw(axes: Axes, one: Reliability, label: str, colour: str) -> None:
    hits = [(round(share * n), int(n)) for share, n in zip(one.true.tolist(), one.count.tolist(), strict=True)]
    intervals = [share_interval(*pair) for pair in hits]
    low = np.clip(one.true - [i.low for i in intervals], 0.0, None)
    high = np.clip([i.high for i in intervals] - one.true, 0.0, None)
    axes.errorbar(
        one.predicted, one.true, yerr=np.array([low, high]), color=colour, marker="o", markersize=4, linewidth=1.4,
        capsize=2, elinewidth=0.8, label=label,
    )  # fmt: skip
