"""A recorded drive, a pose graph and a robot: their verdicts come out of the same engine."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drives import laps, write_recording

from topomap.app.config import load_config
from topomap.app.runs import open_world
from topomap.app.wiring import build_navigator
from topomap.core.arrays import FloatArray
from topomap.core.records import Decision, Verdict
from topomap.datasets.g2o import read_graph
from topomap.datasets.tuc.mapping import map_tuc
from topomap.datasets.tuc.recording import read_tuc
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import Knowledge
from topomap.mapping.closures.engine import ClosureEngine, Weighed
from topomap.mapping.graph_engine import optimise_graph
from topomap.navigation.runner import run

ROOT = Path(__file__).parents[1]
DEN = str(ROOT / "tests" / "helpers" / "den.toml")


class Watched:
    """What the engine said while it was watched: odds of all weighed claims, and its decisions."""

    def __init__(self) -> None:
        self.weighed: list[Weighed] = []
        self.decisions: list[Decision] = []

    @property
    def odds(self) -> FloatArray:
        return np.concatenate([weighed.log_odds for weighed in self.weighed])


@contextmanager
def watching(monkeypatch: pytest.MonkeyPatch) -> Iterator[Watched]:
    seen = Watched()
    weigh, decide = ClosureEngine.weigh, ClosureEngine.decide

    def weighing(self: ClosureEngine, *args: object) -> Weighed:
        seen.weighed.append(weigh(self, *args))  # type: ignore[arg-type]
        return seen.weighed[-1]

    def deciding(self: ClosureEngine, *args: object) -> Decision:
        seen.decisions.append(decide(self, *args))  # type: ignore[arg-type]
        return seen.decisions[-1]

    with monkeypatch.context() as patch:
        patch.setattr(ClosureEngine, "weigh", weighing)
        patch.setattr(ClosureEngine, "decide", deciding)
        yield seen


def test_a_pose_graphs_verdicts_are_the_engines(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = read_graph(ROOT / "examples" / "graphs" / "block-doubtful.g2o")
    with watching(monkeypatch) as seen:
        found = optimise_graph(graph)
    assert found.inlier.any()
    assert not found.inlier.all()
    assert set(found.log_odds[np.isfinite(found.log_odds)]) <= set(seen.odds)
    assert found.log_odds[found.inlier].min() > 0.0


def test_a_recorded_drives_verdicts_are_the_engines(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    recording = read_tuc(write_recording(tmp_path, laps()[0]))
    with watching(monkeypatch) as seen:
        made = map_tuc(recording)
    assert list(made.decisions) == seen.decisions
    assert sum(decision.verdict is Verdict.ACCEPTED for decision in made.decisions) > 50
    assert len(seen.odds) > 50


def test_a_robots_verdicts_are_the_engines(monkeypatch: pytest.MonkeyPatch) -> None:
    config = load_config(None, ["stack.mission.then=stop"])
    robot, navigator = open_world(DEN, 1, config), build_navigator(config.stack)
    with watching(monkeypatch) as seen:
        run(robot, navigator)
    accepted = [d for d in seen.decisions if d.verdict is Verdict.ACCEPTED]
    assert accepted
    ledger = navigator.mapper.ledger.decisions
    assert [d for d in ledger if d in seen.decisions] == seen.decisions
    assert {d.candidate.evidence.odds for d in accepted} <= set(seen.odds.tolist())


def test_a_users_own_test_speaks_in_the_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    class Never:
        name, lowers = "never", True

        def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
            return np.full(len(claims), -np.inf)

    config = load_config(None, ["stack.mission.then=stop"])
    robot, navigator = open_world(DEN, 1, config), build_navigator(config.stack, [Never()])
    run(robot, navigator)
    decisions = navigator.mapper.ledger.decisions
    assert not navigator.mapper.ledger.accepted
    assert any("the test 'never' speaks against it" in d.reason for d in decisions)
    assert all(replace(d.candidate.evidence, odds=None) == d.candidate.evidence for d in decisions)
