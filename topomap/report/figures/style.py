"""How the figures look: one palette, one set of marks, one way to a file. No pyplot, so no global state.

Colours are Okabe and Ito's, which people with any colour vision can tell apart; line styles and marks differ
too. Dead reckoning is blue, the map red and the truth black, as in the thesis.
"""

from __future__ import annotations

import base64
import io
import math
from dataclasses import dataclass

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from topomap.core.arrays import FloatArray
from topomap.core.names import printable
from topomap.core.run_data import RunData
from topomap.evaluation.closures import Closure, accepted
from topomap.evaluation.journey import handover_step
from topomap.evaluation.trajectory import step_at

BLUE, RED, BLACK = "#0072B2", "#D55E00", "#000000"
GREEN, PURPLE, AMBER, GREY = "#009E73", "#B0468E", "#E69F00", "#8A8A8A"
PALE = "#C4C4C4"
SVG_LIMIT = 600_000


@dataclass(frozen=True, slots=True)
class Line:
    """How a curve is drawn: colour, width [points], dash pattern and its name in the legend."""

    color: str
    width: float
    dash: str
    label: str


@dataclass(frozen=True, slots=True)
class Mark:
    """How a point is drawn: colour, shape and its name in the legend."""

    color: str
    shape: str
    label: str


DEAD_RECKONING = Line(BLUE, 1.3, "--", "dead reckoning")
MAP = Line(RED, 1.7, "-", "map")
ONLINE = Line(AMBER, 1.4, ":", "online")
TRUTH = Line(BLACK, 2.2, "-", "truth")
TRUE_CLOSURE = Mark(GREEN, "o", "closure, true")
FALSE_CLOSURE = Mark(PURPLE, "X", "closure, false")
UNJUDGED_CLOSURE = Mark(GREY, "D", "closure, not judged")


def canvas(width: float = 7.4, height: float = 3.6) -> Figure:
    """Return an empty figure of a size [inch]."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def literal(text: str) -> str:
    """Return somebody's words as matplotlib shall draw them: dollar signs begin no formula."""
    return printable(text).replace("$", r"\$")


def dress(axes: Axes, title: str, x: str = "", y: str = "") -> None:
    """Give axes their title, labels and quiet lines."""
    axes.set_title(literal(title), loc="left", fontsize=10.5)
    axes.set_xlabel(x, fontsize=9.5)
    axes.set_ylabel(y, fontsize=9.5)
    axes.tick_params(labelsize=9, color=PALE)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(PALE)
    axes.grid(True, color="#ECECEC", linewidth=0.7)
    axes.set_axisbelow(True)


def line(axes: Axes, x: FloatArray, y: FloatArray, look: Line) -> None:
    """Draw a curve (N,) over (N,)."""
    axes.plot(x, y, color=look.color, linewidth=look.width, linestyle=look.dash, label=look.label)


def mark(axes: Axes, points: FloatArray, look: Mark) -> None:
    """Draw points (N, 2), above whatever else is drawn; the more there are the smaller."""
    axes.plot(
        points[:, 0], points[:, 1], look.shape, color=look.color, markersize=size_for(len(points), 6.5),
        markeredgecolor="white", markeredgewidth=0.4 if len(points) < 200 else 0.0, zorder=5, clip_on=False,
        label=look.label,
    )  # fmt: skip


def size_for(count: int, full: float) -> float:
    """Return the size [points] of each of so many marks: `full` up to 60 of them, at least a third of it."""
    return full * max(math.sqrt(60 / max(count, 60)), 1 / 3)


def legend_below(figure: Figure, axes: Axes, columns: int = 4) -> None:
    """Add one legend under the axes, where it hides nothing."""
    once = _labelled(axes)
    figure.legend(list(once.values()), list(once), loc="outside lower center", ncols=columns, fontsize=9, frameon=False)


def _labelled(axes: Axes) -> dict[str, Artist]:
    once: dict[str, Artist] = {}
    for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
        once.setdefault(label, handle)
    return once


def seconds(run: RunData) -> FloatArray:
    """Return the time since the first step (N,) [s]."""
    time: FloatArray = (run.stamps_ns - run.stamps_ns[0]) * 1e-9
    return time


def mark_events(axes: Axes, run: RunData) -> None:
    """Draw each accepted closure as a mark on the time axis and the hand-over as a line across."""
    time = seconds(run)
    floor = axes.get_ylim()[0]
    for look, steps in closure_steps(run):
        mark(axes, np.column_stack([time[steps], np.full(len(steps), floor)]), look)
    axes.set_xlim(0.0, max(time[-1], 1e-9))
    start = handover_step(run)
    if start:
        axes.axvline(time[start], color=BLACK, linewidth=0.9, linestyle=":", label="hand-over")


def closure_mark(closure: Closure) -> Mark:
    """Return how a closure is drawn, by what the truth says of it."""
    if closure.judgement is None:
        return UNJUDGED_CLOSURE
    return FALSE_CLOSURE if closure.judgement.false else TRUE_CLOSURE


def closure_steps(run: RunData) -> list[tuple[Mark, list[int]]]:
    """Return the query steps of the accepted closures, by how they are drawn."""
    kept = [(closure_mark(closure), closure.candidate.query_ns) for closure in accepted(run)]
    return [
        (look, [step_at(run.stamps_ns, stamp) for own, stamp in kept if own == look])
        for look in (TRUE_CLOSURE, UNJUDGED_CLOSURE, FALSE_CLOSURE)
        if any(own == look for own, _ in kept)
    ]


def data_uri(figure: Figure, photographs: bool = False) -> str:
    """Return a figure as a data URI: SVG, or PNG for photographs and where the SVG would be too large."""
    uri = "" if photographs else svg_uri(figure)
    return uri if 0 < len(uri) <= SVG_LIMIT else png_uri(figure)


def svg_uri(figure: Figure) -> str:
    """Return a figure as a data URI of an SVG, the same bytes every time."""
    text = io.BytesIO()
    # path ids are salted at random and the date is stamped unless told otherwise
    with matplotlib.rc_context({"svg.hashsalt": "topomap", "svg.fonttype": "path", "svg.image_inline": True}):
        FigureCanvasSVG(figure).print_svg(text, metadata={"Date": None, "Creator": None})
    return "data:image/svg+xml;base64," + base64.b64encode(text.getvalue()).decode("ascii")


def png_uri(figure: Figure, dpi: int = 130) -> str:
    """Return a figure as a data URI of a PNG."""
    return "data:image/png;base64," + base64.b64encode(png(figure, dpi)).decode("ascii")


def png(figure: Figure, dpi: int = 130) -> bytes:
    """Return a figure as a PNG, the same bytes every time."""
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=dpi, metadata={"Software": None})
    return data.getvalue()
