"""Which tests run which functions: a pytest plugin, and the choice of tests for a mutant."""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

import pytest

from mutation.mutants import Mutant

Place = tuple[str, int]


@dataclass
class Reach:
    """Seconds that each test took, and the tests that ran each function: file and first line; line 0: any of a file.

    failed: what fails without any mutant, as tests of deadlines do on a busy machine: these are left out.
    """

    seconds: dict[str, float] = field(default_factory=dict)
    tests: dict[Place, set[str]] = field(default_factory=dict)
    failed: set[str] = field(default_factory=set)

    def of(self, mutant: Mutant, importers: dict[str, set[str]]) -> list[str]:
        """Return the tests that a mutant may fail, the quickest first.

        A constant may be used wherever its module is imported; importers: the files that import each file.
        """
        found = self.tests.get((mutant.file, mutant.function), set()) if mutant.function else set()
        if not found:  # compiled functions aren't seen either
            files = {mutant.file, *importers.get(mutant.file, ())}
            found = {test for file in files for test in self.tests.get((file, 0), ())}
        found = found - self.failed
        return sorted(found, key=lambda test: (self.seconds.get(test, 0.0), test))


class ReachPlugin:
    """Notes, test by test, which functions of the repository are called; a module's fixtures count for its tests."""

    def __init__(self, root: Path) -> None:
        self.reach = Reach()
        self._root = f"{root}/"
        self._called: set[tuple[str, int]] = set()
        self._shared: dict[str, set[tuple[str, int]]] = defaultdict(set)

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(
        self, fixturedef: pytest.FixtureDef[object], request: pytest.FixtureRequest
    ) -> Iterator[None]:
        before, self._called = self._called, set()
        try:
            return (yield)
        finally:
            if fixturedef.scope != "function":
                self._shared[request.node.nodeid.split("::")[0]] |= self._called
            self._called |= before

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self._called = set()
        sys.setprofile(self._profile)
        try:
            return (yield)
        finally:
            sys.setprofile(None)
            for file, line in self._called | self._shared[item.nodeid.split("::")[0]]:
                for place in ((file, line), (file, 0)):
                    self.reach.tests.setdefault(place, set()).add(item.nodeid)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.reach.failed.add(report.nodeid)
        self.reach.seconds[report.nodeid] = self.reach.seconds.get(report.nodeid, 0.0) + report.duration

    def _profile(self, frame: FrameType, event: str, _: object) -> None:
        if event == "call" and frame.f_code.co_filename.startswith(self._root):
            self._called.add((frame.f_code.co_filename[len(self._root) :], frame.f_code.co_firstlineno))


def importers(root: Path, packages: tuple[str, ...]) -> dict[str, set[str]]:
    """Return, for each source file, the files that import it by name."""
    found: dict[str, set[str]] = defaultdict(set)
    for path in (path for package in packages for path in (root / package).rglob("*.py")):
        for line in path.read_text(encoding="utf8").splitlines():
            if line.startswith("from ") and " import " in line:
                module = line.split()[1].replace(".", "/")
                found[f"{module}.py"].add(str(path.relative_to(root)))
    return found
