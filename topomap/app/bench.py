"""The homing bench put together: worlds and image grids, methods, cores, cache, and the files it writes."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from topomap.app.views import world_recipe
from topomap.errors import DataError
from topomap.study.datasets.image_grid import grid_recipe
from topomap.study.homing_arena import Point, Recipe
from topomap.study.homing_bench import BenchSettings, Table, bench, tasks
from topomap.study.homing_contestant import Contestant, compass, contestants
from topomap.study.homing_figures import method_figure, save, sheet
from topomap.study.homing_pool import Store, workers
from topomap.study.homing_table import write_table

Progress = Callable[[int], None]


@dataclass(frozen=True, slots=True)
class BenchRequest:
    """What to measure: recipes of environments and seeds, methods, home [m] (None: the environment's own), settings."""

    recipes: tuple[Recipe, ...]
    contestants: tuple[Contestant, ...]
    home: Point | None = None
    settings: BenchSettings = field(default_factory=BenchSettings)

    @property
    def steps(self) -> int:
        """How many steps of progress there will be."""
        return tasks(len(self.recipes), len(self.contestants))


def request(
    environments: str,
    grids: Sequence[Path],
    methods: str,
    seeds: str,
    home: str | None,
    settings: BenchSettings,
) -> BenchRequest:
    """Return the request of a command line's words. Raises DataError with what would be right."""
    compass(settings.compass)
    chosen = contestants(methods)
    names = [word.strip() for word in environments.split(",") if word.strip()]
    if not names and not grids:
        raise DataError("name an environment (--env) or the folder of an image grid (--grid)")
    recipes = [world_recipe(name, seed) for name in dict.fromkeys(names) for seed in parse_seeds(seeds)]
    recipes += [grid_recipe(folder, seed) for folder in grids for seed in _grid_seeds(settings, seeds)]
    return BenchRequest(tuple(recipes), tuple(chosen), parse_point(home), settings)


def run_bench(asked: BenchRequest, store: Store, count: int, progress: Progress) -> list[Table]:
    """Return one table an environment, measured by `count` processes."""
    done = 0

    def advance() -> None:
        nonlocal done
        done += 1
        progress(done)

    with workers(count, store) as hands:
        return bench(asked.recipes, asked.home, asked.contestants, asked.settings, hands, advance)


def write_bench(tables: Sequence[Table], folder: Path) -> list[Path]:
    """Write every table and its pictures into a folder of its own and return the folders."""
    written = []
    for table in tables:
        own = folder / f"{table.environment}-{table.compass}"
        own.mkdir(parents=True, exist_ok=True)
        write_table(table, own)
        for entry, row in zip(table.entries, table.rows, strict=True):
            if row.unfit is None:
                save(method_figure(table, entry, row), own / f"{row.method}.png")
        save(sheet(table), own / "sheet.png")
        written.append(own)
    return written


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0))


def parse_seeds(text: str) -> list[int]:
    """Return the seeds of "0-4", "3" or "0,2,5". Raises DataError."""
    found: list[int] = []
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdigit() or (dash and not last.isdigit()) or (dash and int(last) < int(first)):
            raise DataError(f"--seeds {text}: expected numbers like 0-4, 3 or 0,2,5")
        found += range(int(first), int(last or first) + 1)
    return list(dict.fromkeys(found))


def parse_point(text: str | None) -> Point | None:
    """Return the point [m] of "X,Y", None for none. Raises DataError."""
    if text is None:
        return None
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        raise DataError(f"--home {text}: expected X,Y in metres, as in 2.0,1.4") from None
    return x, y


def _grid_seeds(settings: BenchSettings, seeds: str) -> list[int]:
    # photographs have no seed of their own: only the random headings differ
    return parse_seeds(seeds) if settings.compass != "given" else parse_seeds(seeds)[:1]
