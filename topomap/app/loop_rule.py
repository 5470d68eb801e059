"""A logged drive mapped by the thesis's rule (5.2.4), beside what the closure engine made of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from topomap.app.stored_run import open_log
from topomap.core.geometry import Pose2
from topomap.core.records import Candidate, Decision, Verdict
from topomap.core.robot import Reading, Robot
from topomap.core.run_data import RunData
from topomap.evaluation.closures import count
from topomap.evaluation.trajectory import ate
from topomap.mapping.difference_mapping import DifferenceMap, DifferenceRuleSettings, map_by_difference
from topomap.recording.run_reader import read_run


@dataclass(frozen=True, slots=True)
class LoopRow:
    """What a way of closing loops made of a drive: closures accepted and false, recall of the possible passes, ATE of
    the final path and of what was known at each step [m]; None without truth.
    """

    who: str
    accepted: int
    false: int | None
    recall: float | None
    ate: float | None
    online: float | None


def compare(log: Path, settings: DifferenceRuleSettings) -> tuple[LoopRow, ...]:
    """Return dead reckoning, the engine as logged, and the rule on the same readings. Raises DataError."""
    run = read_run(log)
    found = map_by_difference(_readings(open_log(log).robot), settings)
    alone = replace(run, decisions=(), final=run.dead_reckoning, online=run.dead_reckoning)
    return _row("dead reckoning", alone), _row("engine", run), _row("rule of 5.2.4", as_run(run, found))


def as_run(run: RunData, found: DifferenceMap) -> RunData:
    """Return a run as the rule would have left it, judged by the same places and the same truth."""
    count_steps = len(run.stamps_ns)
    decisions = tuple(
        Decision(int(run.stamps_ns[c.now]), _candidate(run, c.now, c.old, c.rotation), Verdict.ACCEPTED, "alike")
        for c in found.closures
        if c.now < count_steps
    )
    return replace(run, decisions=decisions, final=found.poses[:count_steps], online=found.online[:count_steps])


def _candidate(run: RunData, now: int, old: int, rotation: float) -> Candidate:
    sure = np.diag([0.25, 0.25, 0.05])
    return Candidate(int(run.stamps_ns[now]), old, int(run.stamps_ns[old]), Pose2(0.0, 0.0, rotation), sure)


def _readings(robot: Robot) -> Iterator[Reading]:
    while (reading := robot.sense()) is not None:
        yield reading


def _row(who: str, run: RunData) -> LoopRow:
    counts = count(run)
    known = None if run.truth is None else [ate(poses, run.truth) for poses in (run.final, run.online)]
    return LoopRow(who, counts.accepted, counts.false, counts.recall, *(known or (None, None)))
