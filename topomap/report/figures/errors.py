"""The position error over time."""

from __future__ import annotations

from dataclasses import replace

from matplotlib.figure import Figure

from topomap.core.run_data import RunData
from topomap.evaluation.trajectory import placed, position_errors
from topomap.report.figures import style


def position_error(run: RunData) -> Figure:
    """Return the distance from the truth over time for dead reckoning, the map online and the final map."""
    _, how = placed(run, run.final)
    figure = style.canvas(7.4, 3.4)
    axes = figure.add_subplot()
    style.dress(axes, f"Position error ({how})", "time [s]", "error [m]")
    time = style.seconds(run)
    for poses, look in (
        (run.dead_reckoning, style.DEAD_RECKONING),
        (run.online, style.ONLINE),
        (run.final, replace(style.MAP, label="final map")),
    ):
        errors = position_errors(run, poses)
        if errors is not None:
            style.line(axes, time, errors, look)
    axes.set_ylim(bottom=0.0)
    style.mark_events(axes, run)
    style.legend_below(figure, axes, 4)
    return figure
