"""Drives with one break, judged by the truth: what counts as noticed, false, joined."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from topomap.app.break_bench import KINDS, BreakTask, draw, plan
from topomap.app.config import load_config
from topomap.bench.breaks import BreakDrive, BreakWatch, rows, tally
from topomap.core.errors import DataError
from topomap.core.geometry import Pose2
from topomap.core.records import Candidate, Decision, Verdict

DEN = str(Path(__file__).parents[1] / "helpers" / "den.toml")
STEP = 250_000_000
BROKE = 30


def out_and_back(k: int) -> Pose2:
    """Twenty steps of 0.4 m ahead, and back to the start beside them."""
    return Pose2(0.4 * k, 0.0, 0.0) if k <= 20 else Pose2(0.4 * (40 - k), 0.2, 0.0)


def decision(k: int, match: int, turn: float = 0.0) -> Decision:
    claim = Candidate(k * STEP, match, match * STEP, Pose2(0.0, 0.0, turn), np.eye(3))
    return Decision(k * STEP, claim, Verdict.ACCEPTED, "")


def driven(
    said: dict[int, str], accepted: tuple[Decision, ...] = (), shift: Pose2 | None = None, broke: int | None = BROKE
) -> BreakDrive:
    """Forty steps; the map holds each as a node, those from step 30 on moved by `shift`."""
    watch = BreakWatch()
    for k in range(41):
        now = tuple(d for d in accepted if d.stamp_ns == k * STEP)
        record: Any = SimpleNamespace(
            change=SimpleNamespace(broken=said.get(k, ""), mended="", decisions=now), where=SimpleNamespace(event="")
        )
        reading: Any = SimpleNamespace(stamp_ns=k * STEP)
        watch.observe(reading, record, out_and_back(k))
    moved = shift or Pose2()
    topo = SimpleNamespace(
        nodes=[SimpleNamespace(stamp_ns=k * STEP) for k in range(41)],
        pose=lambda k: moved @ out_and_back(k) if k >= BROKE else out_and_back(k),
    )
    mapper: Any = SimpleNamespace(map=topo, ledger=SimpleNamespace(decisions=list(accepted)))
    return watch.judged("den", 0, "slip", 1.0, (), None if broke is None else broke * STEP, mapper)


def test_noticed_is_the_true_way_from_the_break_to_the_first_word_behind_it() -> None:
    found = driven({12: "too early", 34: "slipped", 36: "again"})
    assert found.noticed == pytest.approx(1.6)
    assert found.told
    assert found.early == 1
    assert [text.split(": ")[1] for text in found.said] == ["too early", "slipped", "again"]


def test_later_than_five_metres_counts_only_before_a_closure_across_the_break() -> None:
    late = {36: "slipped"}
    assert driven(late, broke=20).noticed == pytest.approx(6.4, abs=0.1)
    assert not driven(late, broke=20).told
    assert not driven(late, (decision(35, 5),), broke=20).told
    assert driven(late, (decision(37, 3),), broke=20).told
    assert driven({}, (decision(37, 3),), broke=20).noticed is None
    assert not driven({}, (decision(37, 3),), broke=20).told


def test_a_closure_is_false_by_distance_or_turn_and_the_last_verdict_is_the_maps() -> None:
    good, far, turned = decision(38, 2), decision(38, 6), decision(37, 3, math.radians(25.0))
    found = driven({}, (good, far, turned))
    assert (found.closures, found.false, found.ever_false) == (3, 2, 2)
    assert driven({}, (good,)).false == 0


def test_a_map_is_joined_where_the_route_seen_again_lies_right_from_there() -> None:
    assert driven({}).joined
    assert driven({}, shift=Pose2(0.0, 0.9)).joined
    assert not driven({}, shift=Pose2(0.0, 1.1)).joined
    assert not driven({}, shift=Pose2(0.0, 0.0, math.radians(25.0))).joined
    alone = driven({}, broke=0)
    assert not alone.again
    assert alone.off is None


def test_drives_without_a_break_count_every_word_as_a_false_alarm() -> None:
    found = driven({3: "a word", 35: "another"}, broke=None)
    assert found.early == 2
    assert found.noticed is None
    assert not found.again
    figures = tally([found, driven({31: "yes"})])
    assert (figures.early, figures.again, figures.told.value) == (2, 1, 0.5)
    assert [row[:2] for row in rows([driven({31: "yes"})])] == [("slip", "1"), ("all breaks", "1")]


def test_every_kind_is_drawn_as_a_setting_that_the_simulator_takes() -> None:
    for kind in KINDS:
        for seed in range(20):
            at, size, word = draw(kind, np.random.default_rng(seed), 100.0, 0.4)
            assert 20.0 <= at <= 70.0
            assert size >= 1.5
            sim = load_config(None, [word]).sim
            assert len(sim.kidnaps) + len(sim.odometry_faults) == 1


def test_all_kinds_meet_all_worlds() -> None:
    tasks = plan(["room-corridor", "hall"], [0, 1], 24, 2, [])
    assert [task.kind for task in tasks[-2:]] == ["none", "none"]
    assert {(task.world, task.kind) for task in tasks[:24]} == {
        (w, k) for w in ("room-corridor", "hall") for k in KINDS
    }
    assert len({task.key for task in tasks}) == 26
    seven = plan(["room-corridor", "hall"] * 3 + ["room-corridor"], [0], 42, 0, [])
    assert {(task.world, task.kind) for task in seven} == {(w, k) for w in ("room-corridor", "hall") for k in KINDS}
    with pytest.raises(DataError, match="name one world"):
        plan([], [0], 1, 0, [])


def test_a_drive_is_made_and_judged() -> None:
    found = BreakTask(DEN, 0, "reset", 0, ("sim.driver.laps=0.6",)).perform()
    assert found.noticed == pytest.approx(0.0, abs=0.11)
    assert (found.false, found.early) == (0, 0)
