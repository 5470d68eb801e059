"""A run's settings as the words of a mission change them."""

from __future__ import annotations

import json
from pathlib import Path

from topomap.app.config import RunConfig, load_config
from topomap.core.errors import ConfigError
from topomap.navigation.wish import Kind, Wish, parse_wish


def mission_config(
    config: Path | None, settings: list[str], mission: str | None, on_map: bool, start: str | None, at: str | None
) -> RunConfig:
    """Return the configuration of a mission. Raises ConfigError.

    mission: as `parse_wish` takes it; on_map: whether a saved map is gone on with; start: node or place where the robot
    is told that it is put; at: where it is put, as X,Y[,DEGREES] or a place of the world.
    """
    if start is not None and not on_map:
        raise ConfigError(f"--start {start}: there is no saved map to put the robot on; give --map FILE as well")
    words = [] if at is None else _put(at)
    if mission is not None:
        words.append(f"stack.mission.do={json.dumps(mission)}")
        if _alone(_parsed(mission), on_map):
            words.append("sim.driver.teaches=false")
    if start is not None:
        words.append(f"stack.mission.start={json.dumps(start)}")
    return load_config(config, [*words, *settings])


def _parsed(mission: str) -> Wish:
    try:
        return parse_wish(mission)
    except ValueError as error:
        raise ConfigError(f"--mission {mission}: {error}") from error


def _alone(wish: Wish, on_map: bool) -> bool:
    """Return whether the robot has its wheels from the beginning: nobody needs to show it what it knows."""
    return wish.kind is Kind.HALL or (on_map and wish.kind is not Kind.TEACH)


def _put(at: str) -> list[str]:
    parts = at.split(",")
    if len(parts) == 1:
        return [f"sim.start.place={json.dumps(at)}"]
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        numbers = []
    if len(numbers) not in (2, 3):
        raise ConfigError(f"--at {at}: expected X,Y or X,Y,DEGREES, as in 2.0,1.4,90, or a place of the world")
    return [f"sim.start.{name}={number}" for name, number in zip(("x", "y", "heading_deg"), numbers, strict=False)]
