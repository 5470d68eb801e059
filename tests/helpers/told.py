"""A straight drive, claims about it, and a closure test that says what it is told to."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from lapped import CLOSURE

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import between
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import Knowledge
from topomap.mapping.closures.drive import Drive
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements, Increments, track
from topomap.mapping.optimizer import OdometryEdges

PLACES = 140
STEP = np.array([0.02, 0.02, 0.01])
Says = Callable[[Claims, Knowledge], FloatArray]


class Told:
    """A test that says what a function does; it keeps what it was asked."""

    name, lowers = "told", False

    def __init__(self, says: Says) -> None:
        self._says = says
        self.heard: list[tuple[Claims, Knowledge]] = []

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        self.heard.append((claims, knowledge))
        return self._says(claims, knowledge)

    def times(self, i: int) -> int:
        """How often it was asked about claims of place i."""
        return sum(int(np.isin(i, claims.i)) for claims, _ in self.heard)


def even(odds: float) -> Told:
    return Told(lambda claims, knowledge: np.full(len(claims), odds))


def by_place(odds: dict[int, float], others: float) -> Told:
    return Told(lambda claims, _: np.array([odds.get(i, others) for i in claims.i.tolist()]))


def straight() -> Drive:
    """A drive that does what its odometry says: steps of 1 m, bending a little."""
    steps = np.tile([1.0, 0.0, 0.02], (PLACES - 1, 1))
    noise = np.tile(np.diag(STEP**2), (len(steps), 1, 1))
    poses = track(Increments(np.arange(len(steps)), steps, noise), Calibration())
    place = np.arange(PLACES)
    increments = EdgeIncrements(steps, noise, place)
    return Drive(poses, OdometryEdges(place[:-1], place[1:], increments))


def claims_on(drive: Drive, i: IntArray, j: IntArray, off: FloatArray | float = 0.0) -> Claims:
    """Claims that the drive's own poses bear out but for an offset (3,) or (n, 3)."""
    relative = between(drive.poses[i], drive.poses[j]) + np.broadcast_to(off, (len(i), 3))
    return Claims.of(i, j, relative, np.tile(np.diag(CLOSURE**2), (len(i), 1, 1)))


def apart(count: int, first: int = 0) -> tuple[IntArray, IntArray]:
    """Pairs of places, none near another pair: each claim is a cluster of its own."""
    return first + 6 * np.arange(count), np.full(count, PLACES - 1)
