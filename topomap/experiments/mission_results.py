"""What the kept figures (docs/results) say, as sections of the mission document, the thesis's figures beside ours."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from topomap.core.errors import DataError
from topomap.evaluation.statistics import share_interval
from topomap.experiments.mission_tables import ORDERS, THESIS
from topomap.experiments.results import Results, read_results
from topomap.experiments.study_rows import study_lines

ROOMS = ("a1original", "screen", "arboreal", "hall1", "ourlab", "cylinders")
"""The six environments: four like Vardy's, one like the thesis's lab, one like the cylinders of its simulations."""
COMPASSES = ("given", "A6")


class Homing:
    """The homing figures that are kept, by environment, compass and method."""

    def __init__(self, results: Results) -> None:
        self.commands = results.commands
        whole = [r for r in results.rows if not r["within"]]
        self._rows = {(r["environment"], r["compass"], r["method"]): r for r in whole}

    def mean(self, environment: str, compass: str, method: str) -> tuple[float, float, float]:
        """Return the mean error with its interval [degrees]. Raises DataError where it wasn't measured."""
        row = self._rows.get((environment, compass, method))
        if row is None:
            raise DataError(f"docs/results/homing.csv: has no row {environment},{compass},{method}")
        return float(row["mean"]), float(row["low"]), float(row["high"])

    def said(self, environment: str, compass: str, method: str, count: bool = False) -> str:
        """Return a mean with half its interval's width, "-" where it wasn't measured; count: with n."""
        row = self._rows.get((environment, compass, method))
        if row is None:
            return "-"
        half = (float(row["high"]) - float(row["low"])) / 2
        return f"{float(row['mean']):.1f} ± {half:.1f}" + (f" ({row['n']})" if count else "")

    def methods(self, compass: str) -> list[str]:
        """Return the methods, best first by the mean over the six environments."""
        names = dict.fromkeys(m for _, c, m in self._rows if c == compass)

        def mean(name: str) -> float:
            own = [float(r["mean"]) for (e, c, m), r in self._rows.items() if (c, m) == (compass, name) and e in ROOMS]
            return sum(own) / max(len(own), 1)

        return sorted(names, key=mean)


def sections(folder: Path) -> list[str]:
    """Return the lines of every section that kept figures tell; one without a file says so. Raises DataError."""
    homing = Homing(read_results(folder / "homing.csv"))
    return [
        *_rooms(homing),
        *_tables(homing),
        *_orders(homing),
        *_studies(kept(folder / "studies.csv")),
        *_plain(
            folder / "grids.csv",
            "Image grids",
            "Photographs and renderings of others: mean errors [degrees] over the places at most `within` metres from"
            " home, compass given. AntWorld's grass passes within centimetres; its eye level is row 119.5.",
            _grids,
        ),
        *_plain(
            folder / "loop-rule.csv",
            "The loop-closing rule of 5.2.4 beside the engine (5.46-5.49)",
            "The same drives and the same truth: ATE of the finished map and of what was known at each step [m].",
        ),
        *_plain(
            folder / "spacing.csv",
            "Milestone spacing",
            "The robot goes three milestones in a row by a method alone, its rotation tracked by odometry and compass,"
            " no pose believed. The prototype: min-warping all at 0.5, 0.8 and 1.2 m, none at 1.8 m; DTW with A6 all,"
            " a quarter, none.",
            _spacing,
        ),
    ]


def _heading(title: str, text: str, commands: Sequence[str]) -> list[str]:
    return ["", f"## {title}", "", text, "", *(f"    {one}" for one in commands), ""]


def _rooms(homing: Homing) -> list[str]:
    lines = _heading(
        "Six environments",
        "Mean angular error [degrees] with half the width of its 95 % interval, seeds 0-4, a share of the places.",
        homing.commands,
    )
    for compass in COMPASSES:
        lines += [f"Compass {compass}:", "", _line(("method", *ROOMS)), _rule(len(ROOMS) + 1)]
        lines += [
            _line((f"`{name}`", *(homing.said(room, compass, name) for room in ROOMS)))
            for name in homing.methods(compass)
        ]
        lines.append("")
    return lines


def _tables(homing: Homing) -> list[str]:
    text = "Compass given, and without one (the thesis: visual compass; ours: A6); (n)."
    lines = ["## The thesis's tables", "", text, ""]
    lines += [_line(("table", "room", "method", "thesis", "ours", "thesis without", "ours without")), _rule(7)]
    for t in THESIS:
        given, found = (homing.said(t.room, compass, t.method, count=True) for compass in COMPASSES)
        lines.append(_line((t.table, t.room, f"{t.numeral} `{t.method}`", t.given, given, t.without, found)))
    return lines


