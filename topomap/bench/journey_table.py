"""Journeys as rows: one for each, and one for each world and disturbance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from topomap.bench.journeys import Journey, tally

HEADINGS = ("world", "disturbance", "journeys", "home", "95 %", "false", "misled", "collisions", "ratio", "m/s",
            "standing", "not home")  # fmt: skip

KEPT = ("world", "seed", "textures", "settings", "disturbance", "number", "goal", "ending", "off [m]", "planned [m]",
        "ratio", "m/s", "standing", "collisions", "misled", "seconds", "last note")  # fmt: skip


def kept_rows(made: Iterable[Journey]) -> list[tuple[str, ...]]:
    """Return one row a journey under KEPT; the first seven cells tell journeys apart."""
    return [
        (one.trip.world, f"{one.trip.seed}", f"{one.trip.textures}", " ".join(one.trip.settings), one.trip.kind,
         f"{one.trip.number}", f"{one.trip.goal}", one.ending, f"{one.error:.2f}", f"{one.planned:.1f}",
         f"{one.ratio:.2f}", f"{one.speed:.2f}", f"{one.standing:.2f}", f"{one.collisions}", f"{one.misled}",
         f"{one.seconds:.0f}", one.last)
        for one in made
    ]  # fmt: skip


def rows(made: Sequence[Journey]) -> list[tuple[str, ...]]:
    """Return the table's rows under HEADINGS: one for each world and disturbance, and one for all."""
    groups = dict.fromkeys((one.trip.world, one.trip.kind) for one in made)
    each = [
        _row(*group, [one for one in made if (one.trip.world, one.trip.kind) == group]) for group in groups
    ]  # fmt: skip
    return [*each, _row("all", "", list(made))]


def _row(world: str, kind: str, made: list[Journey]) -> tuple[str, ...]:
    t = tally(made)
    ends = Counter(one.ending for one in made if not one.home)
    return (
        world, kind, f"{t.journeys}", f"{t.home.value:.2f}", f"{t.home.low:.2f}-{t.home.high:.2f}", f"{t.false}",
        f"{sum(one.misled > 0 for one in made)}", f"{t.collisions}", f"{t.ratio:.2f}", f"{t.speed:.2f}",
        f"{t.standing:.2f}", ", ".join(f"{count} {ending}" for ending, count in ends.most_common()),
    )  # fmt: skip
