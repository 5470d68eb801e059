"""What a file that is no map is, told by its first bytes."""

from __future__ import annotations

from pathlib import Path

SIGNS = (
    (b"\x89MCAP", "it is an MCAP log; the map lies beside it as .topomap"),
    (b"\x89PNG", "it is a PNG image"),
    (b"\xff\xd8\xff", "it is a JPEG image"),
    (b"\x1f\x8b", "it is gzip data"),
    (b"\x80\x04", "it is a Python pickle, which is never opened"),
    (b"\x93NUMPY", "it is a single NumPy array"),
    (b"SQLite format 3", "it is an SQLite database"),
    (b"%PDF", "it is a PDF document"),
    (b"VERTEX_SE2", "it is a g2o pose graph: see topomap optimize"),
    (b"EDGE_SE2", "it is a g2o pose graph: see topomap optimize"),
    (b"image:", "it is a floor plan's YAML file: see topomap run"),
)


def kind_of(path: Path) -> str:
    """Return in words what a file is, "" where that isn't known or it is a zip as maps are."""
    try:
        with path.open("rb") as file:
            head = file.read(64)
    except OSError:
        return ""
    if not head:
        return "the file is empty"
    return next((words for sign, words in SIGNS if head.startswith(sign)), "")
