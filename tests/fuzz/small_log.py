"""The log that is damaged: short, so that hundreds of copies can be tried, and with one of every kind of record."""

from __future__ import annotations

from pathlib import Path

from round_world import RoundRobot

import topomap


def small_log(folder: Path) -> Path:
    """Return the log of a drive of little more than a lap that closes its loop."""
    result = topomap.drive(RoundRobot(75), folder / "run", settings=["stack.mission.then=stop"])
    return result.folder.log
