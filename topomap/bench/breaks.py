"""Drives with one break of odometry each, judged by the truth: noticed, nothing false, the map joined again."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from topomap.core.evidence import FALSE_ROTATION
from topomap.core.geometry import Pose2, wrap
from topomap.core.records import Decision, StepRecord, Verdict
from topomap.core.robot import Reading
from topomap.evaluation.closures import PASS_RADIUS_M
from topomap.evaluation.statistics import Interval, share_interval
from topomap.mapping.mapper import Mapper

WRONG = 1.0
"""[m] What a closure, or a place on the map seen from its neighbour, is off by to be false; or FALSE_ROTATION."""
SOON = 5.0
"""[m] True way behind a break within which it shall be noticed."""
Truths = Mapping[int, Pose2]


@dataclass(frozen=True, slots=True)
class BreakDrive:
    """One drive: what broke, and what became of it.

    noticed: true way [m] from the break to the first word about it, None: never; first_closure: true way to the first
    closure across the break; early: words before the break, all of them where nothing breaks; closures, false: on the
    finished map; ever_false: accepted at any time; again: the route before the break is seen again behind it; off [m],
    turned [rad]: what the map is wrong by there, seen from the nearest place before the break.
    """

    world: str
    seed: int
    kind: str
    size: float
    words: tuple[str, ...]
    noticed: float | None
    first_closure: float | None
    early: int
    closures: int
    false: int
    ever_false: int
    again: bool
    off: float | None
    turned: float | None
    said: tuple[str, ...]

    @property
    def told(self) -> bool:
        """Whether it was noticed within 5 m, or no later than at the first closure across it."""
        if self.noticed is None:
            return False
        return self.noticed <= max(SOON, self.first_closure or 0.0)

    @property
    def joined(self) -> bool:
        """Whether the map is in one piece where the route was seen again."""
        return self.off is not None and self.turned is not None and self.off < WRONG and self.turned < FALSE_ROTATION


class BreakWatch:
    """An observer that keeps what a drive with a break is judged by."""

    def __init__(self) -> None:
        self.truths: dict[int, Pose2] = {}
        self.way: dict[int, float] = {}
        self.said: list[tuple[int, str]] = []
        self.accepted: list[Decision] = []
        self._driven = 0.0
        self._last: Pose2 | None = None

    def observe(self, reading: Reading, record: StepRecord, truth: Pose2) -> None:
        """Take one step and where the robot truly is; what somebody carries it isn't driven."""
        step = 0.0 if self._last is None else math.hypot(truth.x - self._last.x, truth.y - self._last.y)
        self._driven += step if step < 0.5 else 0.0
        self._last = truth
        self.truths[reading.stamp_ns], self.way[reading.stamp_ns] = truth, self._driven
        for text in dict.fromkeys((record.change.broken, record.change.mended, record.where.event)):
            if text:
                self.said.append((reading.stamp_ns, text))
        self.accepted += [d for d in record.change.decisions if d.verdict is Verdict.ACCEPTED]

    def judged(
        self,
        world: str,
        seed: int,
        kind: str,
        size: float,
        words: tuple[str, ...],
        broke_ns: int | None,
        mapper: Mapper,
    ) -> BreakDrive:
        """Return the figures; broke_ns: stamp of the first reading that is wrong, None: nothing broke."""
        since = broke_ns if broke_ns is not None else max(self.truths) + 1
        behind = [stamp for stamp, _ in self.said if stamp >= since]
        across = [d.stamp_ns for d in self.accepted if d.candidate.query_ns >= since > d.candidate.match_ns]
        begun = self.way.get(since, self._driven)
        kept = list({(d.candidate.query_ns, d.candidate.match): d for d in mapper.ledger.decisions}.values())
        on_map = [d for d in kept if d.verdict is Verdict.ACCEPTED]
        off, turned = self._off(since, mapper) or (None, None)
        return BreakDrive(
            world, seed, kind, size, words,
            self.way[behind[0]] - begun if behind else None, self.way[across[0]] - begun if across else None,
            len(self.said) - len(behind), len(on_map), sum(map(self._is_false, on_map)),
            sum(map(self._is_false, self.accepted)), off is not None, off, turned,
            tuple(f"{self.way[stamp]:.1f} m: {text}" for stamp, text in self.said),
        )  # fmt: skip

    def _is_false(self, decision: Decision) -> bool:
        claim = decision.candidate
        query, match = self.truths[claim.query_ns], self.truths[claim.match_ns]
        turn = wrap(claim.relative.heading - match.to(query).heading)
        return math.hypot(query.x - match.x, query.y - match.y) > WRONG or abs(turn) > FALSE_ROTATION

    def _off(self, since: int, mapper: Mapper) -> tuple[float, float] | None:
        """Return by how much [m], [rad] the map is wrong between the last place behind the break where the route before
        it is seen again, and the nearest place of that; None where it isn't seen again."""
        nodes = [(n.stamp_ns, mapper.map.pose(i)) for i, n in enumerate(mapper.map.nodes) if n.stamp_ns in self.truths]
        before = [(self.truths[stamp], pose) for stamp, pose in nodes if stamp < since]
        for stamp, pose in sorted(((s, p) for s, p in nodes if s >= since), key=lambda one: -one[0]):
            true = self.truths[stamp]
            away, near, there = min(
                ((math.hypot(at.x - true.x, at.y - true.y), at, on) for at, on in before),
                key=lambda one: one[0],
                default=(math.inf, true, pose),
            )
            if away <= PASS_RADIUS_M:
                wrong = near.to(true).to(there.to(pose))
                return math.hypot(wrong.x, wrong.y), abs(wrong.heading)
        return None


