"""Why a closure was taken or refused: both views aligned, their difference over the rotation, verdicts and scores."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from topomap.core.arrays import FloatArray, Image
from topomap.report.figures import style


def explanation(
    title: str, views: Sequence[tuple[str, Image]], curve: FloatArray, claimed: float, lines: Sequence[str]
) -> Figure:
    """Return the figure: views (label, image (H, W, 3) with the common direction in the middle), curve (2, K) of
    rotation [rad] and difference, the rotation [rad] that is claimed, and lines of text."""
    figure = style.canvas(10.0, 2.3 + 1.9 * len(views) + 0.19 * len(lines))
    rows = len(views) + 2
    heights = [1.6] * len(views) + [2.0, 0.19 * len(lines) + 0.1]
    axes = figure.subplots(rows, 1, height_ratios=heights)
    for panel, (label, image) in zip(axes, views, strict=False):
        panel.set_title(label, loc="left", fontsize=9.5, pad=2)
        panel.imshow(image, aspect="auto", interpolation="nearest")
        panel.set_axis_off()
    below = axes[len(views)]
    style.dress(below, "difference over rotation", "rotation of the query against the match [deg]", "difference")
    below.plot(np.degrees(curve[0]), curve[1], color=style.RED, linewidth=1.4)
    below.axvline(np.degrees(claimed), color=style.BLACK, linestyle="--", linewidth=1.0)
    axes[-1].set_axis_off()
    axes[-1].text(
        0.0,
        1.0,
        style.literal("\n".join(lines)),
        va="top",
        fontsize=8.5,
        family="monospace",
        transform=axes[-1].transAxes,
    )
    figure.suptitle(style.literal(title), x=0.01, ha="left", fontsize=11)
    return figure
