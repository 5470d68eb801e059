"""A logged drive mapped by the thesis's rule (5.2.4), beside what the closure engine made of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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

    world: str
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


HEAD = ("by", "closures", "false", "recall", "ATE [m]", "online [m]")
"""Columns of `cells`."""
TALLY = ("world", "by", "drives", "closures", "false", "drives with false", "recall", "ATE [m]", "online [m]")
"""Columns of `tally`; recall and ATE as their mean and, in brackets, the least and greatest."""


def cells(row: LoopRow) -> tuple[str, ...]:
    """Return a row's cells, under HEAD."""
    known = (row.false, row.recall, row.ate, row.online)
    plain = ("-" if v is None else f"{v:.2f}" if isinstance(v, float) else str(v) for v in known)
    return row.who, str(row.accepted), *plain


def tally(rows: Sequence[LoopRow]) -> list[tuple[str, ...]]:
    """Return a line for each world and way of closing loops, under TALLY."""
    groups = dict.fromkeys((row.world, row.who) for row in rows)
    return [_tallied([row for row in rows if (row.world, row.who) == group]) for group in groups]


def _tallied(own: list[LoopRow]) -> tuple[str, ...]:
    false = [row.false for row in own if row.false is not None]
    spreads = (
        _spread([v for v in values if v is not None])
        for values in ([r.recall for r in own], [r.ate for r in own], [r.online for r in own])
    )
    closures, wrong = sum(row.accepted for row in own), sum(n > 0 for n in false)
    return own[0].world, own[0].who, str(len(own)), str(closures), str(sum(false)), str(wrong), *spreads


def _spread(values: list[float]) -> str:
    return f"{sum(values) / len(values):.2f} [{min(values):.2f}, {max(values):.2f}]" if values else "-"


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
    return LoopRow(run.world or "-", who, counts.accepted, counts.false, counts.recall, *(known or (None, None)))
