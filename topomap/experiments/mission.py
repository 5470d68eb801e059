"""The mission table: where every row of the thesis stands, as Markdown, checked against what is there."""

from __future__ import annotations

import re
from dataclasses import astuple, dataclass, replace
from pathlib import Path

from topomap.core.errors import DataError
from topomap.experiments import STUDIES
from topomap.experiments.mission_results import Homing, kept, sections
from topomap.experiments.mission_rows import ROWS
from topomap.experiments.results import read_results
from topomap.vision.compass import ALIGNERS
from topomap.vision.homing import METHODS, POLICIES, REFERENCE_METHODS
from topomap.vision.registry import Entry, entries

HEAD = ("item", "what", "called", "test", "thesis", "ours")
KINDS: dict[str, set[str]] = {
    "method": {*METHODS, *REFERENCE_METHODS, *POLICIES},
    "study": set(STUDIES),
    "aligner": set(ALIGNERS),
}
COMMAND = {"method": "topomap bench homing --methods", "study": "topomap bench study", "aligner": "--compass"}


@dataclass(frozen=True, slots=True)
class MissionRow:
    """A row: the thesis's item (figure, table, equation or section), what it is, how it is called, its test, the
    thesis's figure and ours.
    """

    item: str
    what: str
    called: str
    test: str
    thesis: str
    ours: str

    @property
    def names(self) -> tuple[str, tuple[str, ...]]:
        """The kind of call and the names called; ("-", ()) for none."""
        kind, _, rest = self.called.partition(" ")
        return kind, tuple(name.strip() for name in rest.split(",") if name.strip())


def mission_rows() -> list[MissionRow]:
    """Return the rows. Raises DataError for one with an empty cell or a name that isn't there."""
    rows = [MissionRow(*(cell.strip() for cell in line.split(" | "))) for line in ROWS.strip().splitlines()]
    for row in rows:
        if not all(astuple(row)):
            raise DataError(f"mission row {row.item}: has an empty cell")
        kind, names = row.names
        missing = [name for name in names if kind in KINDS and name not in KINDS[kind]]
        if missing:
            raise DataError(f"mission row {row.item}: there is no {kind} {', '.join(missing)}")
    return rows


def measured(row: MissionRow, homing: Homing) -> MissionRow:
    """Return a row whose figures in braces, as in {ourlab A6 did}, are those that are kept. Raises DataError."""

    def said(found: re.Match[str]) -> str:
        environment, compass, method = found[1].split()
        homing.mean(environment, compass, method)
        return homing.said(environment, compass, method)

    return replace(row, ours=re.sub(r"\{([^}]+)\}", said, row.ours))


POINTS = re.compile(r"[Tt]he studies[:,] ([a-z0-9, -]+)")
SECTIONS = {"see The loop-closing rule": "loop-rule.csv", "see Milestone spacing": "spacing.csv"}
"""What rows point to, and the file of figures that it is made of."""


def standing(row: MissionRow, results: Path) -> MissionRow:
    """Return a row that says it is open where the figures it points to aren't kept yet. Raises DataError."""
    there = {one["study"] for one in kept(results / "studies.csv").rows}
    told = [name.strip() for found in POINTS.findall(row.ours) for name in re.split(r", | and ", found)]
    missing = [f"study {name}" for name in told if name not in there]
    missing += [file for said, file in SECTIONS.items() if said in row.ours and not kept(results / file).rows]
    return replace(row, ours=f"open: not run yet: {', '.join(missing)}; {row.ours}") if missing else row


def mission_table(results: Path) -> str:
    """Return the whole document as Markdown: figures, tables and sections of the thesis first, then the kept figures in
    the folder `results`, then the methods of the registry. Raises DataError.
    """
    homing = Homing(read_results(results / "homing.csv"))
    rows = [standing(measured(row, homing), results) for row in mission_rows()]
    open_rows = sum(row.ours.startswith("open:") for row in rows)
    lines = [
        "# The thesis, row by row",
        "",
        "Written by `topomap bench mission`; a test keeps it in step. Errors are mean angular errors in degrees.",
        f"{len(rows)} rows, {open_rows} open.",
        "",
        _line(HEAD),
        _line(["---"] * len(HEAD)),
        *(_line([row.item, row.what, _call(row), _test(row), row.thesis, row.ours]) for row in rows),
        *sections(results),
        "",
        "## Methods",
        "",
        _line(("row", "name", "kind", "needs", "homes", "source", "test")),
        _line(["---"] * 7),
        *(_line(_method(entry)) for entry in entries()),
        "",
    ]
    return "\n".join(lines)


def _line(cells: tuple[str, ...] | list[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _call(row: MissionRow) -> str:
    kind, names = row.names
    if kind == "command":
        return f"`{row.called.removeprefix('command ')}`"
    if kind not in COMMAND:
        return row.called
    joined = ",".join(names) if kind == "method" else " / ".join(names)
    return f"`{COMMAND[kind]} {joined}`"


def _test(row: MissionRow) -> str:
    return row.test if row.test == "-" else f"`{row.test}`"


def _method(entry: Entry) -> list[str]:
    kind = "aligners" if entry.kind == "aligner" else "policies" if entry.kind == "policy" else "eight_directions"
    test = {"aligners": "test_aligners_in_eight_directions", "policies": "test_policies_arrive_where_luck_would_not"}
    guard = test.get(kind, "test_eight_directions" if entry.homes else "test_turning_the_views_turns_the_answer")
    return [entry.row, f"`{entry.name}`", entry.kind, entry.needs or "nothing", "yes" if entry.homes else "no",
            entry.source or "own", f"`test_conformance.py::{guard}`"]  # fmt: skip