@dataclass(frozen=True, slots=True)
class BreakTally:
    """Many drives: shares of the breaks noticed in time, of the maps joined again where the route was seen again, the
    false closures on the maps and ever, and the words of drives in which nothing broke."""

    drives: int
    told: Interval
    joined: Interval
    again: int
    closures: int
    false: int
    ever_false: int
    early: int


def tally(made: Iterable[BreakDrive]) -> BreakTally:
    """Return the shares of some drives."""
    every = list(made)
    again = [one for one in every if one.again]
    return BreakTally(
        len(every), share_interval(sum(one.told for one in every), len(every)),
        share_interval(sum(one.joined for one in again), len(again)), len(again), sum(one.closures for one in every),
        sum(one.false for one in every), sum(one.ever_false for one in every), sum(one.early for one in every),
    )  # fmt: skip


HEADINGS = ("breaks", "drives", "noticed", "95 %", "joined", "seen again", "closures", "false", "ever false", "alarms")

KEPT = ("world", "seed", "breaks", "size", "noticed [m]", "first closure [m]", "closures", "false", "ever false",
        "alarms before", "seen again", "off [m]", "turned [deg]")  # fmt: skip


def kept_rows(made: Iterable[BreakDrive]) -> list[tuple[str, ...]]:
    """Return one row a drive under KEPT; the first four cells tell drives apart."""
    return [
        (one.world, f"{one.seed}", one.kind, f"{one.size:.2f}", _cell(one.noticed), _cell(one.first_closure),
         f"{one.closures}", f"{one.false}", f"{one.ever_false}", f"{one.early}", "yes" if one.again else "no",
         _cell(one.off), _cell(None if one.turned is None else math.degrees(one.turned)))
        for one in made
    ]  # fmt: skip


def _cell(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def rows(made: Sequence[BreakDrive]) -> list[tuple[str, ...]]:
    """Return the table's rows under HEADINGS: one for each kind of break, and all breaks together."""
    kinds = list(dict.fromkeys(one.kind for one in made))
    broken = [one for one in made if one.kind != "none"]
    lines = [_row(kind, [one for one in made if one.kind == kind]) for kind in kinds]
    return lines + ([_row("all breaks", broken)] if broken else [])


def _row(name: str, made: list[BreakDrive]) -> tuple[str, ...]:
    t = tally(made)
    judged = ("-",) * 4
    if name != "none":
        told, joined = t.told, f"{t.joined.value:.2f}" if t.again else "-"
        judged = f"{told.value:.2f}", f"{told.low:.2f}-{told.high:.2f}", joined, f"{t.again}"
    return name, f"{t.drives}", *judged, f"{t.closures}", f"{t.false}", f"{t.ever_false}", f"{t.early}"
