"""The pose graphs that come with gtsam."""

from __future__ import annotations

from pathlib import Path

import gtsam

from topomap.core.errors import DataError


def example(name: str) -> Path:
    """Return the file of one of gtsam's example graphs, e.g. w10000; raises DataError."""
    try:
        return Path(str(gtsam.findExampleDataFile(name)))  # type: ignore[no-untyped-call]
    except (RuntimeError, ValueError, OSError) as error:
        raise DataError(f"gtsam has no example graph '{name}'") from error
