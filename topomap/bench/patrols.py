"""Patrols over a saved map judged by the truth: each leg a journey, and what became of the map."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from topomap.bench.journeys import Journey, tally
from topomap.bench.sessions import MapFigures


@dataclass(frozen=True, slots=True)
class Patrol:
    """One patrol: settings of both drives and of the patrol alone, legs asked for and made, the map after it.

    before: ATE [m] of the map that it began with.
    """

    world: str
    seed: int
    settings: tuple[str, ...]
    changed: tuple[str, ...]
    asked: int
    legs: tuple[Journey, ...]
    before: float
    map: MapFigures

    @property
    def way(self) -> float:
        """Way [m] driven."""
        return sum(leg.way for leg in self.legs)


HEAD = (
    "world", "seed", "settings", "changed", "legs", "made", "reached", "false", "not reached", "way [m]",
    "off at most [m]", "ratio", "m/s", "standing", "collisions", "misled", "nodes", "closures", "false closures",
    "ATE before [m]", "ATE [m]",
)  # fmt: skip
"""Columns; the first five tell patrols apart, misled: legs with a step of a belief that was sure and wrong."""


SHOWN = ("world", "seed", "made", "reached", "false", "not reached", "way [m]", "off at most [m]", "collisions",
         "closures", "false closures", "ATE [m]")  # fmt: skip
"""Columns for people."""


def shown(cells: tuple[str, ...]) -> tuple[str, ...]:
    """Return the cells of a row that are under SHOWN."""
    return tuple(dict(zip(HEAD, cells, strict=True))[name] for name in SHOWN)


def row(one: Patrol) -> tuple[str, ...]:
    """Return a row under HEAD."""
    m = one.map
    return (
        one.world, f"{one.seed}", " ".join(one.settings), " ".join(one.changed), f"{one.asked}", *_cells([one]),
        f"{m.nodes}", f"{m.closures}", f"{m.false}", f"{one.before:.3f}", f"{m.ate:.3f}",
    )  # fmt: skip


def total(made: Iterable[Patrol]) -> tuple[str, ...]:
    """Return the row of all of them, its cells of single maps left empty."""
    all_ = list(made)
    closures, false = sum(one.map.closures for one in all_), sum(one.map.false for one in all_)
    asked = sum(one.asked for one in all_)
    return ("all", "", "", "", f"{asked}", *_cells(all_), "", f"{closures}", f"{false}", "", "")


def _cells(made: list[Patrol]) -> tuple[str, ...]:
    legs = [leg for one in made for leg in one.legs]
    t = tally(legs)
    ends = Counter(leg.ending for leg in legs if not leg.home)
    off = max((leg.error for leg in legs if leg.claimed), default=0.0)
    return (
        f"{len(legs)}", f"{sum(leg.home for leg in legs)}", f"{t.false}",
        ", ".join(f"{count} {ending}" for ending, count in ends.most_common()), f"{sum(one.way for one in made):.0f}",
        f"{off:.3f}", f"{t.ratio:.2f}", f"{t.speed:.2f}", f"{t.standing:.2f}", f"{t.collisions}",
        f"{sum(leg.misled > 0 for leg in legs)}",
    )  # fmt: skip
