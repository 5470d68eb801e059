"""Journeys judged by the truth: each one's figures, and their shares over many with Wilson intervals."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import StrEnum

from topomap.core.records import StepRecord, Where
from topomap.core.robot import Reading, Truth
from topomap.evaluation.journey import REACHED_M
from topomap.evaluation.statistics import Interval, share_interval

STANDING = 0.01
"""[m] A step shorter than this is one of standing."""
SURE = 0.05
"""Probability of being lost below which a belief is sure: an arrival may then be claimed."""


class Ending(StrEnum):
    """How a journey ended."""

    HOME = "home"
    FALSE = "false arrival"
    LOST = "lost"
    UNRECOGNISED = "goal not recognised"
    BLOCKED = "blocked"
    LATE = "too many steps"
    SENSES = "no senses"
    CUT_OFF = "cut off"
    OTHER = "other"


SAID = (
    ("isn't recognised", Ending.UNRECOGNISED),
    ("no way through", Ending.BLOCKED),
    ("no route", Ending.BLOCKED),
    ("lost", Ending.LOST),
    ("no arrival after", Ending.LATE),
    ("camera", Ending.SENSES),
)
"""Words of the last note by which a journey that was given up is classed, the first that fits."""


@dataclass(frozen=True, slots=True)
class Trip:
    """What was asked: world, seed, textures, the run's settings, the disturbance and its number, the goal node."""

    world: str
    seed: int
    textures: int
    settings: tuple[str, ...]
    kind: str
    number: int
    goal: int


@dataclass(frozen=True, slots=True)
class Journey:
    """One journey: what went wrong, whether arrival was claimed, and by the truth how far off it ended [m].

    over: it arrived or gave up; ratio: way driven over the planned one; speed [m/s]: mean over all steps; standing:
    share of steps; collisions: contact episodes; misled: steps with a belief that was sure and wrong; seconds: run
    time; last: the traveller's last note.
    """

    trip: Trip
    claimed: bool
    over: bool
    error: float
    planned: float
    ratio: float
    speed: float
    standing: float
    collisions: int
    misled: int
    seconds: float
    last: str
    notes: tuple[str, ...] = ()

    @property
    def way(self) -> float:
        """Way [m] driven."""
        return self.speed * self.seconds

    @property
    def home(self) -> bool:
        """Whether it arrived and said so."""
        return self.claimed and self.error <= REACHED_M

    @property
    def false(self) -> bool:
        """Whether it said so and didn't."""
        return self.claimed and self.error > REACHED_M

    @property
    def ending(self) -> Ending:
        """How it ended."""
        if self.claimed:
            return Ending.HOME if self.home else Ending.FALSE
        if not self.over:
            return Ending.CUT_OFF
        return next((ending for words, ending in SAID if words in self.last), Ending.OTHER)


class Watched:
    """An observer that keeps what a journey is judged by; wrong: says whether the belief of this moment is."""

    def __init__(self, truth: Callable[[], Truth], wrong: Callable[[Where], bool]) -> None:
        self._truth, self._wrong = truth, wrong
        self._places: list[tuple[float, float]] = []
        self._contact: list[bool] = []
        self._stamps: list[int] = []
        self._misled = 0
        self.notes: list[str] = []

    @property
    def steps(self) -> int:
        """Steps so far."""
        return len(self._stamps)

    def observe(self, reading: Reading, record: StepRecord) -> None:
        """Take one step."""
        now, wrong = self._truth(), self._wrong(record.where)
        self._places.append((now.x, now.y))
        self._contact.append(now.contact)
        self._stamps.append(reading.stamp_ns)
        self._misled += wrong and record.where.lost < SURE
        for note in dict.fromkeys((record.travel.note, record.change.mended, record.where.event)):
            if note:
                self.notes.append(f"{self.steps} ({now.x:.1f} {now.y:.1f}{', believed elsewhere' * wrong}): {note}")

    def judged(self, trip: Trip, claimed: bool, over: bool, target: tuple[float, float], planned: float) -> Journey:
        """Return the journey's figures; target: the goal's true place [m], planned: the way to it on the map [m]."""
        ways = [math.dist(a, b) for a, b in zip(self._places, self._places[1:], strict=False)]
        # a jump is somebody carrying the robot
        driven = [way for way in ways if way < 0.5]
        seconds = (self._stamps[-1] - self._stamps[0]) * 1e-9
        hits = sum(now and not before for before, now in zip([False, *self._contact], self._contact, strict=False))
        return Journey(
            trip, claimed, over, math.dist(self._places[-1], target), planned,
            sum(driven) / max(planned, 1e-9), sum(driven) / max(seconds, 1e-9),
            sum(way < STANDING for way in driven) / max(len(driven), 1), hits, self._misled, seconds,
            self.notes[-1] if self.notes else "", tuple(self.notes),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Tally:
    """Many journeys: how many came home, how many claimed it falsely, and the means of those that came home."""

    journeys: int
    home: Interval
    false: int
    collisions: int
    ratio: float
    speed: float
    standing: float


def tally(made: Iterable[Journey]) -> Tally:
    """Return the shares and means of journeys."""
    all_ = list(made)
    good = [one for one in all_ if one.home]

    def mean(values: list[float]) -> float:
        return sum(values) / len(values) if values else math.nan

    return Tally(
        len(all_), share_interval(len(good), len(all_)), sum(one.false for one in all_),
        sum(one.collisions for one in all_), mean([one.ratio for one in good]), mean([one.speed for one in good]),
        mean([one.standing for one in good]),
    )  # fmt: skip
