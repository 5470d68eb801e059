"""A saved map as a picture: the ways that can be driven, closures, views and named places."""

from __future__ import annotations

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from topomap.mapping.graph import TopoMap
from topomap.report.figures import style


def draw_map(topo: TopoMap) -> Figure:
    """Return the map in its own frame."""
    figure = style.canvas(8.0, 7.0)
    axes = figure.subplots()
    for kind, colour, width in (("odometry", style.MAP.color, 1.6), ("closure", style.GREEN, 1.0)):
        pairs = [(a, b) for a, b, data in topo.graph.edges(data=True) if data["kind"] == kind]
        lines = topo.poses[np.array(pairs, np.int64).reshape(-1, 2), :2]
        axes.add_collection(LineCollection(list(lines), colors=colour, linewidths=width, label=kind))
    seen = [k for k, node in enumerate(topo.nodes) if node.snapshot is not None]
    axes.plot(
        *topo.poses[seen, :2].T, "o", color=style.MAP.color, markersize=style.size_for(len(seen), 4.0), label="view"
    )
    for name, number in topo.places.items():
        node = topo.node_named(number)
        if node is not None:
            x, y, _ = topo.poses[node].tolist()
            axes.plot(x, y, "*", color=style.PURPLE, markersize=12)
            axes.annotate(name, (x, y), textcoords="offset points", xytext=(7, 5), fontsize=9)
    style.dress(axes, "Saved map", "x [m]", "y [m]")
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    axes.legend(fontsize=9, frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.09), ncols=3)
    return figure
