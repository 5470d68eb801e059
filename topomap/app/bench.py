"""The homing bench put together: worlds and image grids, methods, cores, cache, and the files it writes."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

from sim2d import worlds
from topomap.app.views import world_recipe
from topomap.app.words import parse_point, parse_seeds
from topomap.bench.homing.bench import BenchSettings, Table, bench, tasks
from topomap.bench.homing.contestant import Contestant, compass, contestants
from topomap.bench.homing.figures import method_figure, save, sheet
from topomap.bench.homing.table import write_table
from topomap.bench.places import PlaceScore, place_scores
from topomap.bench.pool import Store, workers
from topomap.core.errors import DataError
from topomap.core.names import safe_name
from topomap.datasets.image_grid import grid_recipe
from topomap.evaluation.summary import write_whole
from topomap.experiments import STUDIES, Lab, Study
from topomap.experiments.results import add_results
from topomap.experiments.study_rows import HEAD as STUDY_HEAD
from topomap.experiments.study_rows import study_rows
from topomap.vision.arena import Point, Recipe

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
    options: Sequence[str] = (),
) -> BenchRequest:
    """Return the request of a command line's words. Raises DataError with what would be right."""
    compass(settings.compass)
    chosen = contestants(methods)
    names = [word.strip() for word in environments.split(",") if word.strip()]
    if not names and not grids:
        raise DataError("name an environment (--env) or the folder of an image grid (--grid)")
    views = tuple(options)
    recipes = [world_recipe(name, seed, views) for name in dict.fromkeys(names) for seed in parse_seeds(seeds)]
    recipes += [grid_recipe(folder, seed) for folder in grids for seed in _grid_seeds(settings, seeds)]
    return BenchRequest(tuple(recipes), tuple(chosen), parse_point(home), settings)


def run_bench(asked: BenchRequest, store: Store, count: int, progress: Progress) -> list[Table]:
    """Return one table an environment, measured by `count` processes."""
    with workers(count, store) as hands:
        return bench(asked.recipes, asked.home, asked.contestants, asked.settings, hands, _counting(progress))


def write_bench(tables: Sequence[Table], folder: Path, pictures: bool = True) -> list[Path]:
    """Write every table and, if asked, its pictures into a folder of its own and return the folders."""
    written = []
    for table in tables:
        own = folder / safe_name(f"{table.environment}-{table.compass}")
        own.mkdir(parents=True, exist_ok=True)
        write_table(table, own)
        if pictures:
            _draw(table, own)
        written.append(own)
    return written


def _draw(table: Table, folder: Path) -> None:
    for entry, row in zip(table.entries, table.rows, strict=True):
        if row.unfit is None:
            save(method_figure(table, entry, row), folder / f"{safe_name(row.method)}.png")
    save(sheet(table), folder / "sheet.png")


def _grid_seeds(settings: BenchSettings, seeds: str) -> list[int]:
    # photographs have no seed of their own: only the random headings differ
    return parse_seeds(seeds) if settings.compass != "given" else parse_seeds(seeds)[:1]


def available() -> list[Study]:
    """Return the studies whose environments are there."""
    known = set(worlds.names())
    return [study for study in STUDIES.values() if known.issuperset(study.environments)]


def run_study(
    name: str,
    seeds: str,
    store: Store,
    count: int,
    progress: Progress,
    folder: Path,
    every: int = 1,
    keep: Path | None = None,
) -> list[Path]:
    """Make a named study; write its figure and its figures as JSON. Raises DataError for an unknown name.

    every: one place of a grid in so many is asked; keep: CSV file that its figures are added to.
    """
    known = {study.name: study for study in available()}
    if name not in known:
        raise DataError(f"unknown study {name!r}; there are {', '.join(known)}")
    advance = _counting(progress)
    with workers(count, store) as hands:
        found = known[name].make(Lab(world_recipe, tuple(parse_seeds(seeds)), hands, advance, every))
    folder.mkdir(parents=True, exist_ok=True)
    said = {"study": name, "source": known[name].source, "seeds": seeds, "every": every, "values": found.values}
    write_whole(folder / f"{name}.json", json.dumps(said, indent=2, allow_nan=False) + "\n")
    if keep is not None:
        add_results(keep, STUDY_HEAD, study_rows(name, found.values), keys=3)
    return [save(found.figure, folder / f"{name}.png"), folder / f"{name}.json"]


def run_places(
    route: Path, spacing: int, stride: int, store: Store, count: int, progress: Progress, folder: Path
) -> list[PlaceScore]:
    """Return the place check of every aligner on a recorded route and write it as JSON. Raises DataError."""
    with workers(count, store) as hands:
        scores = place_scores(route, spacing, stride, hands, _counting(progress))
    plain = [{k: v if v == v else None for k, v in asdict(score).items()} for score in scores]
    write_whole(folder / f"{route.resolve().name}.json", json.dumps(plain, indent=2, allow_nan=False) + "\n")
    return scores


def _counting(progress: Progress) -> Callable[[], None]:
    done = 0

    def advance() -> None:
        nonlocal done
        done += 1
        progress(done)

    return advance
