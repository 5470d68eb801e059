"""Where a map's nodes truly are, as CSV beside the map and in the log of a run on it: for metrics alone."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping
from pathlib import Path

from topomap.core.errors import DataError
from topomap.core.files import regular

HEAD = ("node", "x_m", "y_m", "heading_rad")
LARGEST = 64_000_000  # [bytes] of a file of true poses
ATTACHMENT = "start.truth.csv"
"""The log's attachment: the true poses of the map that the run began with, by the node's place in it."""

Truths = Mapping[int, tuple[float, float, float]]
"""True poses x, y [m], heading [rad] by node."""


def truth_file(map_file: Path) -> Path:
    """Return where the true poses of a map's nodes lie, if a simulated run made it."""
    return map_file.with_suffix(".truth.csv")


def truths_text(truths: Truths) -> str:
    """Return true poses as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(HEAD)
    writer.writerows((node, *map(repr, pose)) for node, pose in sorted(truths.items()))
    return text.getvalue()


def read_truths(path: Path) -> Truths:
    """Return the true poses of a file, none where there is no file. Raises DataError for another kind of file."""
    try:
        if not path.exists():
            return {}
        if path.stat().st_size > LARGEST:
            raise DataError(f"{path}: {path.stat().st_size} bytes are more than the true poses of any map")
        return parse_truths(regular(path).read_text(encoding="utf8"), str(path))
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: the true poses can't be read ({error})") from error


def parse_truths(text: str, source: str) -> Truths:
    try:
        head, *rows = list(csv.reader(io.StringIO(text)))
        if tuple(head) != HEAD:
            raise ValueError(f"expected the columns {', '.join(HEAD)}")
        found = {int(node): (float(x), float(y), float(heading)) for node, x, y, heading in rows}
    except (ValueError, csv.Error) as error:
        raise DataError(f"{source}: not the true poses of a map ({error})") from error
    return {node: pose for node, pose in found.items() if all(map(math.isfinite, pose))}
