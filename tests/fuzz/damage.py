"""Bits flipped and tails cut: what every reader of a log says of it."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from typer.testing import CliRunner

from topomap.cli.main import app
from topomap.core.errors import TopomapError

COMMANDS = {
    "info": ["info", "LOG"],
    "replay": ["replay", "LOG", "--out", "OUT"],
    "report": ["report", "LOG", "--out", "OUT"],
    "export": ["export", "LOG", "--tum", "--out", "OUT"],
    "recover": ["recover", "LOG", "OUT/run.mcap"],
}
SLOWEST_S = 10.0
"""[s] CPU time that a command may take; HANGS_S by the clock, on a machine that does other things too."""
HANGS_S = 120.0
TIMES = re.compile(rb'"steps_per_s": [^,]+|<td>\d+ steps/s</td>|\d+ steps/s')


@dataclass(frozen=True)
class Answer:
    """What a command says of a log: exit code, standard error, all that it printed and wrote; its CPU time [s]."""

    code: int
    said: str
    content: dict[str, bytes]
    seconds: float


def flips(data: bytes, count: int, seed: int = 0) -> Iterator[tuple[str, bytes]]:
    """Yield copies in each of which one bit is another."""
    for bit in np.random.default_rng(seed).integers(0, 8 * len(data), count).tolist():
        changed = bytearray(data)
        changed[bit // 8] ^= 1 << bit % 8
        yield f"bit {bit}", bytes(changed)


def cuts(data: bytes, count: int, seed: int = 0) -> Iterator[tuple[str, bytes]]:
    """Yield copies that end too early, some by a few bytes only."""
    rng = np.random.default_rng(seed)
    tails = [1, 8, 9, 37, 200, *rng.integers(1, len(data), count).tolist()][:count]
    for tail in tails:
        yield f"without its last {tail} bytes", data[:-tail]


def ask(name: str, log: Path, out: Path) -> Answer | str:
    """Return a command's answer, or what is wrong with how it ended: a traceback, more than a line, too long."""
    out.mkdir(parents=True, exist_ok=True)
    words = [word.replace("LOG", str(log)).replace("OUT", str(out)) for word in COMMANDS[name]]
    began, clock = time.process_time(), time.monotonic()
    done = CliRunner().invoke(app, words)
    took, waited = time.process_time() - began, time.monotonic() - clock
    if took > SLOWEST_S or waited > HANGS_S:
        return f"{name} took {took:.0f} s of CPU, {waited:.0f} s by the clock"
    if isinstance(done.exception, TopomapError):  # the program prints it and ends with 2
        text = str(done.exception)
        return Answer(2, text, {}, took) if "\n" not in text else f"{name} says more than a line: {text!r}"
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        return f"{name} raised {type(done.exception).__name__}: {done.exception}"
    if done.stderr.count("\n") > 1:
        return f"{name} says more than a line: {done.stderr!r}"
    return Answer(done.exit_code, done.stderr, _content(done.stdout, out, log), took)


def unsaid(name: str, whole: Answer, found: Answer | str) -> str | None:
    """Return what is wrong with the answer of a command to a damaged log, None where nothing is."""
    if isinstance(found, str):
        return found
    if found.code == 0 and found.said == "" and found.content != whole.content:
        differing = [key for key in whole.content if found.content.get(key) != whole.content[key]]
        return f"{name} says something else without a word: {', '.join(differing)}"
    if found.code not in (0, 2, 3, 4):
        return f"{name} ended with code {found.code}"
    return None


def _content(printed: str, out: Path, log: Path) -> dict[str, bytes]:
    """Return what was printed and written, without paths and what a clock decides."""
    files = {path.name: path.read_bytes() for path in sorted(out.rglob("*")) if path.is_file()}
    kept = {name: TIMES.sub(b"", data) for name, data in files.items() if name not in ("run.mcap", "report.html")}
    text = printed.replace(str(out), "").replace(str(log), "")
    return kept | {"standard output": TIMES.sub(b"", "".join(text.split()).encode())}
