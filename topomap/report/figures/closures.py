"""The closures judged by the truth: where they claim to be one place, and when."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from topomap.core.arrays import FloatArray
from topomap.core.records import Verdict
from topomap.core.run_data import RunData
from topomap.evaluation.closures import Closure, closures
from topomap.evaluation.trajectory import true_pose
from topomap.report.figures import style
from topomap.report.figures.routes import draw_plan

LOOKS = (style.UNJUDGED_CLOSURE, style.TRUE_CLOSURE, style.FALSE_CLOSURE)


def closure_map(run: RunData) -> Figure:
    """Return the accepted closures as links between the true places they join, beside it every candidate by the
    times of its query and its match."""
    figure = style.canvas(7.4, 4.1)
    places, times = figure.subplots(1, 2, width_ratios=(1.15, 1.0))
    style.dress(places, "Accepted, over the true route", "x [m]", "y [m]")
    style.dress(times, "All candidates", "time of the query [s]", "time of the match [s]")
    every = closures(run)
    kept = [closure for closure in every if closure.verdict is Verdict.ACCEPTED]
    _draw_times(times, run, [c for c in every if c.verdict is not Verdict.ACCEPTED], kept)
    if run.truth is not None:
        draw_plan(places, run)
        style.line(places, run.truth[:, 0], run.truth[:, 1], replace(style.TRUTH, width=0.7))
        _draw_links(places, run, run.truth, kept)
    places.set_aspect("equal", adjustable="datalim")
    style.legend_below(figure, times, 4)
    return figure


def _draw_times(axes: Axes, run: RunData, others: list[Closure], kept: list[Closure]) -> None:
    if others:
        points = _times(run, others)
        axes.plot(points[:, 0], points[:, 1], ".", color=style.GREY, markersize=style.size_for(len(others), 5.0),
                  markeredgewidth=0.0, label=f"not accepted ({len(others)})")  # fmt: skip
    for look in LOOKS:
        own = [closure for closure in kept if style.closure_mark(closure) == look]
        if own:
            style.mark(axes, _times(run, own), replace(look, label=f"{look.label} ({len(own)})"))


def _times(run: RunData, chosen: list[Closure]) -> FloatArray:
    stamps = [(closure.candidate.query_ns, closure.candidate.match_ns) for closure in chosen]
    times: FloatArray = (np.array(stamps, dtype=np.int64) - run.stamps_ns[0]) * 1e-9
    return times


def _draw_links(axes: Axes, run: RunData, truth: FloatArray, kept: list[Closure]) -> None:
    for look in LOOKS:
        own = [closure.candidate for closure in kept if style.closure_mark(closure) == look]
        if not own:
            continue
        queries = np.array([true_pose(run, candidate.query_ns)[:2] for candidate in own]).reshape(-1, 2)
        matches = np.array([true_pose(run, candidate.match_ns)[:2] for candidate in own]).reshape(-1, 2)
        links = list(np.stack([queries, matches], axis=1))
        faint = 0.7 if len(own) < 200 else 0.15
        axes.add_collection(LineCollection(links, colors=look.color, linewidths=1.0, alpha=faint))
        style.mark(axes, queries, look)
