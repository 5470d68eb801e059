"""What all tests share: the folder of recorded data, and a count of the tests that needed it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from topomap.report.figures.catalogue import FIGURES

ROOT = Path(__file__).resolve().parent.parent
outcomes = {"ran": 0, "skipped": 0}
LONGEST = ("tests/test_readme.py", "tests/test_examples.py", "tests/test_whole_run.py")


@pytest.fixture(scope="module", autouse=True)
def one_picture(request: pytest.FixtureRequest) -> Iterator[None]:
    """Let reports that tests write in this process hold one picture; all ten, 3 s a
    report, are looked at in tests/report."""
    if request.path.is_relative_to(ROOT / "tests" / "report"):
        yield
        return
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("topomap.report.report.FIGURES", FIGURES[:1])
        yield


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder that TOPOMAP_DATA names (default ../shared/data beside the repository); skips without it."""
    named = os.environ.get("TOPOMAP_DATA")
    folder = Path(named) if named else ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"no recorded data at {folder}: set TOPOMAP_DATA to its folder")
    return folder


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the longest, so that no worker is left alone with it at the end."""
    items.sort(key=lambda item: not item.nodeid.startswith(LONGEST))


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Count the tests marked `data` by whether they ran (reports reach the controller of -n too)."""
    if "data" not in report.keywords:
        return
    if report.skipped:
        outcomes["skipped"] += 1
    elif report.when == "call":
        outcomes["ran"] += 1


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say how many tests on recorded data ran."""
    ran, skipped = outcomes["ran"], outcomes["skipped"]
    terminalreporter.write_line(f"tests on recorded data (TOPOMAP_DATA): {ran} ran, {skipped} skipped")
