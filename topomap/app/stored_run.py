"""A log that can be replayed: its readings as a robot, with the configuration and the map that it began with."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from logs.errors import LogError
from logs.replay import ReplayRobot
from topomap.app.config import RunConfig
from topomap.app.saved_map import SavedMap, begun_with
from topomap.app.stored_config import parse_stored
from topomap.core.errors import ConfigError, DataError


@dataclass(frozen=True)
class StoredRun:
    """A log as a robot, its configuration, and a line for each of its settings that is no more."""

    robot: ReplayRobot
    config: RunConfig
    notes: tuple[str, ...]
    saved: SavedMap | None = None


def open_log(path: Path, settings: Iterable[str] = ()) -> StoredRun:
    """Return a log that can be replayed, its stored configuration changed by `section.key=value` words.

    Raises DataError or ConfigError.
    """
    try:
        robot = ReplayRobot(path, skip_damaged=True)
    except LogError as error:
        raise DataError(str(error)) from error
    words = tuple(settings)
    for word in words:
        if not word.strip().startswith("stack."):
            raise ConfigError(
                f"--set {word}: a replay takes settings of the stack alone (stack.*), the drive is history"
            )
    config, notes = parse_stored(_stored(robot, path), f"{path}: its stored configuration", words)
    return StoredRun(robot, config, notes, begun_with(robot, config.stack.mission))


def _stored(robot: ReplayRobot, path: Path) -> dict[str, Any]:
    """Return the configuration that a log keeps. Raises DataError."""
    try:
        stored = json.loads(robot.header.config)
    except (ValueError, RecursionError) as error:
        raise DataError(f"{path}: its stored configuration isn't JSON ({type(error).__name__})") from error
    if not isinstance(stored, dict):
        raise DataError(f"{path}: its stored configuration is no table")
    return stored
