"""The named worlds."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from sim2d.errors import WorldError
from sim2d.shapes import Spec
from sim2d.world import World
from sim2d.world_hall import hall
from sim2d.world_office import office_loop
from sim2d.world_room import room_corridor

SPECS: Mapping[str, Callable[[], Spec]] = {
    "hall": hall,
    "office-loop": office_loop,
    "room-corridor": room_corridor,
}


def names() -> tuple[str, ...]:
    """Return the names of all worlds."""
    return tuple(sorted(SPECS))


def load(name: str, seed: int = 0) -> World:
    """Return a fresh world of its own; `seed` varies its textures. Raises WorldError for an unknown name."""
    if name not in SPECS:
        raise WorldError(f"unknown world {name!r}; there are {', '.join(names())}")
    return World(SPECS[name](), seed)
