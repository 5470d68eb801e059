"""Tests run in forked copies of one process, which has everything loaded that isn't tried."""

from __future__ import annotations

import gc
import importlib
import os
import signal
import sys
import time
from collections.abc import Callable
from contextlib import redirect_stdout
from pathlib import Path

import pytest

HEAVY = ("numpy", "scipy.optimize", "scipy.spatial", "cv2", "gtsam", "numba", "networkx", "pydantic", "mcap.reader",
         "google.protobuf.message", "typer", "rich.table", "matplotlib.pyplot", "hypothesis", "pymunk")  # fmt: skip
MOST = 8
OPTIONS = ["-q", "-p", "no:cacheprovider", "--no-header", "--tb=no", "--durations=0"]


def prepare(copied: Path) -> None:
    """Let this process be what the trials are copies of: in the copied repository, with what all tests need."""
    os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
    os.environ["PYTHONPATH"] = os.pathsep.join((str(copied), os.environ.get("PYTHONPATH", "")))
    os.chdir(copied)
    own = str(Path(__file__).parents[2])
    sys.path[:] = [str(copied), *(path for path in sys.path if path not in ("", own))]
    sys.dont_write_bytecode = True
    for name in HEAVY:
        importlib.import_module(name)


def load(root: Path, tests: tuple[str, ...]) -> None:
    """Import all tests and the whole source, so that the copies need not."""
    for package in ("topomap", "sim2d", "logs"):
        for path in sorted((root / package).rglob("[!_]*.py")):
            importlib.import_module(str(path.relative_to(root).with_suffix("")).replace("/", "."))
    with Path(os.devnull).open("w") as quiet, redirect_stdout(quiet):
        if pytest.main([*OPTIONS, "--collect-only", "-qq", *tests]) != 0:
            raise RuntimeError("the tests can't be collected")
    gc.collect()
    gc.freeze()  # pytest collects garbage five times a run, and a copy would have to look through all of this


class Chosen:
    """A pytest plugin: these tests, in this order; one that takes longer than so many seconds says nothing.

    Nor do those that come after MOST times as long.
    """

    def __init__(self, order: list[str], each_s: float | None = None) -> None:
        self._order = {test: k for k, test in enumerate(order)}
        self._each_s = each_s
        self._began = time.process_time()
        self.failed = ""

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed = report.nodeid

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        chosen = [item for item in items if self._place(item) is not None]
        items[:] = sorted(chosen, key=lambda item: self._place(item) or 0)

    def _place(self, item: pytest.Item) -> int | None:
        """Return where a test stands in the order; a whole file may stand there too."""
        return self._order.get(item.nodeid, self._order.get(item.nodeid.split("::")[0]))

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_call(self):
        if self._each_s is not None and time.process_time() - self._began > MOST * self._each_s:
            pytest.skip("says nothing in the time")
        if self._each_s is not None:
            signal.signal(signal.SIGALRM, _too_long)
            signal.setitimer(signal.ITIMER_REAL, self._each_s)
        yield
        signal.setitimer(signal.ITIMER_REAL, 0)


def _too_long(*_: object) -> None:
    pytest.skip("says nothing in the time")


def noticed(tests: list[str], change: Callable[[], None], seconds: float, each_s: float | None = None) -> str:
    """Return which of some tests fails once a copy of this process has been changed, "" where none does.

    Where they can't be run any more, or never end, a word for that.
    """
    told, tell = os.pipe()

    def work() -> int:
        change()
        files, chosen = list(dict.fromkeys(test.split("::")[0] for test in tests)), Chosen(tests, each_s)
        code = int(pytest.main([*OPTIONS, "-x", *files], plugins=[chosen]))
        os.write(tell, chosen.failed.encode())
        return code

    code = forked(work, seconds)
    os.set_blocking(told, False)  # what a test has started may hold the other end
    with os.fdopen(told, "rb", 0) as answer, os.fdopen(tell, "wb", 0):
        return "" if code == 0 else (answer.read() or b"all").decode()


def forked(work: Callable[[], int], seconds: float) -> int:
    """Return the exit code of work done in a copy of this process; -1: it took too long and was ended."""
    number = os.fork()
    if number == 0:
        os.setsid()
        quiet = os.open(os.devnull, os.O_WRONLY)
        os.dup2(quiet, 1)
        os.dup2(quiet, 2)
        code = 70
        try:
            code = work()
        finally:
            os._exit(code)
    last = time.monotonic() + seconds
    while time.monotonic() < last:
        done, status = os.waitpid(number, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.02)
    os.killpg(number, signal.SIGKILL)
    os.waitpid(number, 0)
    return -1