def _orders(homing: Homing) -> list[str]:
    lines = ["", "## The thesis's orderings", "", _line(("it says", "room", "ours", "holds", "cause")), _rule(5)]
    for order in ORDERS:
        better, worse = (homing.mean(order.room, "given", name) for name in (order.better, order.worse))
        holds = "yes" if better[0] < worse[0] else "no"
        cause = order.cause
        if holds == "no" and cause == "-":
            cause = "cause not found"
        if better[1] <= worse[2] and worse[1] <= better[2]:
            holds += ", within the intervals"
        figures = " < ".join(f"{homing.said(order.room, 'given', name)}" for name in (order.better, order.worse))
        said = f"`{order.better}` before `{order.worse}` ({order.source})"
        lines.append(_line((said, order.room, figures.replace("<", "and"), holds, cause)))
    return lines


def _studies(results: Results) -> list[str]:
    """Every study's figures, one line a series."""
    text = "What each found, at: figure ± half the width of its 95 % interval (n); errors in degrees."
    lines = _heading("The studies", text, results.commands)[:-1]
    for study in dict.fromkeys(row["study"] for row in results.rows):
        own = [row for row in results.rows if row["study"] == study]
        lines += ["", f"### {study}", "", _line(("series", "found")), _rule(2), *study_lines(own)]
    return lines


Shape = Callable[[Sequence[Mapping[str, str]]], list[str]]


def kept(path: Path) -> Results:
    """Return the figures of a file, none where there is no file yet. Raises DataError for a broken one."""
    return read_results(path) if path.exists() else Results((), ())


def _plain(path: Path, title: str, text: str, shape: Shape | None = None) -> list[str]:
    results = kept(path)
    if not results.rows:
        return _heading(title, f"Not run yet: `make results` makes docs/results/{path.name}.", ())[:-1]
    return _heading(title, text, results.commands) + (shape or _as_it_is)(results.rows)


def _as_it_is(rows: Sequence[Mapping[str, str]]) -> list[str]:
    head = tuple(rows[0]) if rows else ()
    return [_line(head), _rule(len(head)), *(_line(tuple(row.values())) for row in rows)]


def _grids(rows: Sequence[Mapping[str, str]]) -> list[str]:
    """One line a method: its mean errors by grid and distance."""
    columns = sorted({(r["environment"], r["within"]) for r in rows}, key=lambda c: (c[0], float(c[1] or "inf")))
    cells = {(r["method"], r["environment"], r["within"]): r for r in rows}
    every = sorted({r["method"] for r in rows})  # those that are equally good stand in order of their names
    names = sorted(every, key=lambda n: float(cells.get((n, *columns[0]), {"mean": "inf"})["mean"]))
    lines = [_line(("method", *(f"{grid}, within {metres} m" for grid, metres in columns))), _rule(len(columns) + 1)]
    return lines + [_line((f"`{name}`", *(_mean(cells.get((name, *column))) for column in columns))) for name in names]


def _mean(row: Mapping[str, str] | None) -> str:
    if row is None:
        return "-"
    return f"{float(row['mean']):.1f} ± {(float(row['high']) - float(row['low'])) / 2:.1f} ({row['n']})"


def _spacing(rows: Sequence[Mapping[str, str]]) -> list[str]:
    """One line a method: courses done of those begun, by world and spacing, with how many ended at a false arrival."""
    columns = list(dict.fromkeys((r["world"], r["spacing"]) for r in rows))
    cells = {(r["method"], r["world"], r["spacing"]): r for r in rows}
    names = dict.fromkeys(r["method"] for r in rows)

    def done(name: str) -> int:
        return sum(int(cells[key]["done"]) for key in cells if key[0] == name)

    head = ("method", *(f"{world} {spacing} m" for world, spacing in columns), "all, 95 %")
    lines = [_line(head), _rule(len(head))]
    for name in sorted(names, key=lambda name: (-done(name), name)):
        own = [cells.get((name, *column)) for column in columns]
        lines.append(_line((f"`{name}`", *(_courses(row) for row in own), _share([r for r in own if r]))))
    return lines


def _courses(row: Mapping[str, str] | None) -> str:
    if row is None:
        return "-"
    false = f", {row['false']} false" if int(row["false"]) else ""
    return f"{row['done']} of {row['courses']}{false}"


def _share(rows: Sequence[Mapping[str, str]]) -> str:
    found = share_interval(sum(int(r["done"]) for r in rows), sum(int(r["courses"]) for r in rows))
    return f"{found.value:.2f} [{found.low:.2f}, {found.high:.2f}]"


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _rule(count: int) -> str:
    return _line(["---"] * count)
