"""Tests run in forked copies of one process, which has everything loaded that isn't tried."""

from __future__ import annotations

import importlib
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

HEAVY = ("numpy", "scipy.optimize", "scipy.spatial", "cv2", "gtsam", "numba", "networkx", "pydantic", "mcap.reader",
         "google.protobuf.message", "typer", "rich.table", "matplotlib.pyplot", "hypothesis", "pymunk")  # fmt: skip
OPTIONS = ["-q", "-p", "no:cacheprovider", "--no-header", "--tb=no"]


def prepare(copied: Path) -> None:
    """Let this process be what the trials are copies of: in the copied repository, with what all tests need."""
    os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
    os.environ["PYTHONPATH"] = str(copied)
    os.chdir(copied)
    own = str(Path(__file__).parents[2])
    sys.path[:] = [str(copied), *(path for path in sys.path if path not in ("", own))]
    sys.dont_write_bytecode = True
    for name in HEAVY:
        importlib.import_module(name)


def passes(tests: list[str], seconds: float) -> bool:
    """Return whether some tests pass within so many seconds of wall clock."""
    return forked(lambda: int(pytest.main([*OPTIONS, "-x", *tests])), seconds) == 0


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
