"""The report of an optimised pose graph: one HTML file that needs nothing else."""

from __future__ import annotations

from collections import Counter

from jinja2 import Environment, PackageLoader, StrictUndefined
from matplotlib.figure import Figure

from topomap.evaluation.graph_verdicts import graph_rows
from topomap.mapping.graph_engine import GraphVerdicts
from topomap.mapping.pose_graph import PoseGraph
from topomap.report.figures.style import png_uri


def graph_report(graph: PoseGraph, verdicts: GraphVerdicts, seconds: float, picture: Figure) -> str:
    """Return the report's HTML; seconds: what the engine took."""
    loader = PackageLoader("topomap.report", package_path="")
    page = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    reasons = Counter(zip(verdicts.inlier.tolist(), verdicts.reason, strict=True))
    return page.get_template("graph_report.html").render(
        name=graph.name,
        rows=graph_rows(graph, verdicts, seconds),
        picture=png_uri(picture),
        reasons=[("accepted" if good else "refused", why, n) for (good, why), n in reasons.most_common()],
    )
