"""Which tests run which line of the source, and how long each takes: measured once, before anything is changed."""

from __future__ import annotations

import json
import time
from collections import defaultdict
from collections.abc import Generator
from dataclasses import dataclass, field
from pathlib import Path

import coverage
import pytest
from numba.core import event

FOLDERS = ("topomap", "logs")


@dataclass
class Cover:
    """seconds of each test, the fixtures that it shares with others among them; the tests that run each line,
    `file:line`, themselves or in a fixture that they use.
    """

    seconds: dict[str, float] = field(default_factory=dict)
    lines: dict[str, list[str]] = field(default_factory=dict)

    def running(self, file: str, lines: range) -> set[str]:
        """Return the tests that run one of some lines."""
        return {test for line in lines for test in self.lines.get(f"{file}:{line}", ())}


class Compiling(event.Listener):
    """Counts the CPU time [s] that numba spends on compiling: the first test of a kernel isn't slow for it."""

    def __init__(self) -> None:
        self.seconds, self._began = 0.0, list[float]()

    def on_start(self, event: object) -> None:
        self._began.append(time.process_time())

    def on_end(self, event: object) -> None:
        began = self._began.pop()
        self.seconds += 0.0 if self._began else time.process_time() - began


class Measuring:
    """A pytest plugin: a line that a fixture runs for many tests counts for each that uses it."""

    def __init__(self, root: Path) -> None:
        self._root = root
        self._coverage = coverage.Coverage(data_file=None, config_file=False, source=[str(root / f) for f in FOLDERS])
        self._fixtures: dict[str, set[str]] = {}
        self._taken: dict[str, float] = {}  # CPU time of shared fixtures [s]
        self._shared, self._current = 0.0, ""
        self._compiling = Compiling()
        event.register("numba:compile", self._compiling)
        self.cover = Cover()

    def _now(self) -> float:
        return time.process_time() - self._compiling.seconds

    def pytest_collection_finish(self) -> None:
        self._coverage.start()

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, None, None]:
        began, self._shared = self._now(), 0.0
        self._fixtures[item.nodeid] = set()
        self._coverage.switch_context(item.nodeid)
        yield
        self.cover.seconds[item.nodeid] = self._now() - began - self._shared

    @pytest.hookimpl(hookwrapper=True)
    def pytest_fixture_setup(self, fixturedef, request) -> Generator[None, None, None]:
        name, began, before = f"fixture {fixturedef.baseid} {fixturedef.argname}", self._now(), self._shared
        if fixturedef.scope == "function":
            yield
            return
        self._coverage.switch_context(name)
        yield
        self._coverage.switch_context(self._current)
        self._taken[name] = self._now() - began - (self._shared - before)
        self._shared += self._taken[name]

    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        self._current = item.nodeid
        definitions = item._fixtureinfo.name2fixturedefs  # type: ignore[attr-defined]
        for every in definitions.values():
            self._fixtures[item.nodeid] |= {f"fixture {one.baseid} {one.argname}" for one in every}

    def pytest_sessionfinish(self) -> None:
        self._coverage.stop()
        data = self._coverage.get_data()
        users: dict[str, set[str]] = defaultdict(set)
        for test, fixtures in self._fixtures.items():
            self.cover.seconds[test] += sum(self._taken.get(one, 0.0) for one in fixtures)
            for one in (*fixtures, test):
                users[one].add(test)
        for path in data.measured_files():
            file = str(Path(path).relative_to(self._root))
            for line, contexts in data.contexts_by_lineno(path).items():
                tests = {test for context in contexts for test in users.get(context, ())}
                if tests:
                    self.cover.lines[f"{file}:{line}"] = sorted(tests)


def measure(root: Path, tests: tuple[str, ...], out: Path) -> int:
    """Run some tests and write what they cover into a file; 0: all passed."""
    plugin = Measuring(root)
    code = pytest.main(["-q", "-p", "no:cacheprovider", "--no-header", *tests], plugins=[plugin])
    out.write_text(json.dumps({"seconds": plugin.cover.seconds, "lines": plugin.cover.lines}), encoding="utf8")
    return int(code)


def read(path: Path) -> Cover:
    """Return what `measure` wrote."""
    return Cover(**json.loads(path.read_text(encoding="utf8")))
