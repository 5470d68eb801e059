"""The worlds by name, and those in files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from sim2d import floorplan, worldfile
from sim2d.errors import WorldError
from sim2d.floorplan import map_file as floorplan_map
from sim2d.generate.campus import campus
from sim2d.generate.corridor import long_corridor
from sim2d.shapes import Spec
from sim2d.world import World
from sim2d.worlds.hall import hall
from sim2d.worlds.office import office_loop
from sim2d.worlds.room import room_corridor

SPECS: Mapping[str, Callable[[], Spec]] = {
    "a1original": partial(worldfile.load, worldfile.SHIPPED / "a1original.toml"),
    "arboreal": partial(worldfile.load, worldfile.SHIPPED / "arboreal.toml"),
    "campus": campus,
    "cylinders": partial(worldfile.load, worldfile.SHIPPED / "cylinders.toml"),
    "hall": hall,
    "hall1": partial(worldfile.load, worldfile.SHIPPED / "hall1.toml"),
    "long-corridor": long_corridor,
    "office-loop": office_loop,
    "ourlab": partial(worldfile.load, worldfile.SHIPPED / "ourlab.toml"),
    "room-corridor": room_corridor,
    "screen": partial(worldfile.load, worldfile.SHIPPED / "screen.toml"),
}
FILES: Mapping[str, Callable[[Path], Spec]] = {
    ".toml": worldfile.load,
    ".yaml": floorplan.load,
    ".yml": floorplan.load,
}


def names() -> tuple[str, ...]:
    """Return the names of all worlds."""
    return tuple(sorted(SPECS))


def spec(name: str) -> Spec:
    """Return a world as data, by name or from a world file (.toml) or a floor plan (.yaml).

    Raises WorldError for an unknown name or a broken file.
    """
    if name in SPECS:
        return SPECS[name]()
    path = Path(name)
    if path.suffix in FILES:
        return FILES[path.suffix](path)
    raise WorldError(f"unknown world {name!r}; there are {', '.join(names())}, and files: *.toml, map.yaml")


def sources(name: str) -> tuple[Path, ...]:
    """Return every file that a world of a file rests on: itself, what it extends, its picture; none for a named one.

    Raises WorldError for a broken file.
    """
    path = Path(name)
    if name in SPECS or path.suffix not in FILES:
        return ()
    return worldfile.sources(path) if path.suffix == ".toml" else floorplan_map.sources(path)


def load(name: str, seed: int = 0) -> World:
    """Return a fresh world of its own, by name or file; `seed` varies its textures. Raises WorldError."""
    return World(spec(name), seed)
