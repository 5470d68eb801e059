"""How firmly a recording's map stands, as a figure."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from topomap.bench.recordings.stability import RecordingRow
from topomap.report.figures import style

PANELS = (
    ("se2_m", "ATE, SE(2)", "[m]"),
    ("kept", "closures kept", ""),
    ("false", "of them false", ""),
    ("curvature", "curvature found", "[rad/m]"),
)


def firmness(rows: Sequence[RecordingRow]) -> Figure:
    """Return one panel a figure, a point a variation, a row a group of variations."""
    groups = list(dict.fromkeys(row.group for row in rows))
    figure = style.canvas(12.0, 1.0 + 0.5 * len(groups))
    panels = figure.subplots(1, len(PANELS), sharey=True)
    for axes, (name, title, unit) in zip(panels, PANELS, strict=True):
        style.dress(axes, title, unit)
        known = [(getattr(row, name), groups.index(row.group)) for row in rows if getattr(row, name) is not None]
        if known:
            style.mark(axes, np.array(known, float), style.Mark(style.RED, "o", title))
    panels[0].set_yticks(range(len(groups)), [style.literal(group) for group in groups])
    panels[0].set_ylim(len(groups) - 0.5, -0.5)
    return figure
