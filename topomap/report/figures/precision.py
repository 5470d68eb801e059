"""Precision over recall of the closure candidates, a line a score, and where the map ended."""

from __future__ import annotations

from matplotlib.figure import Figure

from topomap.core.run_data import RunData
from topomap.evaluation.precision_recall import evaluate
from topomap.report.figures import style

COLOURS = (style.RED, style.BLUE, style.AMBER, style.GREEN, style.PURPLE, style.GREY)
STYLES = ("-", "--", "-.", ":")


def precision_recall(run: RunData) -> Figure:
    """Return the curves of every score and the accepted closures as a point."""
    figure = style.canvas(7.4, 3.8)
    axes = figure.subplots()
    style.dress(axes, "Candidates against the truth", "recall", "precision")
    found = evaluate(run)
    for k, one in enumerate(found.curves if found else ()):
        label = f"{one.score}: area {one.auc:.3f}, recall {one.recall_at_full_precision:.2f} at precision 1"
        look = STYLES[k // len(COLOURS) % len(STYLES)]
        axes.plot(
            one.recall, one.precision, color=COLOURS[k % len(COLOURS)], linestyle=look, linewidth=1.4, label=label
        )
    if found is not None and found.accepted_true + found.accepted_false and found.true:
        axes.plot(found.recall, found.precision, "*", color=style.BLACK, markersize=11, label="what was accepted")
    axes.set_xlim(0.0, 1.03)
    axes.set_ylim(0.0, 1.05)
    style.legend_below(figure, axes, 2)
    return figure
