"""A sample of what `python -m tests.fuzz` tries by the hundred."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from fuzz.crafted import crafted
from fuzz.damage import COMMANDS, Answer, ask, cuts, flips, unsaid
from fuzz.settings import words, wrong_with
from fuzz.small_log import small_log

DEN = str(Path(__file__).parents[1] / "helpers" / "den.toml")
EVERY = 23


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return small_log(tmp_path_factory.mktemp("log"))


@pytest.fixture(scope="module")
def whole(log: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Answer]:
    found = {name: ask(name, log, tmp_path_factory.mktemp(name)) for name in COMMANDS}
    assert all(isinstance(answer, Answer) and answer.code == 0 and not answer.said for answer in found.values()), found
    return {name: answer for name, answer in found.items() if isinstance(answer, Answer)}


def test_damage_is_said(log: Path, whole: dict[str, Answer], tmp_path: Path) -> None:
    data, bad = log.read_bytes(), tmp_path / "run.mcap"
    for k, (what, damaged) in enumerate([*flips(data, 10), *cuts(data, 5)]):
        bad.write_bytes(damaged)
        name = list(COMMANDS)[k % len(COMMANDS)]
        found = ask(name, bad, tmp_path / f"{k}")
        assert unsaid(name, whole[name], found) is None, what
        assert isinstance(found, Answer)
        assert found.code in (2, 3), f"{what}: {name}"


def test_crafted_logs_are_one_line(log: Path, tmp_path: Path) -> None:
    for k, what in enumerate(crafted(log, tmp_path / "run.mcap")):
        if k % EVERY:
            continue
        name = ("info", "report", "export")[k // EVERY % 3]
        assert isinstance(found := ask(name, tmp_path / "run.mcap", tmp_path / f"{k}"), Answer), f"{what}: {found}"


def test_senseless_settings_are_one_line() -> None:
    tried = [word for k, word in enumerate(words()) if k < 16 or k % (4 * EVERY) == 0]
    assert len(tried) >= 25
    began = time.monotonic()
    assert [wrong for word in tried if (wrong := wrong_with(word, DEN))] == []
    assert time.monotonic() - began < 240
