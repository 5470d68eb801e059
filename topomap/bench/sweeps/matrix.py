"""A sweep at a glance: a row a variant, a column a world and strength; what fails stands out."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from topomap.bench.sweeps.table import Line, SweptRun, lines
from topomap.core.arrays import FloatArray
from topomap.report.figures import style

STRENGTH = re.compile(r"(.+) (x\d+(?:\.\d+)?)")
"""A variant named "NAME xN" is NAME, N times as strong: the strengths of one stand side by side."""
GOOD = LinearSegmentedColormap.from_list("good", [style.RED, "#F6D9C3", "white"])
FAR = 0.3
"""[m] Error of a map that is drawn as bad as any: home counts as reached within it."""


class Panel(NamedTuple):
    """What is shown of a line: title, value, as text, and how good it is, from 0 to 1."""

    title: str
    value: Callable[[Line], float]
    form: str
    good: Callable[[float], float]


PANELS = (
    Panel("home, share", lambda line: line.home.value, ".0%", lambda share: share),
    Panel("false closures, in all", lambda line: _all(line, "closures_false"), ".0f", lambda n: float(n == 0)),
    Panel("recall, least", lambda line: line.spreads["recall"].least, ".2f", lambda share: share),
    Panel("map [m], mean", lambda line: line.spreads["map_ate_se2_m"].mean, ".2f", lambda m: max(1.0 - m / FAR, 0.0)),
)

Cells = Mapping[tuple[str, str], Line]


def matrix(runs: Sequence[SweptRun]) -> Figure:
    """Return a panel a figure of merit, with a cell for each variant (down) in each world and strength (across)."""
    cells = {placed(line): line for line in lines(runs)}
    rows, columns = (list(dict.fromkeys(place[k] for place in cells)) for k in (0, 1))
    shown = [panel for panel in PANELS if any(math.isfinite(panel.value(line)) for line in cells.values())]
    across = 0.75 * len(columns) + 0.6
    figure = style.canvas(2.0 + across * len(shown), 1.5 + 0.3 * len(rows))
    for axes, panel in zip(np.atleast_1d(figure.subplots(1, len(shown), sharey=True)), shown, strict=True):
        _draw(axes, panel, cells, rows, columns)
        axes.set_yticks(range(len(rows)), [style.literal(row) for row in rows], fontsize=8)
    return figure


def placed(line: Line) -> tuple[str, str]:
    """Return the row and the column of a line."""
    strength = STRENGTH.fullmatch(line.variant)
    return (strength[1], f"{line.world}\n{strength[2]}") if strength else (line.variant, line.world)


def _draw(axes: Axes, panel: Panel, cells: Cells, rows: list[str], columns: list[str]) -> None:
    shades: FloatArray = np.full((len(rows), len(columns)), np.nan)
    for (row, column), line in cells.items():
        value = panel.value(line)
        if math.isfinite(value):
            at = rows.index(row), columns.index(column)
            shades[at] = panel.good(value)
            axes.text(at[1], at[0], f"{value:{panel.form}}", ha="center", va="center", fontsize=8)
    style.dress(axes, panel.title)
    axes.grid(False)
    axes.imshow(shades, cmap=GOOD, vmin=0.0, vmax=1.0, aspect="auto")
    axes.set_xticks(range(len(columns)), [style.literal(column) for column in columns], fontsize=7)


def _all(line: Line, name: str) -> float:
    spread = line.spreads[name]
    return spread.mean * spread.count if spread.count else math.nan
