"""What a bench made, as one JSON file with every note."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from topomap.core.errors import DataError
from topomap.evaluation.summary import plain, write_whole


def write_made(made: Sequence[Any], path: Path) -> Path:  # Any: dataclasses
    """Write results, each a dataclass, and return the file. Raises DataError where that can't be done."""
    try:
        write_whole(path, json.dumps(plain([asdict(one) for one in made]), indent=1) + "\n")
    except OSError as error:
        raise DataError(f"{path.parent}: can't be written ({error.strerror})") from error
    return path
