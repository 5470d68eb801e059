"""The panoramas before and at the first closure, and the one that it matched."""

from __future__ import annotations

from matplotlib.figure import Figure

from topomap.core.run_data import RunData
from topomap.report.figures import style


def panoramas(run: RunData) -> Figure:
    """Return the panoramas around the first accepted closure, one above the other, nose in the centre
    column."""
    shown = run.first_closure
    height, width = shown[0][1].shape[:2]
    figure = style.canvas(7.4, len(shown) * (7.2 * height / width + 0.28) + 0.35)
    for row, (label, image) in enumerate(shown):
        axes = figure.add_subplot(len(shown), 1, row + 1)
        axes.set_title(label, loc="left", fontsize=9.5, pad=2)
        axes.imshow(image, aspect="auto", interpolation="nearest", extent=(180, -180, 0, 1))
        axes.set_yticks([])
        axes.set_xticks([180, 90, 0, -90, -180])
        axes.tick_params(labelsize=8.5, color=style.PALE, labelbottom=row == len(shown) - 1)
        axes.spines[:].set_visible(False)
        axes.axvline(0, color="white", linewidth=0.8, alpha=0.7)
    axes.set_xlabel("bearing from the nose [deg], left is positive", fontsize=9)
    return figure
