"""topomap: loop-closing navigation with topological snapshot maps."""

from importlib.metadata import version

__version__ = version("topomap")
