"""The steps of a log, joined by their stamps, as columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from logs import records as log
from logs import topics
from logs.reader import Gathered
from topomap.core.arrays import BoolArray, FloatArray, IntArray

R = TypeVar("R")

TOPICS = (topics.ODOMETRY, topics.BELIEF, topics.DIFFERENCE, topics.MISSION, topics.TRUTH, topics.TIMINGS)


@dataclass(frozen=True)
class Steps:
    """N steps; poses (N, 3); truth None where no step has one."""

    stamps_ns: IntArray
    dead_reckoning: FloatArray
    online: FloatArray
    truth: FloatArray | None
    driven: BoolArray
    contact: BoolArray
    differences: tuple[log.ImageDifference, ...]
    missions: tuple[log.Mission, ...]
    stage_ms: dict[str, FloatArray]

    def difference(self, name: str) -> FloatArray:
        """Return (N,) of one field of the image differences."""
        return np.array([getattr(row, name) for row in self.differences], dtype=np.float64)


def read_steps(rows: Gathered) -> Steps:
    """Return the steps that were logged wholly; a cut off last one is left out.

    rows: at least `TOPICS`. Raises LogError for a message that can't be decoded.
    """
    odometry = _by_stamp(rows, topics.ODOMETRY, log.Odometry)
    beliefs = _by_stamp(rows, topics.BELIEF, log.Belief)
    differences = _by_stamp(rows, topics.DIFFERENCE, log.ImageDifference)
    missions = _by_stamp(rows, topics.MISSION, log.Mission)
    truths = _by_stamp(rows, topics.TRUTH, log.Truth)
    timings = _by_stamp(rows, topics.TIMINGS, log.Timings)
    stamps = [s for s in odometry if s in beliefs and s in differences and s in missions]
    return Steps(
        stamps_ns=np.array(stamps, dtype=np.int64),
        dead_reckoning=_poses([beliefs[s].dead_reckoning for s in stamps]),
        online=_poses([beliefs[s].pose for s in stamps]),
        truth=_poses([truths.get(s) for s in stamps]) if truths else None,
        driven=np.array([odometry[s].driven for s in stamps], dtype=np.bool_),
        contact=np.array([odometry[s].contact for s in stamps], dtype=np.bool_),
        differences=tuple(differences[s] for s in stamps),
        missions=tuple(missions[s] for s in stamps),
        stage_ms=_stage_ms([timings.get(s) for s in stamps]),
    )


def _by_stamp(rows: Gathered, topic: str, kind: type[R]) -> dict[int, R]:
    return dict(rows.records(topic, kind))


def _poses(rows: Sequence[log.Pose | log.Truth | None]) -> FloatArray:
    values = [(np.nan,) * 3 if row is None else (row.x, row.y, row.heading) for row in rows]
    return np.array(values, dtype=np.float64).reshape(-1, 3)


def _stage_ms(timings: Sequence[log.Timings | None]) -> dict[str, FloatArray]:
    """Return the milliseconds (N,) by stage, NaN where a step has none."""
    rows = [{} if one is None else {score.name: score.value for score in one.stages} for one in timings]
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: np.array([row.get(name, np.nan) for row in rows]) for name in names}
