"""Anybody's pose graphs in the plane: g2o's and TORO's files in, g2o's out."""

from topomap.datasets.g2o.reader import read_graph
from topomap.datasets.g2o.writer import graph_text

__all__ = ["graph_text", "read_graph"]
