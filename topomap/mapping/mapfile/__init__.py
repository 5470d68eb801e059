"""The finished map in one file: a zip of NumPy arrays and JSON, no pickle; loads back equal, or says what is wrong."""

from topomap.mapping.mapfile.reader import from_bytes, load_map
from topomap.mapping.mapfile.writer import FORMAT, save_map, to_bytes

__all__ = ["FORMAT", "from_bytes", "load_map", "save_map", "to_bytes"]
